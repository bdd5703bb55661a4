"""Rows of plain numbers, read by NumPy.

Most rows of a long log are regular: a fixed number of finite numbers, and no text. `numpy.loadtxt` reads them in a
tenth of the time and memory. All other rows get the careful readers (`logs.exact_tables`, `logs.raw_table`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError
from martensite.logs.cells import Numbers, clear_extremes
from martensite.logs.open_files import Line, Lines
from martensite.logs.raw_table import RawTable

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
    """Return the table of a long text whose middle consists of plain rows; None for other texts.

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
    comma = _find_comma([*head, *tail], sign, ends) if around and not ends.notes else None
    return None if comma is None else _insert_rows(ends, place, middle, sign, comma)


def _find_comma(lines: Sequence[Line], sign: str, ends: RawTable) -> bool | None:
    """Return whether plain rows with a decimal comma give the numbers of a table; None if plain rows do not."""
    rows = set(ends.numbers.tolist())
    texts, careful = [text for number, text in lines if number in rows], [one.numbers for one in ends.columns]
    for comma in (False, True):
        table = read_plain_rows(texts, sign, len(careful), comma=comma)
        if table is not None and np.array_equal(table.T, careful) and {one.kind for one in ends.columns} == {"number"}:
            return comma
    return None


def _insert_rows(ends: RawTable, place: int, middle: Lines, sign: str, comma: bool) -> RawTable | None:
    """Return a table with plain rows inserted; None if some are not plain."""
    before = np.array([one.numbers for one in ends.columns])
    table = np.empty((len(before), before.shape[1] + len(middle)))
    table[:, :place], table[:, place + len(middle) :] = before[:, :place], before[:, place:]
    for block in middle.list_blocks():
        rows = read_plain_rows(block.list_texts(), sign, len(before), comma=comma)
        if rows is None:
            return None
        table[:, place : place + len(rows)] = rows.T
        place += len(rows)
    numbers = np.insert(ends.numbers, place - len(middle), middle.numbers)
    columns = tuple(replace(one, numbers=numbers) for one, numbers in zip(ends.columns, table, strict=True))
    return replace(ends, columns=columns, numbers=numbers)
