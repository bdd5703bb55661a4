"""From a text file to rows of cells: encoding, separator, comments; and from cells to numbers.

Rows are counted as an editor or a spreadsheet counts them, comments and empty lines included.
Where rows may be dropped (`Layout.drop`) a line is split by itself, so that a stray quote or
a lost byte in one of them cannot reach its neighbours.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from martensite.base.errors import DataError
from martensite.base.files import MOST_LOG, read_unpacked
from martensite.logs.layout import CLOCK, FileColumn, Layout

GAPS = ("", "nan", "na", "n/a", "null")
"""Cells that a logger writes for a missing sample, in lower case."""
SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", "whitespace": ""}
_TIME_OF_DAY = re.compile(r"([0-9]{1,2}):([0-5]?[0-9]):([0-5]?[0-9](?:[.,][0-9]*)?)")
_HEADING = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")


@dataclass(frozen=True)
class Sheet:
    """Rows of text cells with their row numbers in the file."""

    where: str
    numbers: list[int]
    rows: list[list[str]]
    decimal_comma: bool

    def part(self, kept: Sequence[int]) -> Sheet:
        """Return the rows of the given indices."""
        numbers, rows = [self.numbers[i] for i in kept], [self.rows[i] for i in kept]
        return replace(self, numbers=numbers, rows=rows)

    def parser(self, column: FileColumn) -> Callable[[str], float]:
        """Return the function that converts a cell of this column to a number; it raises ValueError for other texts."""
        if column.spelling == CLOCK:
            return _read_clock
        return _comma_number if self.decimal_comma else _read_number

    def fault(self, index: int, column: FileColumn, sentence: str) -> DataError:
        """Return an error that names row and column."""
        return DataError(f"{self.where}, row {self.numbers[index]}, column `{column.name}`: {sentence}")


def read_sheet(path: Path, layout: Layout) -> Sheet:
    """Split a file into rows of cells.

    Raises:
        DataError: the file is missing, empty, no text, or badly quoted.
    """
    where = f"`{path.name}`"
    text = _read_text(path, binary=layout.drop)
    kept = [
        (number, line)
        for number, line in enumerate(text.split("\n"), start=1)
        if number > layout.skip and line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise DataError(f"{where} is empty: it holds no rows.")
    separator = _find_separator([line for _, line in kept], layout)
    if separator == "whitespace":
        rows = [line.split() for _, line in kept]
        if not layout.columns and not any(map(is_number, rows[0])):
            rows[0] = split_heading(kept[0][1])
    elif layout.drop:
        rows = _split_singly(kept, SEPARATORS[separator], len(layout.columns))
    else:
        rows = _split_line(kept, SEPARATORS[separator], where)
    return Sheet(where, [number for number, _ in kept], rows, separator != "comma")


def split_heading(line: str) -> list[str]:
    """Return the headings that blanks separate, each with its unit in brackets."""
    return _HEADING.findall(line)


def _find_separator(lines: list[str], layout: Layout) -> str:
    """Return the separator of the first line; where rows may be dropped, that of most lines."""
    if layout.separator != "auto":
        return layout.separator
    if layout.drop and layout.columns:
        width = len(layout.columns)
        fitting = {
            name: sum(len(line.split(sign or None)) == width for line in lines) for name, sign in SEPARATORS.items()
        }
        return max(fitting, key=fitting.__getitem__)
    return next((name for name, sign in SEPARATORS.items() if sign in lines[0]), "whitespace")


def _split_singly(lines: list[tuple[int, str]], sign: str, width: int) -> list[list[str]]:
    """Return the cells of lines that have nothing to do with each other."""
    rows: list[list[str]] = []
    for _, line in lines:
        if line.count('"') % 2:  # an open quote
            rows.append([])
            continue
        try:
            row = next(csv.reader([line], delimiter=sign, skipinitialspace=True))
        except csv.Error:
            row = []
        ends = len(row) == width + 1 and not row[-1].strip()
        rows.append(row[:-1] if ends else row)
    return rows


def _split_line(lines: list[tuple[int, str]], sign: str, where: str) -> list[list[str]]:
    try:
        rows = list(csv.reader((line for _, line in lines), delimiter=sign, skipinitialspace=True))
    except csv.Error as error:
        raise DataError(f"{where} cannot be split into cells: {error}.") from None
    if len(rows) != len(lines):
        raise DataError(f"{where} has a quoted cell that goes over several rows; close the quote.")
    if all(len(row) > 1 and not row[-1].strip() for row in rows):
        return [row[:-1] for row in rows]  # every row ends with a separator
    return rows


def _read_text(path: Path, *, binary: bool) -> str:
    """Return the text of a file, of which single lines may be `binary`."""
    with describe_unreadable(path):
        raw = read_unpacked(path, MOST_LOG)
    if b"\0" in raw and not binary:
        raise DataError(f"`{path.name}` is not a text file; save the table as CSV in UTF-8.")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


@contextmanager
def describe_unreadable(path: Path) -> Iterator[None]:
    """Say in a sentence why a file could not be opened."""
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


def can_parse(parse: Callable[[str], float], cell: str) -> bool:
    """Return whether a cell can be read."""
    try:
        parse(cell)
    except ValueError:
        return False
    return True


def can_read(parse: Callable[[str], float], cell: str) -> bool:
    """Return whether a cell can be read, and is a finite number."""
    try:
        return math.isfinite(parse(cell))
    except ValueError:
        return False


def is_gap(cell: str) -> bool:
    """Return whether a cell is that of a missing sample."""
    return cell.strip().lower() in GAPS


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, with decimal point or comma."""
    return can_parse(_comma_number, cell)


def _read_number(cell: str) -> float:
    if "_" in cell or not cell.strip().isascii():  # Python would read 1_000, and digits of any script
        raise ValueError
    return float(cell)


def _comma_number(cell: str) -> float:
    return _read_number(cell.replace(",", "."))


def _read_clock(cell: str) -> float:
    found = _TIME_OF_DAY.fullmatch(cell.strip())
    if found is None:
        raise ValueError
    return 3600.0 * int(found[1]) + 60.0 * int(found[2]) + float(found[3].replace(",", "."))
