"""Packages that a sweep needs beyond those of every run: `pip install martensite[sweep]`."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from martensite.base.errors import InputError

_NAMES = {"SALib": "SALib", "zarr": "Zarr"}


def import_extra(module: str) -> Any:
    """A module of such a package.

    Raises:
        InputError: the package is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise InputError(
            f"This needs {_NAMES.get(name, name)}, which is not installed; run "
            "`pip install martensite[sweep]`."
        ) from None
