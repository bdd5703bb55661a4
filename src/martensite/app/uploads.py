"""Folder of a server: uploaded files, and files for download.

Names from outside are never used as paths. Each file is in a separate folder with a generated name, and its cleaned
name contains no path.
"""

from __future__ import annotations

import re
import secrets
import unicodedata
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from martensite.app.messages import Refusal
from martensite.base.errors import DataError

MOST_BYTES = 64 * 2**20
"""Largest size of one file [bytes]."""
MOST_IN_ALL = 2**30
"""Largest size of all uploads of a server [bytes]."""
LONGEST_NAME = 160
"""Bytes; some file systems allow at most 255."""
_KEY = re.compile(r"[0-9a-f]{16}")
_UNSAFE = re.compile(r"[^\w.() -]+")
_RESERVED = re.compile(r"(con|prn|aux|nul|conin|conout|com[\d¹²³]|lpt[\d¹²³])(\W|$)", re.IGNORECASE)
"""Names of devices, with any ending."""


def make_key() -> str:
    """Return an unguessable key."""
    return secrets.token_hex(8)


def is_key(text: str) -> bool:
    """Return whether a text from outside has the form of a key."""
    return bool(_KEY.fullmatch(text))


def clean_name(name: str) -> str:
    """Return a name without characters that could form a path or hide the file."""
    last = unicodedata.normalize("NFC", name).replace("\\", "/").rpartition("/")[2]
    safe_name = _UNSAFE.sub("_", last).strip(" .")
    stem, dot, ending = safe_name.rpartition(".")
    short = f"{_shorten_text(stem)}{dot}{_shorten_text(ending, 12)}" if dot else _shorten_text(safe_name)
    return f"_{short}" if not short or _RESERVED.match(short) else short


def _shorten_text(text: str, most: int = LONGEST_NAME) -> str:
    """Return the beginning of a text, at most `most` bytes, without trailing spaces."""
    return text.encode()[:most].decode("utf-8", "ignore").rstrip(" .")


@dataclass
class UploadFolder:
    """Files by key."""

    folder: Path
    uploaded_bytes: int = 0
    """Uploaded bytes, including unfinished uploads."""

    def path(self, key: str) -> Path:
        """Return the file of a key."""
        below = self.folder / key
        files = sorted(below.iterdir()) if is_key(key) and below.is_dir() else []
        if len(files) != 1:
            raise DataError("There is no such file here; upload it again.")
        return files[0]

    def place(self, name: str) -> tuple[str, Path]:
        """Return a new key and the path of a new file."""
        key = make_key()
        below = self.folder / key
        try:
            below.mkdir(parents=True)
        except OSError as error:
            raise DataError(f"The folder of the bench cannot be used: {error.strerror}.") from None
        return key, below / clean_name(name)

    async def take(self, name: str, chunks: AsyncIterator[bytes]) -> tuple[str, Path]:
        """Store an upload; return its key and path.

        Raises:
            Refusal: the file or all uploads are too large, or the disk is full; nothing is stored.
        """
        key, path = self.place(name)
        size = 0
        try:
            with self._whole_or_nothing(path), path.open("xb") as file:
                async for chunk in chunks:
                    size += len(chunk)
                    self.uploaded_bytes += len(chunk)
                    self._check_size(size)
                    file.write(chunk)
        except BaseException:
            self.uploaded_bytes -= size
            raise
        return key, path

    def _check_size(self, size: int) -> None:
        if size > MOST_BYTES:
            raise Refusal(
                f"The file has more than {MOST_BYTES // 2**20} MiB; thin it out, or fit it on the command line.", 413
            )
        if self.uploaded_bytes > MOST_IN_ALL:
            raise Refusal(
                f"All files uploaded since the bench began have more than {MOST_IN_ALL // 2**20:,} MiB together; "
                "thin this one out, or restart the bench.",
                413,
            )

    @staticmethod
    @contextmanager
    def _whole_or_nothing(path: Path) -> Iterator[None]:
        try:
            yield
        except BaseException as error:
            with suppress(OSError):
                path.unlink(missing_ok=True)
                path.parent.rmdir()
            if isinstance(error, OSError):
                reason = error.strerror or error
                raise Refusal(f"The file could not be kept: {reason}.", 507) from None
            raise
