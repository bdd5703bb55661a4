"""Text of measured files: opening, encoding and lines.

Rows are counted as in an editor, including comments and empty lines.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.base.files import MOST_LOG, read_unpacked

TEXT = (".csv", ".txt", ".tsv", ".dat")
"""Usual suffixes of text files."""
_QUOTED = re.compile(r'\s*"([^"]*[,;\t][^"]*)"\s*')
BLOCK = 4_000
"""Lines that are decoded at a time."""
Line = tuple[int, str]
"""Line number in the file, and text."""


@dataclass(frozen=True, eq=False)
class Lines(Sequence[Line]):
    """Lines of a text, decoded on demand: a long log takes its bytes and 12 bytes per line."""

    data: bytes
    """Text in UTF-8, with `\\n` between lines."""
    starts: NDArray[np.int64]
    """Index of the first byte of each line."""
    numbers: NDArray[np.int32]
    """Line numbers in the file."""

    def __len__(self) -> int:
        return len(self.starts)

    @overload
    def __getitem__(self, place: int) -> Line: ...
    @overload
    def __getitem__(self, place: slice) -> Lines: ...
    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return Lines(self.data, self.starts[place], self.numbers[place])
        return int(self.numbers[place]), self._decode_from(int(self.starts[place]))

    def __iter__(self) -> Iterator[Line]:
        for block in self.list_blocks():
            yield from zip(block.numbers.tolist(), block.list_texts(), strict=True)

    def list_blocks(self) -> Iterator[Lines]:
        """Yield parts of at most `BLOCK` lines."""
        for first in range(0, len(self), BLOCK):
            yield self[first : first + BLOCK]

    def list_texts(self) -> list[str]:
        """Return the texts of all lines."""
        return [self._decode_from(start) for start in self.starts.tolist()]

    def select(self, fits: Callable[[str], bool]) -> Lines:
        """Return the lines whose text meets a condition."""
        mask = np.fromiter((fits(line) for _, line in self), bool, len(self))
        return self if mask.all() else Lines(self.data, self.starts[mask], self.numbers[mask])

    def _decode_from(self, start: int) -> str:
        end = self.data.find(b"\n", start)
        return self.data[start : end if end >= 0 else None].decode()


def find_lines(text: str) -> Lines:
    """Return all lines of a text."""
    data = text.encode()
    ends = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("\n"))
    return Lines(data, np.append(0, ends + 1), np.arange(1, len(ends) + 2, dtype=np.int32))


def read_lines(path: Path, *, spoilt: bool = False) -> tuple[Lines, str]:
    """Return the nonempty lines of a text file, and its encoding; the encoding is empty for UTF-8.

    Args:
        path: text file.
        spoilt: accept single lines of binary garbage.

    Raises:
        DataError: the file is missing, empty, or no text.
    """
    with describe_unreadable(path):
        raw = read_unpacked(path, MOST_LOG)
    text, encoding = _decode(raw, path, spoilt)
    del raw  # a large log is held twice at most
    lines = find_lines(text.replace("\r\n", "\n").replace("\r", "\n")).select(lambda line: bool(line.strip()))
    if lines.data.count(b'"') > len(lines) and _count_quoted(lines) * 10 > 9 * len(lines):
        plain = find_lines("\n".join(_QUOTED.sub(r"\1", line) for _, line in lines))
        lines = replace(plain, numbers=lines.numbers)  # every line was one quoted cell
    if not lines:
        raise DataError(f"`{path.name}` is empty: it holds no rows.")
    return lines, encoding


def _count_quoted(lines: Lines) -> int:
    """Return the number of lines that are one quoted cell."""
    return sum(_QUOTED.fullmatch(line) is not None for _, line in lines)


def _find_wide(raw: bytes) -> str:
    """Return the encoding of a UTF-16 text; empty for other files."""
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if len(raw) < 4 or raw[:200].count(0) * 3 < len(raw[:200]):
        return ""
    wide = "utf-16-le" if raw[1] == 0 else "utf-16-be"
    letters = raw[:200].decode(wide, "replace")
    plain = sum(ord(letter) < 0x500 and (letter.isprintable() or letter.isspace()) for letter in letters)
    return wide if plain * 10 > 9 * len(letters) else ""


def _decode(raw: bytes, path: Path, spoilt: bool) -> tuple[str, str]:
    wide = "" if spoilt else _find_wide(raw)
    if wide:
        return raw.decode(wide, "replace").lstrip("\ufeff"), "UTF-16"
    odd = sum(byte < 9 or 13 < byte < 27 for byte in raw[:4096])
    if odd * 50 > len(raw[:4096]) and not spoilt:
        raise DataError(f"`{path.name}` is not a text file, nor of another kind that is known by its ending.")
    try:
        text, encoding = raw.decode("utf-8-sig"), ""
    except UnicodeDecodeError:
        text, encoding = raw.decode("cp1252", "replace"), "cp1252"
    return text if spoilt else text.replace("\0", " "), encoding


def split_cells(line: str, sign: str) -> list[str]:
    """Return the cells of a line; a line with an open quote is one cell."""
    if not sign:
        return line.split()
    if line.count('"') % 2:
        return [line]
    if '"' not in line:
        return line.split(sign)
    try:
        cells = next(csv.reader([line], delimiter=sign, skipinitialspace=True))
        return [cell.strip('"') for cell in cells]  # some loggers quote twice
    except (csv.Error, StopIteration):
        return line.split(sign)


@contextmanager
def describe_unreadable(path: Path) -> Iterator[None]:
    """Convert errors of opening a file to `DataError` with a sentence."""
    try:
        yield
    except FileNotFoundError:
        raise DataError(_describe_missing(path)) from None
    except IsADirectoryError:
        raise DataError(f"`{path}` is a folder; name a file in it.") from None
    except OSError as error:
        raise DataError(f"File `{path}` cannot be read: {error.strerror}.") from None


def _describe_missing(path: Path) -> str:
    if not path.parent.is_dir():
        return f"There is no file `{path}`, nor the folder `{path.parent}`."
    names = [entry.name for entry in path.parent.iterdir()]
    near = get_close_matches(path.name, names, n=1, cutoff=0.5)
    if near:
        return f"There is no file `{path}`. Did you mean `{near[0]}`?"
    return f"There is no file `{path}`, nor one of a similar name beside it."
