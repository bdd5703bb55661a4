"""Files that appear whole or not at all, documents, and the folder for what can be made again."""

from __future__ import annotations

import os
import sys
import tomllib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from martensite.base.errors import DataError, suggest_name


@contextmanager
def replace_file(path: Path) -> Generator[Path]:
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


MOST_TEXT = 2**26
"""Bytes of a scenario, a material, a fit or a model."""
MOST_LOG = 2**31
"""Bytes of a log."""


def read_bounded(path: Path, most: int) -> bytes:
    """The bytes of an ordinary file, of which there are at most so many.

    Raises:
        OSError: it cannot be read.
        DataError: it is larger, or a device or a pipe, which may never end.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise DataError(f"`{path}` is a device or a pipe; name an ordinary file.")
    with path.open("rb") as file:
        found = file.read(most + 1)
    if len(found) > most:
        raise DataError(f"`{path}` is larger than the {most / 2**20:.0f} MiB that are read of it.")
    return found


def read_text_file(path: Path, what: str) -> str:
    """The text of a UTF-8 file; `what` says in an error which kind of file it is.

    Raises:
        DataError: it is missing, with the nearest name beside it, or cannot be read.
    """
    try:
        return read_bounded(path, MOST_TEXT).decode("utf-8")
    except FileNotFoundError:
        beside = [other.name for other in sorted(path.parent.glob(f"*{path.suffix}"))[:10]]
        nearest = suggest_name(path.name, beside) if path.suffix and beside else ""
        raise DataError(f"There is no {what} file `{path}`. {nearest}".strip()) from None
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"Cannot read the {what} file `{path}`: {error}.") from None


def toml_document(text: str, name: str = "The scenario") -> dict[str, Any]:
    """The document in a text; `name` is how an error calls it.

    Raises:
        DataError: it is not TOML.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise DataError(f"{name} is not valid TOML: it is nested too deeply.") from None
    except tomllib.TOMLDecodeError as error:
        raise DataError(
            f"{name} is not valid TOML: {error}; "
            'text and quantities stand in double quotes, such as `diameter = "0.381 mm"`.'
        ) from None


def cache_folder() -> Path:
    """The user's cache folder for this package."""
    if os.environ.get("XDG_CACHE_HOME"):
        return Path(os.environ["XDG_CACHE_HOME"]) / "martensite"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "martensite"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "martensite" / "Cache"
    return Path.home() / ".cache" / "martensite"


_TOLD: set[str] = set()


def tell_once(line: str) -> None:
    """Say on standard error, once in a process, that something went another way than it should."""
    if line not in _TOLD:
        _TOLD.add(line)
        sys.stderr.write(f"{line}\n")
