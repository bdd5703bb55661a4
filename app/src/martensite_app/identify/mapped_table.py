"""An uploaded table with the meaning that its columns were given: a record, cut into records.

"columns": [{"at": 0, "name": "time", "unit": "s"}, …]   columns that are not listed are not used
"interval": 0.1      time between rows [s], where no column is the time
"drop": true         leave out rows that cannot be read
"cuts": [{"name": "heating", "from": 0.0, "to": 12.5, "every": 1}]   [s]; the whole if empty
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.scenario.layout import IGNORED, Layout, read_headings
from martensite.scenario.sheets import SEPARATORS, read_sheet
from martensite.scenario.tables import read_table
from martensite.signals.records import Record, out_of_order
from martensite_app.identify.raw_table import BINARY, read_raw
from martensite_app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite_app.uploads import UploadFolder
from martensite_app.worker import Desk

FEWEST_ROWS = 8
"""Rows of a record without which nothing can be fitted."""
MOST_RECORDS = 40


def read_record(request: Request, desk: Desk) -> Record:
    """The whole table in SI.

    Raises:
        InputError: a column has no or a wrong unit, a cell is no number, time does not increase.
    """
    path = UploadFolder(desk.folder).path(require_entry(request, "key", str))
    interval = request.get("interval")
    if interval is not None:
        interval = require_entry(request, "interval", float)
    return _read_record(
        path,
        tuple(_read_columns(request)),
        interval,
        require_entry(request, "drop", bool, False),
        require_entry(request, "separator", str, "auto"),
    )


def read_records(request: Request, desk: Desk) -> list[Record]:
    """The records that a table was cut into, in the order of the request.

    Raises:
        InputError: as of `read_record`; or a cut is none.
    """
    whole = read_record(request, desk)
    return [_cut_record(whole, cut) for cut in _read_cuts(request)] or [whole]


def describe_cuts(request: Request, desk: Desk) -> list[JsonTable]:
    """Of every cut its name and rows, or why it is no record; for who is still cutting."""
    whole = read_record(request, desk)
    found: list[JsonTable] = []
    for cut in _read_cuts(request):
        try:
            record = _cut_record(whole, cut)
        except DataError as error:
            found.append({"name": str(cut.get("name", "")), "rows": 0, "refused": str(error)})
        else:
            found.append({"name": record.name, "rows": len(record), "refused": ""})
    return found


def _read_cuts(request: Request) -> list[JsonTable]:
    cuts = [_require_table(cut, "cuts") for cut in require_entry(request, "cuts", list, [])]
    if len(cuts) > MOST_RECORDS:
        raise DataError(f"{len(cuts)} records are too many; at most {MOST_RECORDS} are fitted.")
    return cuts


def _read_columns(request: Request) -> list[tuple[int, str, str]]:
    found = [_require_table(entry, "columns") for entry in require_entry(request, "columns", list)]
    columns = [
        (require_entry(x, "at", int), require_entry(x, "name", str).strip(), require_entry(x, "unit", str, "").strip())
        for x in found
    ]
    if not columns:
        raise DataError("No column is used; say what at least two of them are.")
    return columns


def _require_table(entry: Any, name: str) -> JsonTable:
    if not isinstance(entry, dict):
        raise BadMessageError(f"`{name}` must hold tables, but holds {str(entry)[:40]!r}.")
    return cast("JsonTable", entry)


@lru_cache(maxsize=2)
def _read_record(
    path: Path, columns: tuple[tuple[int, str, str], ...], interval: float | None, drop: bool, separator: str
) -> Record:
    """The record of a file; the last ones are remembered."""
    headings = {at: f"{name} [{unit}]" if unit else name for at, name, unit in columns}
    if path.suffix.lower() in BINARY:
        return _read_arrays(path, headings, interval)
    if separator not in ("auto", *SEPARATORS):
        raise ParameterError(f"There is no separator `{separator}`. {suggest_name('', SEPARATORS)}")
    width = len(read_sheet(path, Layout((), separator)).rows[0])
    _check_places(headings, width)
    listed = [headings.get(at, IGNORED) for at in range(width)]
    return read_table(path, listed, interval=interval, separator=separator, drop=drop, gaps=True)


def _check_places(headings: Mapping[int, str], count: int) -> None:
    wrong = next((at for at in headings if not 0 <= at < count), None)
    if wrong is not None:
        raise DataError(f"There is no column {wrong + 1}; the file has {count}.")


def _read_arrays(path: Path, headings: Mapping[int, str], interval: float | None) -> Record:
    raw = read_raw(path)
    _check_places(headings, len(raw.columns))
    found: dict[str, list[float]] = {}
    spelt: dict[str, str] = {}
    meant = read_headings(headings.values(), f"`{path.name}`")
    for at, column in zip(headings, meant, strict=True):
        factor, offset = units.find_conversion(column.spelling, column.unit)
        found[column.name] = [x * factor + offset for x in raw.columns[at].numbers]
        spelt[column.name] = column.unit
    if "time" not in found:
        if interval is None or not interval > 0.0:
            raise DataError(f"`{path.name}` has no time; give the time between rows.")
        times = [k * interval for k in range(raw.rows)]
        return Record(path.stem, {"time": times} | found, {"time": "s"} | spelt, path, interval=interval)
    row = out_of_order(found["time"])
    if row is not None or not all(map(math.isfinite, found["time"])):
        where = f", but not at row {row + 1}" if row is not None else ", and none may be missing"
        raise DataError(f"`{path.name}`: time must increase from row to row{where}.")
    return Record(path.stem, found, spelt, path)


def _cut_record(whole: Record, cut: Request) -> Record:
    times = whole.times
    first, last = (require_entry(cut, "from", float, times[0]), require_entry(cut, "to", float, times[-1]))
    every = require_entry(cut, "every", int, 1)
    name = require_entry(cut, "name", str, "").strip().replace(",", " ")[:60] or whole.name
    if every < 1:
        raise DataError(f"Record `{name}`: every {every}th row cannot be taken; 1 is the least.")
    rows = range(bisect_left(times, first), bisect_right(times, last), every)
    if len(rows) < FEWEST_ROWS:
        raise DataError(
            f"Record `{name}`, {first:.6g} s to {last:.6g} s, has {len(rows)} rows; a fit needs at least {FEWEST_ROWS}."
        )
    columns = {key: [column[row] for row in rows] for key, column in whole.columns.items()}
    return Record(name, columns, whole.units, whole.source, whole.dropped, whole.interval)
