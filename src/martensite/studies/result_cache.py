"""Cache of slow results on disk, valid for the same program only.

The name of a result contains the arguments, all source of `martensite`, and the versions of numerical packages.
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
"""Endings of files with an effect on results."""
WORDS = ("claims.toml", "results.json")
"""Files of studies without an effect on results."""
COMPUTING = ("numpy", "scipy")
UNREADABLE = (OSError, EOFError, pickle.UnpicklingError, AttributeError, ImportError, IndexError, ValueError)
"""Errors of `pickle` for a foreign file."""
PROGRAMS = 3
"""Number of program versions whose results are kept."""


def cache_results(function: Function) -> Function:
    """Return a pure function with cached results, in memory and on disk if possible.

    Arguments and results must work with `pickle`; arguments must be hashable.
    """

    @cache
    @wraps(function)
    def cached(*arguments: Any, **named: Any) -> Any:
        digest = hashlib.sha256(pickle.dumps((arguments, named))).hexdigest()[:16]
        name = f"{function.__module__}.{function.__qualname__}-{digest}.pickle"
        with suppress(*UNREADABLE):
            path = find_program_folder() / name
            if is_private_file(path):  # a pickle runs code
                return pickle.loads(path.read_bytes())
        result = function(*arguments, **named)
        with suppress(OSError):
            _store_result(result, find_program_folder() / name)
        return result

    return cached  # type: ignore[return-value]


def _store_result(result: Any, path: Path) -> None:
    if not any(path.parent.iterdir()):
        others = sorted(path.parent.parent.iterdir(), key=lambda one: one.stat().st_mtime)
        for old in others[:-PROGRAMS]:
            shutil.rmtree(old, ignore_errors=True)
    new_path = path.with_suffix(f".{os.getpid()}")
    new_path.write_bytes(pickle.dumps(result))
    keep_private(new_path, path)


def find_program_folder() -> Path:
    """Return the folder of this program's results; raise `OSError` if it is missing or not trusted."""
    return make_cache("studies", _fingerprint_program())


@cache
def _fingerprint_program() -> str:
    digest = hashlib.sha256(platform.python_version().encode() + platform.machine().encode())
    for name in COMPUTING:
        digest.update(version(name).encode())
    for root in map(Path, (*martensite.__path__, *martensite.studies.__path__, EXAMPLES)):
        for path in sorted(path for path in root.rglob("*") if path.suffix in SOURCES and path.name not in WORDS):
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
