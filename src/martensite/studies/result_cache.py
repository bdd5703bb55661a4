"""Results that are kept from one run to the next, as what takes long need not be computed twice.

A result is kept in the user's cache folder and found again by the very same program only: its name
holds the arguments, all the source of this package and of `martensite`, and the versions of what
computes.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import martensite
import martensite.studies
from martensite.base.caches import is_private_file, keep_private, make_cache
from martensite.scenario.examples import EXAMPLES

Function = TypeVar("Function", bound=Callable[..., Any])
SOURCES = (".py", ".toml", ".json", ".csv")
"""Endings of files that a result may depend on."""
WORDS = ("claims.toml", "results.json")
"""Files of studies that none depends on."""
COMPUTING = ("numpy", "scipy")
UNREADABLE = (OSError, EOFError, pickle.UnpicklingError, AttributeError, ImportError, IndexError, ValueError)
"""Errors of `pickle` for a file that it did not write."""
PROGRAMS = 3
"""Versions of the program whose results are kept; those of others are removed."""


def cache_results(function: Function) -> Function:
    """Return a pure function whose results are kept: in memory, and on disk if that can be written to.

    Its arguments and results must be such as `pickle` takes, and its arguments hashable.
    """

    @cache
    @wraps(function)
    def found(*arguments: Any, **named: Any) -> Any:
        given = hashlib.sha256(pickle.dumps((arguments, named))).hexdigest()[:16]
        name = f"{function.__module__}.{function.__qualname__}-{given}.pickle"
        with suppress(*UNREADABLE):
            path = find_program_folder() / name
            if is_private_file(path):  # a pickle runs code
                return pickle.loads(path.read_bytes())
        result = function(*arguments, **named)
        with suppress(OSError):
            _store_result(result, find_program_folder() / name)
        return result

    return found  # type: ignore[return-value]


def _store_result(result: Any, path: Path) -> None:
    if not any(path.parent.iterdir()):
        others = sorted(path.parent.parent.iterdir(), key=lambda one: one.stat().st_mtime)
        for old in others[:-PROGRAMS]:
            shutil.rmtree(old, ignore_errors=True)
    made = path.with_suffix(f".{os.getpid()}")
    made.write_bytes(pickle.dumps(result))
    keep_private(made, path)


def find_program_folder() -> Path:
    """Return the folder of the results of this program; raise `OSError` if it is missing or not trusted."""
    return make_cache("studies", _fingerprint_program())


@cache
def _fingerprint_program() -> str:
    """Return a short text that identifies this program and its version."""
    digest = hashlib.sha256(platform.python_version().encode() + platform.machine().encode())
    for name in COMPUTING:
        digest.update(version(name).encode())
    for root in map(Path, (*martensite.__path__, *martensite.studies.__path__, EXAMPLES)):
        for path in sorted(path for path in root.rglob("*") if path.suffix in SOURCES and path.name not in WORDS):
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
