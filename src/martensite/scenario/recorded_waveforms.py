"""Recorded waveforms of a scenario, and the record to compare with.

    waveform = { kind = "table", file = "log.csv", column = "voltage" }
    waveform = { kind = "log", column = "voltage" }

`file` is relative to the scenario, or `data:…` for a published data set. `columns` names the columns of a file without
headings, `interval` the time between rows without a clock. A waveform may also be listed: `times = ["0 s", "10 s"],
values = ["0 V", "5 V"]`.

A waveform of kind `log` follows a column of the log of a fit or run. Without `column` it follows the column of the
driven quantity (`NATURAL`). The scenario begins with the first row of its log, or `[run] lead` before it, at the level
`from` of the waveform. Missing values are bridged. A column is linear between rows; a drive in volts, amperes, watts or
a duty that rests and jumps is held from row to row. `between = "linear"` or `"hold"` overrides this choice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, UnitError
from martensite.scenario.build import name_section, refuse_unknown
from martensite.signals.records import Record, table_waveform
from martensite.signals.table import Table

KIND = "table"
LOG = "log"
NATURAL = {
    "V": "voltage",
    "A": "current",
    "W": "power",
    "K": "temperature",
    "N": "force",
    "Pa": "stress",
    "m": "position",
    "1": "strain",
}
"""Default column of a waveform of kind `log`, by unit of the signal."""
DUTY = "duty"
"""Name of the column of the duty cycle."""
LINEAR, HOLD = "linear", "hold"
"""Interpolation of a column between its rows."""
STEPPED = ("V", "A", "W", "1")
"""Units of drives whose resting and jumping columns are held."""
JUMP, RESTING, MOSTLY = 0.1, 0.02, 0.9
"""Change between rows over the range of a jump, and of a rest; share of jumps between rests."""
JUST_BEFORE = 1e-4
"""Time before a row at which the previous level ends, in sampling intervals."""
_KEYS = ("file", "columns", "interval")
_LISTED = ("kind", "times", "values")


@cache
def unknown_log() -> Record:
    """Return a placeholder for a missing log; waveforms that follow it rest at 0 or at 20 degC."""
    return Record("log", {"time": [0.0, 1.0]}, {"time": "s"})


@dataclass(frozen=True)
class Recorded:
    """Table of measurements that is not read yet."""

    source: str | Path
    columns: tuple[str, ...] | None = None
    interval: float | None = None
    """Time between rows [s] of a file without time."""

    def read(self) -> Record:
        """Return the record of the file."""
        from martensite.logs.reader import read_table

        return read_table(self.source, self.columns, interval=self.interval)


def read_recorded(table: Mapping[str, Any], path: str, folder: Path) -> Recorded:
    """Return the recorded table of a section with `file`, `columns` and `interval`."""
    refuse_unknown(table, _KEYS, f"[{path}]")
    source = _read_text(table, "file", path)
    if not source.startswith("data:"):
        source = folder / source
    columns = table.get("columns")
    interval = table.get("interval")
    return Recorded(
        source,
        None if columns is None else tuple(_read_texts(columns, "columns", path)),
        None if interval is None else _read_quantity(interval, "interval", "s", path),
    )


def build_waveform(table: Mapping[str, Any], path: str, folder: Path, unit: str) -> tuple[Table, float]:
    """Return the waveform of a table in the `unit` of the source, and its end [s]."""
    if "file" not in table and "times" in table:
        waveform = _list_numbers(table, path, unit)
        return waveform, waveform.times[-1]
    refuse_unknown(table, ("kind", *_KEYS, "column"), f"[{path}]")
    column = _read_text(table, "column", path)
    with name_section(path):
        record = read_recorded({key: value for key, value in table.items() if key in _KEYS}, path, folder).read()
        waveform = table_waveform(record, column)
        if record.units[column] != unit:
            raise DataError(
                f"Column `{column}` of record `{record.name}` is in {record.units[column]}, but the drive needs {unit}."
            )
    return waveform, waveform.times[-1]


def build_followed(
    table: Mapping[str, Any], path: str, log: Record | None, unit: str, natural: str, lead: float = 0.0
) -> tuple[Table, str]:
    """Return the waveform of kind `log` of a table, and its column.

    Args:
        table: waveform with `kind`, perhaps `column` and `between`, and `from` with a lead.
        path: path of the table in the scenario.
        log: record to follow; required.
        unit: unit of the signal.
        natural: default column.
        lead: time before the log [s]; the signal goes straight from `from` to the first value, or is held.
    """
    refuse_unknown(table, ("kind", "column", "between", *(("from",) if lead else ())), f"[{path}]")
    between = _read_between(table, path)
    column = _read_text(table, "column", path) if "column" in table else natural
    if log is None:
        raise DataError(
            f"[{path}] This scenario follows a log; fit it with `martensite fit LOG --scenario "
            "SCENARIO --free …`, or run it with `martensite run SCENARIO --log LOG`."
        )
    if log is unknown_log():
        level = units.parse_quantity("20 degC", "K") if unit == "K" else 0.0
        return Table(times=(0.0, 1.0), values=(level, level)), column
    with name_section(path):
        _check_followed(log, column, unit)
        rows = zip(from_zero(log, lead).times.tolist(), log[column].tolist(), strict=True)
        finite = [row for row in rows if math.isfinite(row[1])]
        if lead:
            begin = _read_quantity(table["from"], "from", unit, path) if "from" in table else finite[0][1]
            finite.insert(0, (0.0, begin))
        if between == HOLD or (between is None and _is_held(unit, finite)):
            finite = hold_levels(finite)
        times, values = zip(*finite, strict=True)
        return Table(times=times, values=values), column


def _read_between(table: Mapping[str, Any], path: str) -> str | None:
    between = table.get("between")
    if between not in (None, LINEAR, HOLD):
        raise ParameterError(f"[{path}] `between` must be `{LINEAR}` or `{HOLD}`, but is {between!r}.")
    return between


def _is_held(unit: str, rows: Sequence[tuple[float, float]]) -> bool:
    """Return whether a signal [unit] of rows (time [s], value) is held between them."""
    return unit in STEPPED and is_stepped([x for _, x in rows])


def is_stepped(values: Sequence[float]) -> bool:
    """Return true for a column that rests at levels and jumps between them."""
    reach = max(values) - min(values)
    changes = [abs(b - a) for a, b in pairwise(values)]
    jumps = [k for k, change in enumerate(changes) if change > JUMP * reach]
    around = [max(changes[max(k - 1, 0) : k] + changes[k + 1 : k + 2], default=0.0) for k in jumps]
    return bool(jumps) and sum(change <= RESTING * reach for change in around) >= MOSTLY * len(jumps)


def hold_levels(rows: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return rows (time, level) with every level held until just before the next row."""
    levels = [rows[0]]
    for (before, level), (time, new) in pairwise(rows):
        if new != level:
            levels.append((time - JUST_BEFORE * (time - before), level))
        levels.append((time, new))
    return levels


def _check_followed(log: Record, column: str, unit: str) -> None:
    count = sum(map(math.isfinite, log[column]))
    if log.units[column] != unit:
        raise DataError(
            f"Column `{column}` of record `{log.name}` is in {log.units[column]}, but what follows it takes {unit}."
        )
    if count < 2:
        raise DataError(
            f"Column `{column}` of record `{log.name}` holds {count} numbers; a waveform that "
            "follows it needs at least 2."
        )


def from_zero(log: Record, lead: float = 0.0) -> Record:
    """Return a record with its first row at 0 s, or at a lead [s] after 0 s."""
    first = log.times[0] - lead
    if first == 0.0:
        return log
    return replace(log, columns=log.columns | {"time": log.times - first})


def _list_numbers(table: Mapping[str, Any], path: str, unit: str) -> Table:
    refuse_unknown(table, _LISTED, f"[{path}]")
    times = [_read_quantity(t, "times", "s", path) for t in _read_list(table["times"], "times", path)]
    levels = _read_list(table.get("values", []), "values", path)
    values = [_read_quantity(value, "values", unit, path) for value in levels]
    with name_section(path):
        return Table(times=tuple(times), values=tuple(values))


def _read_quantity(value: Any, name: str, unit: str, path: str) -> float:
    if not isinstance(value, str):
        raise UnitError(f"[{path}] `{name}` must be text with a unit, such as `{value} {unit}`, but is {value!r}.")
    with name_section(path):
        try:
            return units.parse_quantity(value, unit)
        except UnitError as error:
            raise UnitError(f"`{name}`: {error}") from None


def _read_text(table: Mapping[str, Any], name: str, path: str) -> Any:
    if name not in table:
        raise ParameterError(f"[{path}] needs `{name}`; none given.")
    if not isinstance(table[name], str):
        raise ParameterError(f"[{path}] `{name}` must be text, but is {table[name]!r}.")
    return table[name]


def _read_texts(value: Any, name: str, path: str) -> list[str]:
    items = _read_list(value, name, path)
    wrong = next((item for item in items if not isinstance(item, str)), None)
    if wrong is not None:
        raise ParameterError(f"[{path}] `{name}` must hold texts, but holds {wrong!r}.")
    return items


def _read_list(value: Any, name: str, path: str) -> list[Any]:
    if not isinstance(value, list):
        raise ParameterError(f"[{path}] `{name}` must be a list, but is {value!r}.")
    return cast("list[Any]", value)
