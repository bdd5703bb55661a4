"""Start Python in a child process that never imports from the current folder.

`python -m` and `python -c` put the current folder first on the module path. A file such as `numpy.py`
next to a log would then run as soon as the log is read. Every child of this package is therefore started
with `-P`, or within `safe_children` where a library writes the command.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

_SAFE = "PYTHONSAFEPATH"


def python_command(*words: str) -> list[str]:
    """Return the command that starts this interpreter without the current folder on its module path.

    Args:
        words: further words of the command, such as `"-m"` and a module.
    """
    return [sys.executable, "-P", *words]


def python_environment(**settings: str) -> dict[str, str]:
    """Return the environment of a child that finds modules where this process does, but not in the current folder.

    Args:
        settings: further variables of the environment.
    """
    paths = (path for path in sys.path if path and not _is_current(path))
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)} | settings


@contextmanager
def safe_children() -> Generator[None]:
    """Start no process within this block, by any library, that imports from the current folder."""
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
