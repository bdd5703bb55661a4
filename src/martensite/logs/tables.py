"""Measured tables: text files with columns of numbers, read into a `Record` in SI units.

Columns are separated by tab, semicolon, comma or blanks (the first of these found in the first row); numbers may have
a decimal comma unless the comma separates. Lines that begin with `#` are comments. Headings carry the unit in
brackets (see `martensite.logs.layout`). Nothing is repaired: what cannot be read is an error that names row and
column, or, for a logger that writes other things between its rows, is left out and counted (`drop`). Samples that a
logger missed are NaN where that is asked for (`gaps`), and an error otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.logs.layout import CLOCK, IGNORED, FileColumn, Layout, read_headings
from martensite.logs.sheets import SEPARATORS, Sheet, can_parse, can_read, is_gap, is_number, read_sheet
from martensite.signals.records import Record, not_finite, out_of_order

PREFIX = "data:"
TEXT = (".csv", ".txt", ".tsv", ".dat")
BINARY = (".parquet", ".mat", ".nc")
"""Endings of files that are no text."""
ASSUMED_INTERVAL = 1.0
"""Time between rows [s] of a file that has no times, if nothing is said."""


def read_table(
    source: str | Path,
    columns: Sequence[str] | None = None,
    *,
    interval: float | None = None,
    separator: str = "auto",
    drop: bool = False,
    gaps: bool = False,
) -> Record:
    """Read a file with columns of numbers: text, or Parquet, MAT and netCDF files (`.parquet`, `.mat`, `.nc`).

    Args:
        source: a file, of a result too, or `data:<data set>/<file>` for one of the published data sets.
        columns: headings such as `temperature [degC]`, for files that have none; they
            replace the headings of a file that has some. `-` passes a column over.
        interval: time between rows [s] of a file without a time column; 1 s if left out.
        separator: `auto`, `comma`, `semicolon`, `tab` or `whitespace`.
        drop: leave out rows that cannot be read or that repeat the time before, and count
            them in `Record.dropped`. A number that was cut short cannot be told from one
            that was not. Some of the published data sets are read so anyway.
        gaps: read missing samples (cells that are empty or hold NaN) as NaN; a time is never missing.

    Raises:
        DataError: the file is missing, empty or malformed; the sentence says where.
        UnknownNameError: the data set or the file in it does not exist.
    """
    if interval is not None and not 0.0 < interval < math.inf:
        raise ParameterError(f"Argument `interval` must be above 0 s, but is {interval} s.")
    if separator not in ("auto", *SEPARATORS):
        valid = suggest_name(separator, ("auto", *SEPARATORS))
        raise ParameterError(f"Argument `separator` is `{separator}`. {valid}")
    if str(source).lower().endswith(BINARY):
        from martensite.logs.sampled_files import read_array_table

        return read_array_table(Path(source), columns, interval, gaps)
    path, layout, name = _find_origin(source)
    if columns is not None:
        layout = replace(layout, columns=tuple(columns))
    if separator != "auto":
        layout = replace(layout, separator=separator)
    if drop:
        layout = replace(layout, drop=True)
    headings, sheet = _read_headings(read_sheet(path, layout), layout)
    rows = len(sheet.rows)
    if layout.drop:
        sheet = sheet.part(_find_readable(sheet, headings, gaps))
    found = _read_columns(sheet, headings, gaps)
    names = {column.name: column.unit for column in headings if column.name in found}
    dropped = rows - len(sheet.rows)
    if "time" in found:
        _refuse_disorder(sheet, found["time"])
        return Record(name, found, names, path, dropped)
    _refuse_other_time(sheet.where, names, interval)
    step = ASSUMED_INTERVAL if interval is None else interval
    times = [row * step for row in range(len(sheet.rows))]
    return Record(name, {"time": times} | found, {"time": "s"} | names, path, dropped, step)


def _find_origin(source: str | Path) -> tuple[Path, Layout, str]:
    if isinstance(source, str) and source.startswith(PREFIX):
        from martensite.logs import datasets

        key = source.removeprefix(PREFIX)
        return datasets.locate_file(key), datasets.describe_layout(key), key
    return Path(source), Layout(()), Path(source).stem


def _read_headings(sheet: Sheet, layout: Layout) -> tuple[list[FileColumn], Sheet]:
    first = sheet.rows[0]
    numeric = any(is_number(cell) for cell in first)
    if layout.columns:
        headings = read_headings(layout.columns, sheet.where)
        own = not numeric and len(first) == len(headings) and not layout.drop
    elif numeric:
        raise DataError(
            f"{sheet.where} has no headings: row {sheet.numbers[0]} holds numbers; name all "
            f'{len(first)} columns, for example columns=["time [s]", "temperature [degC]"].'
        )
    else:
        headings, own = read_headings(first, sheet.where), True
    if own:
        sheet = sheet.part(range(1, len(sheet.rows)))
    if not sheet.rows:
        raise DataError(f"{sheet.where} holds headings but no rows of numbers.")
    return headings, sheet


def _read_columns(sheet: Sheet, headings: list[FileColumn], gaps: bool) -> dict[str, list[float]]:
    _refuse_ragged(sheet, headings)
    wanted = [(place, column) for place, column in enumerate(headings) if column.name != IGNORED]
    if not wanted or not sheet.rows:
        raise DataError(f"{sheet.where} has nothing to read: no column, or no row of numbers.")
    return {column.name: _read_column(sheet, place, column, gaps and column.name != "time") for place, column in wanted}


def _read_column(sheet: Sheet, place: int, column: FileColumn, gaps: bool) -> list[float]:
    """Return one column in SI, with NaN for missing samples if there may be such `gaps`."""
    cells = [row[place] for row in sheet.rows]
    if gaps:
        rows = [i for i, cell in enumerate(cells) if not is_gap(cell)]
        known = _read_column(sheet.part(rows), place, column, False) if rows else []
        found = dict(zip(rows, known, strict=True))
        return [found.get(i, math.nan) for i in range(len(cells))]
    parse = sheet.parser(column)
    try:
        numbers = list(map(parse, cells))
    except ValueError:
        index = next(i for i, cell in enumerate(cells) if not can_parse(parse, cell))
        cell = cells[index].strip()
        sentence = f"`{cell}` is not a number." if cell else "the cell is empty."
        raise sheet.fault(index, column, sentence) from None
    index = not_finite(numbers)
    if index is not None:
        cell = cells[index].strip()
        raise sheet.fault(index, column, f"numbers must be finite, but this is `{cell}`.")
    if column.spelling == CLOCK:
        return [number - numbers[0] for number in numbers]
    if column.spelling == column.unit:
        return numbers
    return [units.to_si(number, column.spelling, column.unit) for number in numbers]


def _find_readable(sheet: Sheet, headings: list[FileColumn], gaps: bool) -> list[int]:
    """Return the indices of the rows that can be read and do not repeat the time of the one before."""
    wanted = [
        (p, _or_gap(sheet.parser(c)) if gaps and c.name != "time" else sheet.parser(c))
        for p, c in enumerate(headings)
        if c.name != IGNORED
    ]
    clock = next((p for p, column in enumerate(headings) if column.name == "time"), None)
    kept: list[int] = []
    before: float | None = None
    for index, row in enumerate(sheet.rows):
        if len(row) != len(headings) or not all(can_read(f, row[place]) for place, f in wanted):
            continue
        time = None if clock is None else sheet.parser(headings[clock])(row[clock])
        if time is None or time != before:
            kept.append(index)
        before = time
    return kept


def _or_gap(parse: Callable[[str], float]) -> Callable[[str], float]:
    """Return a parser that is content with a gap."""
    return lambda cell: 0.0 if is_gap(cell) else parse(cell)


def _refuse_ragged(sheet: Sheet, headings: list[FileColumn]) -> None:
    width = len(headings)
    index = next((i for i, row in enumerate(sheet.rows) if len(row) != width), None)
    if index is not None:
        listed = ", ".join(f"`{column.name}`" for column in headings)
        raise DataError(
            f"{sheet.where}, row {sheet.numbers[index]} has {len(sheet.rows[index])} cells, "
            f"but there are {width} columns: {listed}."
        )


def _refuse_disorder(sheet: Sheet, times: list[float]) -> None:
    index = out_of_order(times)
    if index is not None:
        raise DataError(
            f"{sheet.where}: time must increase from row to row, but row {sheet.numbers[index]} "
            f"goes from {times[index - 1]:.15g} s to {times[index]:.15g} s."
        )


def _refuse_other_time(where: str, names: Mapping[str, str], interval: float | None) -> None:
    """A time under another name must not be replaced by an assumed one unnoticed."""
    suspect = next((n for n, unit in names.items() if unit == "s" or n.startswith("time")), None)
    if suspect is not None and interval is None:
        raise DataError(
            f"{where} has no column `time`, but `{suspect}` seems to be one; head it `time [s]`, "
            "or give the `interval` between rows."
        )
