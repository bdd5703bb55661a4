"""Files that appear whole or not at all, and the folder for what can be made again."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from martensite.errors import DataError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A new file beside `path` that takes its place once it is complete.

    Raises:
        DataError: the folder does not exist or the file cannot be written.
    """
    if not path.parent.is_dir():
        raise DataError(f"The folder of `{path}` does not exist; create it first.")
    part = path.with_name(f".{path.name}.{os.urandom(4).hex()}.part")
    try:
        yield part
        part.replace(path)
    except OSError as error:
        reason = error.strerror or error
        raise DataError(f"The file `{path}` could not be written: {reason}.") from error
    finally:
        part.unlink(missing_ok=True)


def cache_folder() -> Path:
    """The user's cache folder for this package."""
    if os.environ.get("XDG_CACHE_HOME"):
        return Path(os.environ["XDG_CACHE_HOME"]) / "martensite"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "martensite"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "martensite" / "Cache"
    return Path.home() / ".cache" / "martensite"
