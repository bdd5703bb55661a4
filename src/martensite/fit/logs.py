"""Logs: records of a fit with their scenarios, and the choice of held-out data.

auto     3 or more records: the middle record of the list; fewer: four stretches of each cycle,
the fifth, tenth, fifteenth and last of twenty of equal length along its path (`path_places`)
parts    such stretches of each record
none     no held-out data
each     every record, or every specimen of a group `specimen`, in turn: from fits to all others
25 %     the last quarter of each record (any fraction below 100 %)
A, B     records of these names
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, InputError, require_known
from martensite.fit.experiment import ALL
from martensite.fit.free_parameters import split_list
from martensite.logs.exact_tables import ASSUMED_INTERVAL
from martensite.logs.reader import read_log_table
from martensite.scenario.recorded_waveforms import from_zero
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.search.quantity_text import list_names
from martensite.signals.records import Record

Stretches = tuple[tuple[float, float], ...]
AUTO, PARTS, NONE, EACH = "auto", "parts", "none", "each"
MANY_RECORDS = 3
"""Number of records from which a whole record is held out."""
STRETCHES, KEPT = 20, (4, 9, 14, 19)
Source = str | Path | Record
Model = str | Path | Scenario


@dataclass(frozen=True)
class Log:
    """Record with the scenario that models it."""

    source: Source
    """File, `data:<data set>/<file>`, or record."""
    scenario: Model
    interval: float | None = None
    """Time between rows [s] of a file without times."""
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Changes to the scenario, by dotted path."""
    weight: float = 1.0
    """Weight of the squared residuals of the log."""
    is_held_out: bool = False
    """True if the log is held out."""
    name: str = ""
    """Name in reports; by default the name of the file."""
    new_headings: Mapping[str, str] = field(default_factory=dict[str, str])
    """Meaning of columns of the file, by heading or number, which replaces a guess (`read_lab_file`)."""
    groups: Mapping[str, str] = field(default_factory=dict[str, str])
    """Groups of the log, by kind: `specimen` -> A."""

    def read(self) -> Record:
        """Return the record, with NaN for missing samples."""
        if isinstance(self.source, Record):
            return self.source
        return read_log_table(self.source, self.interval, self.new_headings)

    def model(self, record: Record) -> Scenario:
        """Return the scenario for a record."""
        given = self.scenario
        if not isinstance(given, Scenario):
            given = load(given, self.settings, log=record)
        elif self.settings or given.follows:
            given = read_scenario(given.text, given.path, self.settings, log=record)
        return given.require_home("A fit")


@dataclass(frozen=True)
class LoadedLog:
    """A log that has been read."""

    log: Log
    name: str
    record: Record
    scenario: Scenario


def read_logs(logs: Sequence[Log]) -> list[LoadedLog]:
    """Read logs and build their scenarios; records with equal names are numbered.

    Raises:
        InputError: a file is missing or malformed, or does not fit its scenario.
    """
    loaded_logs: list[LoadedLog] = []
    for log in logs:
        record = log.read()
        scenario = log.model(record)
        if scenario.follows:
            record = from_zero(record)
        loaded_logs.append(LoadedLog(log, log.name or _shorten_name(record), record, scenario))
    names = [one.name for one in loaded_logs]
    return [
        replace(one, name=f"{one.name}-{names[:k].count(one.name) + 1}") if names.count(one.name) > 1 else one
        for k, one in enumerate(loaded_logs)
    ]


def _shorten_name(record: Record) -> str:
    last = record.name.rpartition("/")[2]
    return last.rpartition(".")[0] or last if "/" in record.name else last


def describe_untimed(loaded_logs: Sequence[LoadedLog]) -> list[str]:
    """Return a sentence about files without times and without a given interval."""
    given = [one for one in loaded_logs if not isinstance(one.log.source, Record)]
    names = [one.name for one in given if one.log.interval is None and one.record.interval]
    if not names:
        return []
    return [f"{list_names(names)} without times: rows are taken as {ASSUMED_INTERVAL:g} s apart."]


def describe_gaps(one: LoadedLog, columns: Iterable[str]) -> list[str]:
    """Return remarks on missing samples of a log."""
    follows, record = one.scenario.follows.values(), one.record
    notes: list[str] = []
    for name in dict.fromkeys([*follows, *columns]):
        missing = int(np.isnan(record.columns.get(name, ())).sum())
        if missing:
            then = "bridged by straight lines" if name in follows else "passed over"
            notes.append(
                f"{missing} of {len(record)} samples of `{name}` in record `{record.name}` are missing and {then}."
            )
    if record.dropped:
        notes.append(f"{record.dropped} rows of record `{record.name}` could not be read.")
    return notes


def check_matching(logs: Sequence[Source], scenarios: Sequence[Model]) -> list[Model]:
    """Return one scenario for every log.

    Raises:
        DataError: the number of scenarios is neither 1 nor the number of logs.
    """
    if len(scenarios) == 1:
        return list(scenarios) * len(logs)
    if len(scenarios) != len(logs):
        raise DataError(f"{len(logs)} logs have {len(scenarios)} scenarios; give one for all, or one each.")
    return list(scenarios)


def choose_held_out(
    hold_out: str | Sequence[str],
    names: Sequence[str],
    times: Sequence[Sequence[float]],
    places: Sequence[Any] | None = None,
) -> list[Stretches]:
    """Return the held-out time intervals of every record.

    Args:
        hold_out: text as above.
        names: names of the records.
        times: times of their rows [s].
        places: positions of their rows on the path of a cycle, from 0 to 1, by default in proportion to time.

    Raises:
        InputError: an invalid fraction, an unknown record, or no data left to fit.
    """
    if hold_out in (AUTO, PARTS):
        if hold_out == AUTO and len(names) >= MANY_RECORDS:
            return [ALL if k == len(names) // 2 else () for k in range(len(names))]
        return [_choose_stretches(*pair) for pair in zip(times, places or map(_spread_evenly, times), strict=True)]
    if hold_out == EACH and len(names) < 2:
        raise InputError("There is only one record, so no data are left for the fit.")
    if hold_out in (NONE, EACH):
        return [() for _ in names]
    if isinstance(hold_out, str) and hold_out.strip().endswith("%"):
        share = read_share(hold_out)
        return [((rows[-1] - share * (rows[-1] - rows[0]), math.inf),) for rows in times]
    return _choose_named(split_list(hold_out), names)


def _choose_named(held_out_names: Sequence[str], names: Sequence[str]) -> list[Stretches]:
    """Return the named records as held out whole."""
    for name in held_out_names:
        require_known("record to hold out", name, [*names, AUTO, NONE, EACH, "25 %"])
    if len(set(held_out_names)) == len(names):
        raise InputError("All records are held out, and none is left to be fitted.")
    return [ALL if name in held_out_names else () for name in names]


def _spread_evenly(rows: Sequence[float]) -> Any:
    """Return times as fractions of their duration."""
    return (np.asarray(rows) - rows[0]) / ((rows[-1] - rows[0]) or 1.0)


def _choose_stretches(times: Sequence[float], places: Any) -> Stretches:
    """Return the intervals of time in the held-out parts of a path."""
    held_out_rows = np.isin(np.minimum(np.asarray(places) * STRETCHES, STRETCHES - 1).astype(int), KEPT)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], held_out_rows.astype(int), [0]])))
    return tuple((times[first], times[after - 1]) for first, after in ends.reshape(-1, 2).tolist())


def read_share(text: str) -> float:
    """Read a fraction such as `25 %`.

    Raises:
        InputError: the text is not between 0 and 100 %.
    """
    try:
        share = float(text.strip().removesuffix("%")) / 100.0
    except ValueError:
        share = math.nan
    if not 0.0 < share < 1.0:
        raise InputError(f"A held-out percentage must be between 0 and 100 %, but is `{text}`.")
    return share
