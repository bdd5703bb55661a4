"""An uploaded table with the meaning that its columns were given: a record, cut into records.

"columns": [{"at": 0, "name": "time", "unit": "s"}, …]   columns that are not listed are not used
"interval": 0.1      time between rows [s], where no column is the time; 1 s if left out
"drop": true         cells of these columns that are no numbers count as missing; else they are refused
"steps": [{"kind": "median", …}]   what is done to it first, as `identify.preparation` takes it
"cuts": [{"name": "heating", "from": 0.0, "to": 12.5, "every": 1}]   [s]; the whole if empty
"further": [{as above, "merge": false, "shift": null}]   more logs: each a record (or its cuts), or, merged, more
    columns of the first on the first's times, by clock, by a quantity that both follow, or `shift` [s] later
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from martensite.app.identify.preparation import Prepared, prepare_record
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.uploads import UploadFolder
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.logs.column_meanings import guess_meanings
from martensite.logs.exact_tables import ASSUMED_INTERVAL
from martensite.logs.lab_files import LabFile, interpret_table, read_raw
from martensite.logs.layout import IGNORED, read_headings
from martensite.logs.merged_files import merge_by_clock
from martensite.signals.records import Record

FEWEST_ROWS = 8
"""Rows of a record without which nothing can be fitted."""
MOST_RECORDS = 40


def read_file(request: Request, desk: Desk) -> LabFile:
    """Return the whole table of one file in SI, as it was recorded.

    Raises:
        InputError: a column has no or a wrong unit, a cell is not a number, time does not increase.
    """
    path = UploadFolder(desk.folder).path(require_entry(request, "key", str))
    interval = request.get("interval")
    if interval is not None:
        interval = require_entry(request, "interval", float)
    return _read_file(
        path,
        tuple(_read_columns(request)),
        interval,
        require_entry(request, "drop", bool, False),
        require_entry(request, "separator", str, "auto"),
    )


def prepare_log(request: Request, desk: Desk) -> Prepared:
    """Return the first log as it is fitted: its own steps, then what is merged with it; and what was done, in words."""
    file = read_file(request, desk)
    own = prepare_record(file.record, list_steps(request))
    merged = [one for one in list_further(request) if require_entry(one, "merge", bool, False)]
    if not merged:
        return own
    others = [_prepare_file(one, desk) for one in merged]
    shifts = [None if one.get("shift") is None else require_entry(one, "shift", float) for one in merged]
    words, whole = list(own.words), replace(file, record=own.record, notes=())
    for (other, said), shift in zip(others, shifts, strict=True):
        whole = merge_by_clock([replace(whole, notes=()), other], None if shift is None else [shift])
        words += [*(f"`{other.path.name}`: {one}" for one in said), f"Merged. {' '.join(whole.notes)}"]
    return Prepared(replace(whole.record, name=own.record.name), tuple(words))


def _prepare_file(request: Request, desk: Desk) -> tuple[LabFile, tuple[str, ...]]:
    file = read_file(request, desk)
    found = prepare_record(file.record, list_steps(request))
    return replace(file, record=found.record, notes=()), found.words


def read_record(request: Request, desk: Desk) -> Record:
    """Return the whole of the first log, as it is fitted."""
    return prepare_log(request, desk).record


def list_steps(request: Request) -> list[JsonTable]:
    """Return the preparation steps of a log before it is cut."""
    return [_require_table(step, "steps") for step in require_entry(request, "steps", list, [])]


def list_further(request: Request) -> list[JsonTable]:
    """Return the logs beside the first."""
    found = [_require_table(one, "further") for one in require_entry(request, "further", list, [])]
    if len(found) >= MOST_RECORDS:
        raise DataError(f"{len(found) + 1} logs are too many; at most {MOST_RECORDS} are fitted.")
    return found


def read_records(request: Request, desk: Desk) -> list[Record]:
    """Return the records cut from the logs, in the order of the request, each with a unique name.

    Raises:
        InputError: as in `read_file`; or a cut is invalid.
    """
    found = _list_cut(request, read_record(request, desk))
    for one in list_further(request):
        if not require_entry(one, "merge", bool, False):
            found += _list_cut(one, _prepare_file(one, desk)[0].record)
    if len(found) > MOST_RECORDS:
        raise DataError(f"{len(found)} records are too many; at most {MOST_RECORDS} are fitted.")
    names = [one.name for one in found]
    return [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}") if names.count(one.name) > 1 else one
        for k, one in enumerate(found)
    ]


def _list_cut(request: Request, whole: Record) -> list[Record]:
    return [_cut_record(whole, cut) for cut in _read_cuts(request)] or [whole]


def describe_preparation(request: Request, desk: Desk) -> list[str]:
    """Describe the preparation of all logs of a request, in words."""
    first = prepare_log(request, desk).words
    more = [one for one in list_further(request) if not require_entry(one, "merge", bool, False)]
    several = bool(more)
    label = f"`{read_file(request, desk).record.name}`: " if several else ""
    found = [f"{label}{one}" for one in first]
    for one in more:
        file, words = _prepare_file(one, desk)
        found += [f"`{file.record.name}`: {said}" for said in words]
    return found


def describe_cuts(request: Request, desk: Desk) -> list[JsonTable]:
    """Return name and rows of every cut, or the reason against it, while the user is still cutting."""
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
        raise DataError("No column is used. Choose the meaning of at least two columns.")
    return columns


def _require_table(entry: Any, name: str) -> JsonTable:
    if not isinstance(entry, dict):
        raise BadMessageError(f"`{name}` must hold tables, but holds {str(entry)[:40]!r}.")
    return cast("JsonTable", entry)


@lru_cache(maxsize=8)
def _read_file(
    path: Path, columns: tuple[tuple[int, str, str], ...], interval: float | None, drop: bool, separator: str
) -> LabFile:
    """Return a file as it was recorded; the last ones are remembered."""
    raw = read_raw(path, separator)
    headings = {at: f"{name} [{unit}]" if unit else name for at, name, unit in columns}
    wrong = next((at for at in headings if not 0 <= at < len(raw.columns)), None)
    if wrong is not None:
        raise DataError(f"There is no column {wrong + 1}; the file has {len(raw.columns)}.")
    meant = dict(zip(headings, read_headings(headings.values(), f"`{path.name}`"), strict=True))
    for at, column in meant.items():
        if raw.columns[at].wrong and not drop:
            row, text = raw.columns[at].wrong[0]
            raise DataError(f"`{path.name}`, row {row}, column `{column.name}`: `{text}` is not a number.")
    # an unchanged guess by values can be corrected by values
    guessed = {at: (one.name, one.unit) for at, one in enumerate(guess_meanings(raw, {}))}
    said = {at: (name, unit) for at, name, unit in columns}
    named = {
        str(at + 1): headings.get(at, IGNORED) for at in range(len(raw.columns)) if said.get(at) != guessed.get(at)
    }
    found = interpret_table(raw, path, named)
    return found if found.has_time else found.with_interval(interval or ASSUMED_INTERVAL)


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
