"""Rows of cells of text files with complete headings, by column.

Blocks of plain numbers are read at once (`logs.plain_rows`), all other blocks cell by cell. A long log takes the memory
of its bytes and its numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.logs.cells import GAPS, Numbers, NumberStyle, find_kind, parse_cells
from martensite.logs.layout import CLOCK, IGNORED, FileColumn, Layout
from martensite.logs.open_files import Lines, read_lines, split_cells
from martensite.logs.plain_rows import read_plain_rows
from martensite.logs.raw_table import RawColumn, WrongCell
from martensite.logs.table_headings import SEPARATORS, split_heading

SIGNS = {name: SEPARATORS[name] for name in ("tab", "semicolon", "comma", "whitespace")}


@dataclass(frozen=True)
class CellRows:
    """Rows of text cells with their row numbers in the file."""

    where: str
    lines: Lines
    separator: str
    above: tuple[str, ...] = ()
    """Row of headings above them."""
    blank: bool = False
    """True if the first row has headings separated by blanks."""

    @property
    def rows(self) -> list[list[str]]:
        """Return the cells of all rows."""
        return [self.row(0), *(split_cells(line, SIGNS[self.separator]) for _, line in self.lines[1:])]

    @property
    def numbers(self) -> list[int]:
        """Return the row numbers in the file."""
        return self.lines.numbers.tolist()

    def row(self, place: int) -> list[str]:
        """Return the cells of a row."""
        line = self.lines[place][1]
        return split_heading(line) if self.blank and not place else split_cells(line, SIGNS[self.separator])

    def below(self) -> CellRows:
        """Return the rows below the first."""
        return CellRows(self.where, self.lines[1:], self.separator)


def read_rows(path: Path, layout: Layout) -> CellRows:
    """Return the rows of cells of a text file.

    Raises:
        DataError: the file is missing, empty, or no text.
    """
    lines, _ = read_lines(path, spoilt=layout.drop)
    lines = lines[int(np.searchsorted(lines.numbers, layout.skip, side="right")) :]
    lines = lines.select(lambda line: not line.lstrip().startswith("#"))
    if not lines:
        raise DataError(f"`{path.name}` is empty: it holds no rows.")
    sheet = CellRows(f"`{path.name}`", lines, _find_separator(lines, layout))
    blank = not SIGNS[sheet.separator] and not layout.columns and not any(map(is_number, sheet.row(0)))
    return replace(sheet, blank=blank)


def _find_separator(lines: Lines, layout: Layout) -> str:
    """Return the separator of the first line; if rows may be dropped, of most lines."""
    if layout.separator != "auto":
        return layout.separator
    if layout.drop and layout.columns:
        width = len(layout.columns)
        fitting = {
            name: sum(len(line.split(sign or None)) == width for _, line in lines) for name, sign in SIGNS.items()
        }
        return max(fitting, key=fitting.__getitem__)
    first = lines[0][1]
    return next((name for name, sign in SIGNS.items() if sign in first), "whitespace")


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, with decimal point or comma."""
    return find_kind(cell) == "number" or cell.strip().lower() in ("nan", "inf", "-inf")


def is_gap(cell: str) -> bool:
    """Return whether a cell is a missing sample."""
    return cell.strip().lower() in GAPS


class ExactRows:
    """Rows below the headings: blocks of plain numbers at once, all other blocks by cell."""

    def __init__(self, sheet: CellRows, headings: Sequence[FileColumn], gaps: bool) -> None:
        self.headings, self.gaps, self.separator = headings, gaps, sheet.separator
        self.ragged: list[tuple[int, list[str]]] = []
        """Row numbers and cells of rows with another number of cells."""
        self.wrong: list[list[WrongCell]] = [[] for _ in headings]
        self.table, self.numbers = np.empty((len(headings), len(sheet.lines))), np.empty(len(sheet.lines), np.intp)
        self._last = 0
        plain = all(head.name != IGNORED and head.spelling != CLOCK for head in headings)
        for block in sheet.lines.list_blocks():
            texts = block.list_texts()
            comma = self.separator != "comma"
            rows = read_plain_rows(texts, SIGNS[self.separator], len(headings), comma=comma) if plain else None
            if rows is None:
                self._read_cells(texts, block.numbers)
            else:
                self._add(rows.T, block.numbers)
        self.table, self.numbers = self.table[:, : self._last], self.numbers[: self._last]

    def list_columns(self) -> tuple[RawColumn, ...]:
        """Return the columns with all cells that are not finite numbers."""
        both = zip(self.headings, self.table, self.wrong, strict=True)
        return tuple(_build_column(head, numbers, wrong) for head, numbers, wrong in both)

    def _add(self, columns: Sequence[Numbers] | Numbers, numbers: NDArray[Any]) -> None:
        first, self._last = self._last, self._last + len(numbers)
        self.table[:, first : self._last], self.numbers[first : self._last] = columns, numbers

    def _read_cells(self, texts: Sequence[str], numbers: NDArray[Any]) -> None:
        width, sign = len(self.headings), SIGNS[self.separator]
        rows = [row[:-1] if _ends_empty(row, width) else row for row in (split_cells(text, sign) for text in texts)]
        whole = np.array([len(row) == width for row in rows])
        self.ragged += [(int(number), rows[k]) for k, number in enumerate(numbers) if not whole[k]]
        numbers = numbers[whole]
        cells = list(zip(*(row for row in rows if len(row) == width), strict=True)) or [()] * width
        read = [self._read_column(place, one, numbers) for place, one in enumerate(cells)]
        self._add(read, numbers)

    def _read_column(self, place: int, cells: Sequence[str], rows: NDArray[Any]) -> Numbers:
        """Return the numbers of cells, and note wrong cells; missing cells are allowed with `gaps`."""
        head = self.headings[place]
        if head.name == IGNORED:
            return np.full(len(cells), math.nan)
        kind = "clock" if head.spelling == CLOCK else "number"
        read, _ = parse_cells(cells, NumberStyle(comma=self.separator != "comma"), kind)
        if kind == "clock":
            read[[k for k, cell in enumerate(cells) if cell.count(":") != 2]] = math.nan
        allowed = self.gaps and head.name != "time"
        wrong = [int(k) for k in np.flatnonzero(np.isnan(read)) if not (allowed and is_gap(cells[int(k)]))]
        self.wrong[place] += [WrongCell(int(rows[k]), cells[k].strip()) for k in wrong]
        return read


def _build_column(head: FileColumn, numbers: Numbers, wrong: Sequence[WrongCell]) -> RawColumn:
    if head.name == IGNORED:
        return RawColumn(IGNORED, "", "text", np.empty(0))
    kind = "clock" if head.spelling == CLOCK else "number"
    return RawColumn(head.name, head.spelling, kind, numbers, "", tuple(wrong))


def _ends_empty(row: Sequence[str], width: int) -> bool:
    """Return whether a separator ends a row of the given width."""
    return len(row) == width + 1 and not row[-1].strip()
