"""Ways out: martensite elements in the programs of others.

They are the distribution `martensite-export`, which is imported when a name of it is first used.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from martensite.base.lazy import import_extra


def __getattr__(name: str) -> Any:
    """A public name of `martensite_export`; `InputError` says what brings it where it is absent."""
    if name.startswith("_"):  # asked for by import machinery and by consoles: no name of it
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_extra("martensite_export", "export", "`martensite-export`"), name)


def __dir__() -> list[str]:
    return dir(import_extra("martensite_export", "export")) if find_spec("martensite_export") else []
