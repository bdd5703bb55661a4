"""An uploaded table with the meaning that its columns were given: a record, cut into records.

"columns": [{"at": 0, "name": "time", "unit": "s"}, …]   columns that are not listed are not used
"interval": 0.1      time between rows [s], where no column is the time; 1 s if left out
"drop": true         cells of these columns that are no numbers count as missing; else they are refused
"cuts": [{"name": "heating", "from": 0.0, "to": 12.5, "every": 1}]   [s]; the whole if empty
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from martensite.base.errors import DataError
from martensite.scenario.lab_files import interpret_table, read_raw
from martensite.scenario.layout import IGNORED, read_headings
from martensite.scenario.tables import ASSUMED_INTERVAL
from martensite.signals.records import Record
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
    raw = read_raw(path, separator)
    headings = {at: f"{name} [{unit}]" if unit else name for at, name, unit in columns}
    wrong = next((at for at in headings if not 0 <= at < len(raw.columns)), None)
    if wrong is not None:
        raise DataError(f"There is no column {wrong + 1}; the file has {len(raw.columns)}.")
    meant = dict(zip(headings, read_headings(headings.values(), f"`{path.name}`"), strict=True))
    for at, column in meant.items():
        if raw.columns[at].wrong and not drop:
            row, _, text = raw.columns[at].wrong[0].partition(": ")
            raise DataError(f"`{path.name}`, {row}, column `{column.name}`: `{text}` is not a number.")
    named = {str(at + 1): headings.get(at, IGNORED) for at in range(len(raw.columns))}
    found = interpret_table(raw, path, named)
    return (found if found.has_time else found.with_interval(interval or ASSUMED_INTERVAL)).record


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
