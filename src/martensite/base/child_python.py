"""Start Python child processes that never import from the current folder.

`python -m` and `python -c` put the current folder first on the module path, where a file such as `numpy.py` next to a
log would be executed. Child processes are therefore started with `-P`, or within `safe_children`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

_SAFE = "PYTHONSAFEPATH"


def python_command(*words: str) -> list[str]:
    """Return the command that starts this interpreter with `-P` and further words, such as `"-m"` and a module."""
    return [sys.executable, "-P", *words]


def python_environment(**settings: str) -> dict[str, str]:
    """Return the environment of a child process: the module path without the current folder, and `settings`."""
    paths = (path for path in sys.path if path and not _is_current(path))
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)} | settings


@contextmanager
def safe_children() -> Generator[None]:
    """Prevent child processes started in this block, by any library, from importing from the current folder."""
    before = os.environ.get(_SAFE)
    os.environ[_SAFE] = "1"
    try:
        yield
    finally:
        os.environ.pop(_SAFE)
        if before is not None:
            os.environ[_SAFE] = before


def _is_current(path: str) -> bool:
    with suppress(OSError):
        return Path(path).samefile(os.curdir)
    return False
