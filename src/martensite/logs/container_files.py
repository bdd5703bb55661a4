"""Tables in binary files: spreadsheets, MAT, Parquet, netCDF, TDMS (LabVIEW) and MCAP (robots).

All but Parquet are read in a separate process (`logs.binary_files.read_apart`), because a damaged file can crash its
reader.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from martensite.base.errors import DataError, suggest_name
from martensite.base.files import MOST_LOG, check_ordinary
from martensite.base.lazy import import_extra
from martensite.logs.binary_files import BINARY, Columns, read_apart, read_arrays
from martensite.logs.open_files import describe_unreadable
from martensite.logs.raw_table import RawTable, describe_arrays, find_table

EXTRAS = {
    ".xlsx": ("openpyxl", "excel", "openpyxl", "read_workbook"),
    ".xlsm": ("openpyxl", "excel", "openpyxl", "read_workbook"),
    ".tdms": ("nptdms", "tdms", "npTDMS", "read_tdms"),
    ".mcap": ("mcap.reader", "mcap", "mcap", "read_mcap"),
}
"""Suffix -> module, extra that installs it, its title, and reader in this module."""
KINDS = (*BINARY, *EXTRAS)
MOST_ROWS = 1_048_576
"""Rows of a sheet."""
MOST_COLUMNS = 200
LEAST_SHARE = 0.1
"""Fewest numbers of a sheet with a table, relative to the fullest sheet."""
MOST_MESSAGES = 2_000_000
_TITLES = {
    ".mat": "MATLAB file",
    ".parquet": "Parquet file",
    ".nc": "netCDF file",
    ".h5": "HDF5 file",
    ".hdf5": "HDF5 file",
    ".tdms": "TDMS file",
}


def find_ending(path: str | Path) -> str:
    """Return the suffix of a file in lower case, without the sheet of `book.xlsx:SHEET`."""
    return part_sheet(Path(path))[0].suffix.lower()


def part_sheet(path: Path) -> tuple[Path, str]:
    """Return a file, and the sheet named after a spreadsheet; may be empty."""
    match = re.fullmatch(r"(.+\.xls[xm]):(.+)", str(path), re.IGNORECASE)
    return (path, "") if match is None else (Path(match[1]), match[2])


def list_sheets(source: str | Path) -> list[str | Path]:
    """Return a source for each sheet of a spreadsheet with a table; any other source unchanged."""
    path = Path(source)
    if path.suffix.lower() not in (".xlsx", ".xlsm") or not path.is_file():
        return [source]
    titles = [str(title) for title in _read_extra(path)["sheet"][1:]]
    return [f"{source}:{title}" for title in titles] if len(titles) > 1 else [source]


def read_container(path: Path) -> RawTable:
    """Return the table of a binary file.

    Raises:
        DataError: the file is missing, damaged, or has no table of numbers.
        InputError: the extra of its reader is not installed.
    """
    ending = find_ending(path)
    if ending in BINARY:
        return describe_arrays(path, read_arrays(path), _TITLES[ending])
    columns = _read_extra(path)
    if "sheet" not in columns:
        return describe_arrays(path, columns, f"{_TITLES.get(ending, 'MCAP file')}, {len(columns)} channels")
    sheet, *every = map(str, columns.pop("sheet"))
    rows = [(k, [str(cell) for cell in row]) for k, row in enumerate(zip(*columns.values(), strict=True), start=1)]
    filled = [(k, row) for k, row in rows if any(cell.strip() for cell in row)]
    table = find_table(path, filled, (f"spreadsheet, sheet `{sheet}`",))
    others = [one for one in every if one != sheet]
    if part_sheet(path)[1] or not others:
        return table
    listed = ", ".join(f"`{one}`" for one in others)
    note = f"Only sheet `{sheet}` is read. Tables are also in {listed}: write for example `{path.name}:{others[0]}`."
    return replace(table, notes=(note, *table.notes))


def _read_extra(path: Path) -> Columns:
    """Return the columns of a file with an optional reader."""
    file = part_sheet(path)[0]
    module, extra, title, reader = EXTRAS[find_ending(path)]
    import_extra(module, extra, title)
    with describe_unreadable(file):
        size = check_ordinary(file, MOST_LOG)
    return read_apart(path, f"{__name__}:{reader}", size)


def read_workbook(path: Path) -> Columns:
    """Return the cells of a sheet as text, by column: the named sheet, or the sheet with most numbers.

    Column `sheet` has its title, and the titles of all sheets with a table.
    """
    from openpyxl import load_workbook

    file, wanted = part_sheet(path)
    book = cast(Any, load_workbook(file, read_only=True, data_only=True))
    sheets = {str(sheet.title): _list_filled(sheet) for sheet in book.worksheets}
    counts = {title: sum(isinstance(x, int | float) for row in rows for x in row) for title, rows in sheets.items()}
    if not any(counts.values()):
        raise DataError(f"`{file.name}` holds no numbers in any of its sheets.")
    title = wanted or max(counts, key=counts.__getitem__)
    if title not in sheets:
        raise DataError(f"`{file.name}` has no sheet `{title}`. {suggest_name(title, sheets)}")
    most, rows = max(counts.values()), sheets[title]
    tables = [one for one, count in counts.items() if count > LEAST_SHARE * most]
    return {"sheet": np.array([title, *tables])} | _write_columns(rows)


def _write_columns(rows: list[list[Any]]) -> Columns:
    """Return the cells of rows as text, by column."""
    used = max((k for row in rows for k, cell in enumerate(row) if cell is not None), default=0) + 1
    texts = [[_write_cell(cell) for cell in row[:used]] + [""] * (used - len(row)) for row in rows]
    return {str(k): np.array([row[k] for row in texts]) for k in range(used)}


def _list_filled(sheet: Any) -> list[list[Any]]:
    """Return the rows of a sheet up to the last nonempty row."""
    every = sheet.iter_rows(values_only=True, max_row=MOST_ROWS, max_col=MOST_COLUMNS)
    rows = [[] if row.count(None) == len(row) else list(row) for row in every]
    while rows and not rows[-1]:
        rows.pop()
    return rows


def _write_cell(cell: Any) -> str:
    if cell is None:
        return ""
    return cell.isoformat(sep=" ") if hasattr(cell, "hour") and hasattr(cell, "year") else str(cell)


def read_tdms(path: Path) -> Columns:
    """Return the numeric channels of a TDMS file, by name with unit, and their times."""
    from nptdms import TdmsFile

    columns: Columns = {}
    times: dict[int, Any] = {}
    for group in cast(Any, TdmsFile.read(path)).groups():
        for channel in group.channels():
            values = np.asarray(channel[:])
            if values.dtype.kind == "M":
                values = (values - values[0]) / np.timedelta64(1, "s")
            if values.dtype.kind not in "iufb" or values.size < 2:
                continue
            unit = str(channel.properties.get("unit_string", ""))
            name = f"{channel.name} [{unit}]" if unit else str(channel.name)
            columns[f"{group.name} {name}" if name in columns else name] = values.astype(float)
            if "wf_increment" in channel.properties:
                times.setdefault(values.size, np.asarray(channel.time_track(), dtype=float))
    for length, clock in times.items():
        if not any("time" in name.lower() and len(column) == length for name, column in columns.items()):
            columns[f"time [s]{'' if len(times) == 1 else f' {length}'}"] = clock
    return columns


def read_mcap(path: Path) -> Columns:
    """Return the numeric fields of the JSON messages of an MCAP file, by dotted name over the log time [s].

    Messages of several topics are resampled to the topic with most messages; a field keeps its last value.
    """
    from mcap.reader import make_reader

    topics: dict[str, list[tuple[float, dict[str, float]]]] = {}
    others: set[str] = set()
    with path.open("rb") as file:
        for count, (_, channel, message) in enumerate(cast(Any, make_reader(file)).iter_messages()):
            if count >= MOST_MESSAGES:
                raise DataError(f"`{path.name}` holds more than {MOST_MESSAGES} messages.")
            if channel.message_encoding != "json":
                others.add(channel.message_encoding)
                continue
            fields = dict(_list_fields(json.loads(message.data)))
            if fields:
                topics.setdefault(channel.topic.strip("/"), []).append((message.log_time * 1e-9, fields))
    if not topics:
        encodings = f"; its messages are encoded as {', '.join(sorted(others))}" if others else ""
        raise DataError(f"`{path.name}` has no numeric messages in JSON{encodings}. Export it as CSV.")
    main = max(topics, key=lambda topic: len(topics[topic]))
    times = np.array([time for time, _ in topics[main]])
    columns: Columns = {"time [s]": times - times[0]}
    for topic, messages in topics.items():
        own = np.array([time for time, _ in messages])
        rows = np.searchsorted(own, times, side="right") - 1
        for name in dict.fromkeys(name for _, fields in messages for name in fields):
            values = np.array([fields.get(name, np.nan) for _, fields in messages])
            head = name if len(topics) == 1 else f"{topic}.{name}"
            columns[head] = np.where(rows >= 0, values[np.maximum(rows, 0)], np.nan)
    return columns


def _list_fields(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    if isinstance(value, Mapping):
        for key, inner in cast(Mapping[str, Any], value).items():
            yield from _list_fields(inner, f"{name}.{key}" if name else str(key))
    elif isinstance(value, int | float):
        yield name, float(value)
