"""Atomic file writing, size-limited reading, and TOML documents."""

from __future__ import annotations

import codecs
import errno
import os
import stat
import sys
import tomllib
from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from martensite.base.errors import DataError, suggest_name
from martensite.base.interrupts import hold_interrupts, rescue_answer

_unfinished: dict[Path, int] = {}
"""Incomplete files -> process that writes them."""
_held: ContextVar[dict[Path, Path] | None] = ContextVar("_held", default=None)
"""Completed files of a group that is written together -> final paths."""


@contextmanager
def replace_file(path: Path) -> Generator[Path]:
    """Yield a temporary path next to `path`; the file replaces `path` when the block ends without an error.

    An incomplete file is removed on failure and on SIGTERM.

    Raises:
        DataError: the folder does not exist or the file cannot be written.
    """
    try:
        if not path.parent.is_dir():
            raise DataError(f"The folder of `{path}` does not exist; create it first.")
    except OSError as error:  # a name that is too long
        raise _describe_failure(path, error) from None
    part, pending_parts = path.with_name(f".{path.name[:40]}.{os.urandom(4).hex()}.part"), _held.get()
    _unfinished[part] = os.getpid()
    try:
        with _catch_termination(), rescue_answer(lambda: _remove_part(part) or ""):
            yield part
            if pending_parts is None:
                part.replace(path)
            else:
                pending_parts[part] = path
    except OSError as error:
        raise _describe_failure(path, error) from error
    finally:
        if pending_parts is None or part not in pending_parts:
            _remove_part(part)


@contextmanager
def replace_together() -> Generator[None]:
    """Replace all files written in this block when it ends, or none if it fails.

    Raises:
        DataError: a file cannot be written.
    """
    pending_parts: dict[Path, Path] = {}
    token = _held.set(pending_parts)

    def remove_parts() -> str:
        for part in pending_parts:
            _remove_part(part)
        return ""

    try:
        with _catch_termination(), rescue_answer(remove_parts):
            yield
            with hold_interrupts():
                for part, path in pending_parts.items():
                    try:
                        part.replace(path)
                    except OSError as error:
                        raise _describe_failure(path, error) from error
    finally:
        _held.reset(token)
        remove_parts()


def write_file(path: str | os.PathLike[str], content: str | bytes | memoryview) -> None:
    """Write a file atomically; text is encoded in UTF-8 with unchanged line ends.

    Raises:
        DataError: the folder does not exist or the file cannot be written.
    """
    with replace_file(Path(path)) as part:
        part.write_bytes(content.encode() if isinstance(content, str) else content)


def make_folder(path: Path) -> None:
    """Create a folder and its parents if missing; `DataError` if that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"Cannot make the folder `{path}`: {error.strerror}.") from None


def _describe_failure(path: Path, error: OSError) -> DataError:
    return DataError(f"The file `{path}` could not be written: {error.strerror or error}.")


def _remove_part(part: Path) -> None:
    _unfinished.pop(part, None)
    part.unlink(missing_ok=True)


@contextmanager
def _catch_termination() -> Generator[None]:
    """Remove incomplete files on SIGTERM, unless the program handles this signal."""
    import signal
    import threading

    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def end_process(number: int, frame: object) -> None:
        for part, writer in _unfinished.items():
            if writer == os.getpid():  # a copy of this process has them in its table as well
                part.unlink(missing_ok=True)
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)

    signal.signal(signal.SIGTERM, end_process)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


MOST_TEXT = 2**26
"""Size limit of scenario, material, fit and model files [bytes]."""
SPECIAL = 2**20
"""Limit for files of the system, which give their size as zero [bytes]."""
MOST_LOG = 2**31
"""Size limit of logs [bytes]."""


def check_ordinary(path: Path, most: int) -> int:
    """Return the size of a regular file [bytes], after a check of its upper limit.

    Raises:
        OSError: the file does not exist.
        DataError: it is too large, its name is invalid, or it is a device or a pipe.
    """
    try:
        status = path.stat()
    except ValueError:
        raise DataError(f"No file has the name `{str(path)!r}`.") from None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise DataError(f"`{path}` is a device or a pipe; name an ordinary file.")
    if status.st_size > most:
        raise DataError(f"`{path}` is larger than the {most / 2**20:.0f} MiB that are read of it.")
    return status.st_size


def read_bounded(path: Path, most: int) -> bytes:
    """Return the content of a regular file of at most `most` bytes.

    Raises:
        OSError: the file cannot be read.
        DataError: see `check_ordinary`.
    """
    size = max(check_ordinary(path, most), SPECIAL)
    with path.open("rb") as file:
        return file.read(min(size, most))  # `read` reserves as much memory as is asked for


def read_unpacked(path: Path, most: int) -> bytes:
    """Return the content of a regular file, unpacked if its name ends in `.gz`; at most `most` bytes.

    Raises:
        OSError: the file cannot be read.
        DataError: see `check_ordinary`; also for unpacked content that is too large or damaged.
    """
    raw = read_bounded(path, most)
    if path.suffix.lower() != ".gz":
        return raw
    import zlib

    unpack = zlib.decompressobj(31)
    try:
        content = unpack.decompress(raw, most)
    except zlib.error as error:
        raise DataError(f"`{path.name}` cannot be unpacked: {error}.") from None
    if not unpack.eof:
        reason = "holds more than is read of a file" if unpack.unconsumed_tail else "is cut short"
        raise DataError(f"`{path.name}` cannot be unpacked: it {reason}.")
    return content


def read_text_file(path: Path, what: str) -> str:
    """Return the text of a UTF-8 file; `what` names the kind of file in errors.

    Raises:
        DataError: the file is missing or cannot be read; the sentence suggests the nearest file name.
    """
    try:
        raw = read_bounded(path, MOST_TEXT)
        if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            raise DataError(f"The {what} file `{path}` is written in UTF-16; save it as UTF-8.")
        return raw.decode("utf-8-sig")  # Windows Notepad puts a mark in front
    except FileNotFoundError:
        beside = [other.name for other in sorted(path.parent.glob(f"*{path.suffix}"))[:10]]
        nearest = suggest_name(path.name, beside) if path.suffix and beside else ""
        raise DataError(f"There is no {what} file `{path}`. {nearest}".strip()) from None
    except UnicodeDecodeError as error:
        raise DataError(f"The {what} file `{path}` is not UTF-8 (byte {error.start}); save it as UTF-8.") from None
    except OSError as error:
        raise DataError(f"Cannot read the {what} file `{path}`: {error}.") from None


def toml_document(text: str, name: str = "The scenario") -> dict[str, Any]:
    """Return a parsed TOML text; raise `DataError`, which calls it `name`, if it is invalid."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise DataError(f"{name} is not valid TOML: it is nested too deeply.") from None
    except tomllib.TOMLDecodeError as error:
        raise DataError(
            f"{name} is not valid TOML: {error}; "
            'put text and quantities in double quotes, such as `diameter = "0.381 mm"`.'
        ) from None


_TOLD: set[str] = set()


def tell_once(line: str) -> None:
    """Print a line to standard error, once per process."""
    if line not in _TOLD:
        _TOLD.add(line)
        sys.stderr.write(f"{line}\n")
