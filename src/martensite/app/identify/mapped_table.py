"""An uploaded table with the meaning of its columns: a record, cut into records.

"columns": [{"at": 0, "name": "time", "unit": "s", "factor": null}, …]   other columns are ignored; the numbers are
    multiplied by the factor: a 2 mm per volt sensor has the unit mm and the factor 2
"interval": 0.1      time between rows [s] without a time column; default 1 s
"drop": true         non-numeric cells of these columns are missing values; else they are refused
"steps": [{"kind": "median", …}]   preparation, as in `identify.preparation`
"cuts": [{"name": "heating", "from": 0.0, "to": 12.5, "every": 1}]   [s]; the whole record if empty
"further": [{as above, "merge": false, "shift": null}]   more logs: each a record (or its cuts), or, merged, more
    columns of the first on the first's times, by clock, by a common quantity, or `shift` [s] later
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from martensite.app.identify.preparation import PreparedRecord, prepare_record
from martensite.app.messages import JsonTable, Request, list_tables, read_optional, require_entry, require_table
from martensite.app.worker import Desk
from martensite.base.errors import DataError
from martensite.logs.column_meanings import guess_meanings
from martensite.logs.exact_tables import ASSUMED_INTERVAL
from martensite.logs.lab_files import LabFile, interpret_table, read_raw
from martensite.logs.layout import IGNORED, read_headings
from martensite.logs.merged_files import merge_by_clock
from martensite.logs.raw_table import RawTable
from martensite.signals.records import Record

FEWEST_ROWS = 8
"""Smallest number of rows of a record for a fit."""
MOST_RECORDS = 40
MappedColumn = tuple[int, str, str, float | None]
"""Place, name, unit and factor of a column."""


def read_file(request: Request, desk: Desk) -> LabFile:
    """Return the recorded table of one file in SI."""
    path = desk.files.path(require_entry(request, "key", str))
    return _read_file(
        path,
        tuple(_read_columns(request)),
        read_optional(request, "interval", float),
        require_entry(request, "drop", bool, False),
        require_entry(request, "separator", str, "auto"),
    )


def prepare_log(request: Request, desk: Desk) -> PreparedRecord:
    """Return the prepared first log, with merged logs, and descriptions of its preparation."""
    file = read_file(request, desk)
    own = prepare_record(file.record, list_steps(request))
    merged = [one for one in list_further(request) if require_entry(one, "merge", bool, False)]
    if not merged:
        return own
    others = [_prepare_file(one, desk) for one in merged]
    shifts = [read_optional(one, "shift", float) for one in merged]
    words, whole = list(own.words), replace(file, record=own.record, notes=())
    for (other, sentences), shift in zip(others, shifts, strict=True):
        whole = merge_by_clock([replace(whole, notes=()), other], None if shift is None else [shift])
        words += [*(f"`{other.path.name}`: {one}" for one in sentences), f"Merged. {' '.join(whole.notes)}"]
    return PreparedRecord(replace(whole.record, name=own.record.name), tuple(words))


def _prepare_file(request: Request, desk: Desk) -> tuple[LabFile, tuple[str, ...]]:
    file = read_file(request, desk)
    prepared = prepare_record(file.record, list_steps(request))
    return replace(file, record=prepared.record, notes=()), prepared.words


def read_record(request: Request, desk: Desk) -> Record:
    """Return the prepared first log."""
    return prepare_log(request, desk).record


def list_steps(request: Request) -> list[JsonTable]:
    """Return the preparation steps of a log."""
    return list_tables(request, "steps")


def list_further(request: Request) -> list[JsonTable]:
    """Return the logs after the first."""
    entries = list_tables(request, "further")
    if len(entries) >= MOST_RECORDS:
        raise DataError(f"{len(entries) + 1} logs are too many; at most {MOST_RECORDS} are fitted.")
    return entries


def read_records(request: Request, desk: Desk) -> list[Record]:
    """Return the records cut from the logs, in order, with unique names."""
    cut_rows = _list_cut(request, read_record(request, desk))
    for one in list_further(request):
        if not require_entry(one, "merge", bool, False):
            cut_rows += _list_cut(one, _prepare_file(one, desk)[0].record)
    if len(cut_rows) > MOST_RECORDS:
        raise DataError(f"{len(cut_rows)} records are too many; at most {MOST_RECORDS} are fitted.")
    names = [one.name for one in cut_rows]
    return [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}") if names.count(one.name) > 1 else one
        for k, one in enumerate(cut_rows)
    ]


def _list_cut(request: Request, whole: Record) -> list[Record]:
    return [_cut_record(whole, cut) for cut in _read_cuts(request)] or [whole]


def describe_preparation(request: Request, desk: Desk) -> list[str]:
    """Describe the preparation of all logs of a request."""
    first = prepare_log(request, desk).words
    more = [one for one in list_further(request) if not require_entry(one, "merge", bool, False)]
    several = bool(more)
    label = f"`{read_file(request, desk).record.name}`: " if several else ""
    sentences = [f"{label}{one}" for one in first]
    for one in more:
        file, words = _prepare_file(one, desk)
        sentences += [f"`{file.record.name}`: {sentence}" for sentence in words]
    return sentences


def describe_cuts(request: Request, desk: Desk) -> list[JsonTable]:
    """Return name and rows of each cut, or its error."""
    whole = read_record(request, desk)
    cut_rows: list[JsonTable] = []
    for cut in _read_cuts(request):
        try:
            record = _cut_record(whole, cut)
        except DataError as error:
            cut_rows.append({"name": str(cut.get("name", "")), "rows": 0, "refused": str(error)})
        else:
            cut_rows.append({"name": record.name, "rows": len(record), "refused": ""})
    return cut_rows


def _read_cuts(request: Request) -> list[JsonTable]:
    cuts = list_tables(request, "cuts")
    if len(cuts) > MOST_RECORDS:
        raise DataError(f"{len(cuts)} records are too many; at most {MOST_RECORDS} are fitted.")
    return cuts


def _read_columns(request: Request) -> list[MappedColumn]:
    tables = [require_table(entry, "columns") for entry in require_entry(request, "columns", list)]
    columns = [
        (
            require_entry(x, "at", int),
            require_entry(x, "name", str).strip(),
            require_entry(x, "unit", str, "").strip(),
            read_optional(x, "factor", float),
        )
        for x in tables
    ]
    if not columns:
        raise DataError("No column is used. Choose the meaning of at least two columns.")
    wrong = next((name for _, name, _, factor in columns if factor == 0.0), None)
    if wrong is not None:
        raise DataError(f"The factor of `{wrong}` is 0. Give another number, for example the millimetres per volt.")
    return columns


@lru_cache(maxsize=8)
def _read_file(
    path: Path, columns: tuple[MappedColumn, ...], interval: float | None, drop: bool, separator: str
) -> LabFile:
    """Return a recorded file, cached."""
    raw = read_raw(path, separator)
    headings = {at: f"{name} [{unit}]" if unit else name for at, name, unit, _ in columns}
    wrong = next((at for at in headings if not 0 <= at < len(raw.columns)), None)
    if wrong is not None:
        raise DataError(f"There is no column {wrong + 1}; the file has {len(raw.columns)}.")
    _check_cells(raw, headings, path, drop)
    file = interpret_table(raw, path, _name_columns(raw, columns, headings))
    return file if file.has_time else file.with_interval(interval or ASSUMED_INTERVAL)


def _check_cells(raw: RawTable, headings: Mapping[int, str], path: Path, drop: bool) -> None:
    """Raise `DataError` for a heading without a valid unit, or a cell that is not numeric unless these are dropped."""
    for at, column in zip(headings, read_headings(headings.values(), f"`{path.name}`"), strict=True):
        if raw.columns[at].wrong and not drop:
            row, text = raw.columns[at].wrong[0]
            raise DataError(f"`{path.name}`, row {row}, column `{column.name}`: `{text}` is not a number.")


def _name_columns(raw: RawTable, columns: Sequence[MappedColumn], headings: Mapping[int, str]) -> dict[str, str]:
    """Return the meaning of each column that differs from its guess; an unchanged guess can be corrected by values."""
    guessed = {at: (one.name, one.unit) for at, one in enumerate(guess_meanings(raw, {}))}
    table = {at: (name, unit) for at, name, unit, _ in columns}
    changed = [at for at in range(len(raw.columns)) if table.get(at) != guessed.get(at)]
    factors = {at: factor for at, _, _, factor in columns if factor is not None}
    named = {str(at + 1): headings.get(at, IGNORED) for at in changed}
    return named | {str(at + 1): f"{headings[at]}*{factor!r}" for at, factor in factors.items()}


def _cut_record(whole: Record, cut: Request) -> Record:
    times = whole.times.tolist()
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
    columns = {key: column[rows.start : rows.stop : every] for key, column in whole.columns.items()}
    return Record(name, columns, whole.units, whole.source, whole.dropped, whole.interval)
