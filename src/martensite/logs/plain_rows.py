"""Rows of regular logs, read in blocks.

Most rows of a long log are regular: a fixed number of finite numbers, and no text. `numpy.loadtxt` reads them in a
tenth of the time and memory. Blocks with clocks or missing samples are read by cell. All other rows get the careful
readers (`logs.exact_tables`, `logs.raw_table`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import DataError
from martensite.logs.cells import Numbers, NumberStyle, clear_extremes, is_missing, parse_cells
from martensite.logs.open_files import Line, Lines, find_lines, split_cells
from martensite.logs.raw_table import RawColumn, RawTable

EDGE = 500
"""Lines at both ends of a file that determine its layout."""


def read_plain_rows(texts: Sequence[str], sign: str, width: int, *, comma: bool) -> Numbers | None:
    """Return lines as an array of rows; None if one of them is not `width` finite numbers.

    Args:
        texts: lines.
        sign: separator of the cells; empty for blanks.
        width: number of cells.
        comma: read a comma as a decimal point.
    """
    try:
        lines = [text.replace(",", ".") for text in texts] if comma else texts
        table = clear_extremes(np.loadtxt(lines, delimiter=sign or None, comments=None, ndmin=2))
    except ValueError:
        return None
    return table if table.shape == (len(texts), width) and bool(np.isfinite(table).all()) else None


def read_regular(lines: Sequence[Line], sign: str, find: Callable[[Sequence[Line]], RawTable]) -> RawTable | None:
    """Return the table of a long text whose middle has the columns of its ends; None for other texts.

    Args:
        lines: nonempty lines of the file.
        sign: separator of the cells; empty for blanks.
        find: careful reader, which gets the lines at both ends.
    """
    if not isinstance(lines, Lines) or len(lines) < 3 * EDGE:
        return None
    head, middle, tail = lines[:EDGE], lines[EDGE:-EDGE], lines[-EDGE:]
    try:
        ends = find([*head, *tail])
    except DataError:
        return None
    place = int(np.searchsorted(ends.numbers, tail.numbers[0]))
    around = ends.numbers[max(0, place - 1) : place + 1].tolist() == [head.numbers[-1], tail.numbers[0]]
    reader = _find_reader([*head, *tail], sign, ends) if around and not ends.notes else None
    return None if reader is None else _insert_rows(ends, place, middle, reader)


@dataclass(frozen=True)
class _Reader:
    """Reader of rows whose columns have known kinds."""

    columns: tuple[RawColumn, ...]
    sign: str
    comma: bool

    def read(self, block: Lines) -> Numbers | None:
        """Return the numbers of a block by column; None if a row or a cell is of another kind."""
        texts = block.list_texts()
        kinds = {one.kind for one in self.columns}
        plain = read_plain_rows(texts, self.sign, len(self.columns), comma=self.comma) if kinds == {"number"} else None
        return plain.T if plain is not None else self._read_cells([split_cells(text, self.sign) for text in texts])

    def _read_cells(self, rows: list[list[str]]) -> Numbers | None:
        if {len(row) for row in rows} != {len(self.columns)}:
            return None
        columns = [
            self._read_column(one, cells) for one, cells in zip(self.columns, zip(*rows, strict=True), strict=True)
        ]
        if any(numbers is None for numbers in columns):
            return None
        table = np.array(columns)
        return table if bool(np.isfinite(table).any(axis=0).all()) else None

    def _read_column(self, column: RawColumn, cells: Sequence[str]) -> Numbers | None:
        """Return the numbers of a column; None for cells that are neither of its kind nor missing."""
        if column.kind in ("number", "clock"):
            numbers, wrong = parse_cells(cells, NumberStyle(self.comma), column.kind)
            return None if wrong else numbers
        missing = column.kind == "text" and all(map(is_missing, cells))  # dates need all rows to tell day from month
        return np.full(len(cells), math.nan) if missing else None


def _find_reader(lines: Sequence[Line], sign: str, ends: RawTable) -> _Reader | None:
    """Return the reader that gives the numbers of a table; None if there is none."""
    rows = set(ends.numbers.tolist())
    block = find_lines("\n".join(text for number, text in lines if number in rows))
    careful = np.array([one.numbers for one in ends.columns])
    for comma in (False, True):
        reader = _Reader(ends.columns, sign, comma)
        cells = reader.read(block)
        if cells is not None and np.array_equal(cells, careful, equal_nan=True):
            return reader
    return None


def _insert_rows(ends: RawTable, place: int, middle: Lines, reader: _Reader) -> RawTable | None:
    """Return a table with more rows inserted; None if some are irregular."""
    before = np.array([one.numbers for one in ends.columns])
    table = np.empty((len(before), before.shape[1] + len(middle)))
    table[:, :place], table[:, place + len(middle) :] = before[:, :place], before[:, place:]
    for block in middle.list_blocks():
        cells = reader.read(block)
        if cells is None:
            return None
        table[:, place : place + len(block)] = cells
        place += len(block)
    numbers = np.insert(ends.numbers, place - len(middle), middle.numbers)
    columns = tuple(replace(one, numbers=numbers) for one, numbers in zip(ends.columns, table, strict=True))
    return replace(ends, columns=columns, numbers=numbers)
