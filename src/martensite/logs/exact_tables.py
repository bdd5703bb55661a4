"""Tables whose headings are complete: `name [unit]` in each column, or headings given with the file.

Columns are separated by tab, semicolon, comma or blanks (the first of these in the headings); numbers may have a
decimal comma unless the comma separates. Lines that begin with `#` are comments. Nothing is repaired: an unreadable
cell is an error with row and column, or its row is dropped and counted (`Layout.drop`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, UnitError
from martensite.base.units import find_conversion
from martensite.logs.cells import OVERFLOW, Numbers
from martensite.logs.column_meanings import Meaning
from martensite.logs.exact_rows import CellRows, ExactRows, is_gap, is_number, read_rows
from martensite.logs.heading_guess import guess_heading
from martensite.logs.lab_files import LabFile, ReadColumn, describe_column
from martensite.logs.layout import CANONICAL, CLOCK, IGNORED, FileColumn, Layout, name_column, read_headings
from martensite.logs.raw_table import RawColumn, RawTable, count_rows
from martensite.logs.table_times import find_step
from martensite.signals.records import Record, out_of_order

ASSUMED_INTERVAL = 1.0
"""Default time between rows [s] of a file without times."""


class InexactError(DataError):
    """Error for a table with an incomplete heading."""


def read_exact_text(path: Path, layout: Layout, gaps: bool) -> tuple[RawTable, list[FileColumn]]:
    """Return the table of a text file and the meanings of its columns.

    Args:
        path: text file.
        layout: headings, separator, and rows to skip or drop.
        gaps: whether cells may be empty or NaN.

    Raises:
        InexactError: a heading is incomplete.
        DataError: the file is missing or malformed.
    """
    sheet = read_rows(path, layout)
    headings, sheet = _read_headings(sheet, layout)
    body = ExactRows(sheet, headings, gaps)
    fault = DataError if any(not is_unknown(text) for text in layout.columns or sheet.above) else InexactError
    if body.ragged and not layout.drop:
        raise fault(_describe_ragged(sheet.where, body.ragged[0], headings))
    columns = body.list_columns()
    if fault is InexactError and any(column.wrong for column in columns):
        raise fault(f"{sheet.where} does not begin with headings of a table, but with `{headings[0].name}`.")
    left = count_rows("more or fewer cells than the table has columns", [number for number, _ in body.ragged])
    return RawTable(path.name, "text", sheet.separator, True, columns, body.numbers, [], left), headings


def _read_headings(sheet: CellRows, layout: Layout) -> tuple[list[FileColumn], CellRows]:
    """Return the meanings of the columns, and the rows below the headings."""
    first = sheet.row(0)
    first = first[:-1] if len(first) > 1 and not first[-1].strip() else first
    numeric = any(map(is_number, first))
    if layout.columns:
        headings = read_headings(layout.columns, sheet.where)
        own = not numeric and len(first) == len(headings) and not layout.drop
    elif numeric:
        raise InexactError(
            f"{sheet.where} has no headings: row {sheet.numbers[0]} holds numbers; name all "
            f'{len(first)} columns, for example columns=["time [s]", "temperature [degC]"].'
        )
    else:
        headings, own = read_exact_headings(first, sheet.where), True
        _refuse_unsettled(first, sheet)
        refuse_mistaken(first, headings, sheet.where)
    if own:
        sheet = replace(sheet.below(), above=tuple(first))
    if not sheet.lines:
        raise DataError(f"{sheet.where} holds headings but no rows of numbers.")
    return headings, sheet


def read_exact_headings(headings: Sequence[str], where: str) -> list[FileColumn]:
    """Return the meanings of complete headings.

    Raises:
        InexactError: a heading is incomplete.
    """
    try:
        return read_headings(headings, where)
    except DataError as error:
        raise InexactError(str(error)) from None


def refuse_mistaken(texts: Sequence[str], headings: Sequence[FileColumn], where: str) -> None:
    """Refuse headings whose words contradict their unit: `Temp (C)` is in degrees, not in coulombs.

    Raises:
        InexactError: there is such a heading.
    """
    for text, head in zip(texts, headings, strict=True):
        guess = guess_heading(text)
        if guess.has_words and guess.name and guess.unit not in ("", CLOCK, head.spelling):
            try:
                find_conversion(guess.unit, head.unit)
            except UnitError:
                raise InexactError(
                    f"{where}: heading `{text.strip()}` is unclear; write `{guess.name} [{guess.unit}]`."
                ) from None


def _refuse_unsettled(first: Sequence[str], sheet: CellRows) -> None:
    """Raise `InexactError` for units without brackets, and lines that are no headings."""
    unknown = [heading.strip() for heading in first if is_unknown(heading)]
    for heading in unknown:
        guess = guess_heading(heading)
        if guess.unit:
            wanted = f"{guess.name or 'name'} [{guess.unit}]"
            raise InexactError(f"{sheet.where}: heading `{heading}` has its unit without brackets; write `{wanted}`.")
    if len(unknown) == len(first) and not _has_numbers_below(sheet):
        raise InexactError(f"{sheet.where} does not begin with headings of a table, but with `{unknown[0]}`.")


def _has_numbers_below(sheet: CellRows) -> bool:
    """Return whether the second row has numbers and the width of the first, or begins an open quote."""
    first, below = _trim_end(sheet.row(0)), _trim_end(sheet.row(1)) if len(sheet.lines) > 1 else []
    alike = len(below) == len(first)
    return any(cell.count('"') % 2 for cell in below) or (alike and any(map(is_number, below)))


def is_unknown(heading: str) -> bool:
    """Return whether a heading has neither a unit in brackets nor a known name."""
    return not re.search(r"[\[(]", heading) and name_column(heading) not in CANONICAL


def _trim_end(row: Sequence[str]) -> Sequence[str]:
    """Return a row without trailing empty cells."""
    filled = [k for k, cell in enumerate(row) if cell.strip()]
    return row[: filled[-1] + 1] if filled else []


def _describe_ragged(where: str, ragged: tuple[int, list[str]], headings: Sequence[FileColumn]) -> str:
    number, cells = ragged
    place = f"{where}, row {number}"
    if any(cell.count('"') % 2 for cell in cells):
        return f"{place} has a quoted cell that goes over several rows; close the quote."
    listed = ", ".join(f"`{column.name}`" for column in headings)
    return f"{place} has {len(cells)} cells, but there are {len(headings)} columns: {listed}."


# ---------------------------------------------------------------- from cells to a record in SI


def build_exact(
    raw: RawTable, headings: Sequence[FileColumn], path: Path, name: str, interval: float | None, drop: bool
) -> LabFile:
    """Return a table in SI.

    Args:
        raw: table.
        headings: meanings of its columns.
        path: path of the file.
        name: name of the record.
        interval: time between rows [s] of a table without times.
        drop: leave out rows with unreadable cells or a repeated time.

    Raises:
        DataError: a cell is not a finite number, time does not increase, or no row can be read.
    """
    wanted = [(column, head) for column, head in zip(raw.columns, headings, strict=True) if head.name != IGNORED]
    rows = _choose_rows(raw, wanted, drop)
    columns: dict[str, Numbers] = {head.name: _convert(column.numbers[rows], head) for column, head in wanted}
    si_units = {head.name: head.unit for _, head in wanted}
    numbers = raw.numbers[rows]
    assumed: float | None = None
    if "time" in columns:
        _refuse_disorder(raw.name, numbers, columns["time"])
    else:
        interval = interval or find_step((head.name, head.spelling, column.numbers) for column, head in wanted)
        _refuse_other_time(raw.name, si_units, interval)
        assumed = ASSUMED_INTERVAL if interval is None else interval
        columns, si_units = {"time": np.arange(float(len(numbers))) * assumed, **columns}, {"time": "s"} | si_units
    dropped = sum(one.count for one in raw.left_out) + raw.rows - len(numbers)
    record = Record(name, columns, si_units, path, dropped, assumed)
    both = zip(raw.columns, headings, strict=True)
    listed = [_list_column(k, column, head, columns) for k, (column, head) in enumerate(both)]
    has_time = assumed is None or interval is not None
    return LabFile(path, raw.form, record, tuple(listed), raw.left_out, (), has_time, exact=True)


def _convert(numbers: Numbers, head: FileColumn) -> Numbers:
    if head.spelling == CLOCK:
        return numbers - numbers[0]
    factor, offset = (1.0, 0.0) if head.spelling == head.unit else find_conversion(head.spelling, head.unit)
    return numbers * factor + offset


def _list_column(place: int, column: RawColumn, head: FileColumn, columns: dict[str, Numbers]) -> ReadColumn:
    used = head.name != IGNORED
    numbers = columns[head.name] if used else np.array([math.nan])
    return describe_column(
        place, column, Meaning(head.name, head.spelling, "given"), head.unit if used else "", numbers
    )


def _choose_rows(raw: RawTable, wanted: Sequence[tuple[RawColumn, FileColumn]], drop: bool) -> NDArray[np.intp]:
    """Return the row indices; with `drop` only readable rows with a new time."""
    if not drop:
        _refuse_wrong(raw, wanted)
    wrong = [cell.row for column, _ in wanted for cell in column.wrong]
    rows = np.flatnonzero(~np.isin(raw.numbers, wrong))
    if not wanted or not rows.size:
        raise DataError(f"`{raw.name}` has no numeric column or row.")
    times = next((column.numbers for column, head in wanted if head.name == "time"), None)
    return rows if times is None or not drop else rows[np.append(True, np.diff(times[rows]) != 0.0)]


def _refuse_wrong(raw: RawTable, wanted: Sequence[tuple[RawColumn, FileColumn]]) -> None:
    for column, head in wanted:
        if column.wrong:
            row, text = column.wrong[0]
            sentence = f"`{text}` is not a number." if text else "the cell is empty."
            if _is_infinite(text):
                sentence = f"numbers must be finite, but this is `{text}`."
            raise DataError(f"`{raw.name}`, row {row}, column `{head.name}`: {sentence}")


def _is_infinite(text: str) -> bool:
    """Return whether a text is NaN, infinite, or an out-of-range mark of an instrument."""
    try:
        return not abs(float(text)) < OVERFLOW
    except ValueError:
        return is_gap(text) and bool(text)


def _refuse_disorder(name: str, numbers: NDArray[np.intp], times: Numbers) -> None:
    index = out_of_order(times)
    if index is not None:
        raise DataError(
            f"`{name}`: time must increase from row to row, but row {numbers[index]} "
            f"goes from {times[index - 1]:.15g} s to {times[index]:.15g} s."
        )


def _refuse_other_time(name: str, si_units: dict[str, str], interval: float | None) -> None:
    """Refuse to replace a time column of another name by an assumed time."""
    meant = {name: guess_heading(name).name if unit == "1" else name for name, unit in si_units.items()}
    suspect = next((n for n, unit in si_units.items() if unit == "s" or meant[n].startswith("time")), None)
    if suspect is not None and interval is None:
        raise InexactError(
            f"`{name}` has no column `time`, but `{suspect}` seems to be one; head it `time [s]`, "
            "or give the `interval` between rows."
        )


def is_all_known(record: Record) -> bool:
    """Return whether all columns of a record have known names."""
    return all(name.rpartition(".")[2] in CANONICAL for name in record.columns)
