"""Conversion of measured tables to records at equal intervals.

A table whose times lie on a grid (each within a quarter of an interval) is copied row by row; missing rows become
samples without outputs. Any other table is resampled: inputs are held, outputs interpolated. `Sampled.remarks` lists
the changes. Values have readable units (°C, mm) unless other units are requested.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import cast

import numpy as np

from martensite.base import units as unit_table
from martensite.base.errors import DataError, suggest_name
from martensite.signals.records import Record, out_of_order
from martensite.signals.sampling.resampling import resample_record
from martensite.signals.sampling.sampled import Numbers, Sampled

CLOSE = 0.25
"""Largest distance of a row from its grid point, in intervals."""
SAME = 1e-4
"""Relative difference of intervals that comes from rounded times."""
LEAST_ROWS = 20
"""Smallest number of rows between two gaps."""
APART = 3.0
"""Shortest gap without data, in typical intervals."""


def from_record(
    record: Record,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
) -> Sampled:
    """Return a measured table as a record at equal intervals.

    Args:
        record: table in SI.
        inputs: input columns; a missing sample takes the previous value.
        outputs: output columns; missing samples stay missing.
        interval: sample time [s]; by default the interval of the rows.
        units: unit of a column in the result; by default the readable unit.

    Raises:
        DataError: a column does not exist or is empty, or times do not increase.
        UnitError: a column cannot be converted to the unit.
    """
    if not inputs or not outputs:
        raise DataError("A record needs at least one input and one output column.")
    names = (*inputs, *outputs)
    spelled, columns = _list_columns(record, names, units or {})
    times = np.asarray(record.times)
    row = out_of_order(record.times)
    if len(times) < 2 or row is not None:
        where = f"but row {row} does not" if row is not None else "but there is one row only"
        raise DataError(f"Times of record `{record.name}` must increase, {where}.")
    u, y, first, remarks = _fill_held_inputs(record.name, columns, inputs, outputs)
    grid = _find_grid(times[first:], interval)
    tables, more = _on_grid(times[first:], u[first:], y[first:], grid)
    sampled = Sampled(
        name=record.name,
        interval=grid.interval,
        inputs=tables[0],
        outputs=tables[1],
        input_names=tuple(inputs),
        output_names=tuple(outputs),
        units=spelled,
        start=float(times[first]),
        remarks=(*remarks, *more),
    )
    if interval is None:
        return sampled
    if abs(interval / sampled.interval - 1.0) < SAME:
        return replace(sampled, interval=interval)
    return resample_record(sampled, interval)


def pieces_of_record(
    record: Record,
    inputs: Sequence[str],
    outputs: Sequence[str],
    longest: float,
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
) -> tuple[Sampled, ...]:
    """Return the pieces of a record between missing inputs or gaps longer than `longest` [s], without single rows.

    Raises:
        DataError: see `from_record`; also if no piece has two rows.
    """
    rows = _find_known_rows(record, inputs)
    times = np.asarray(record.times)[rows]
    ends = np.flatnonzero(np.diff(times) > longest) + 1
    parts = [part for part in np.split(rows, ends) if len(part) > 1]
    if not parts:
        raise DataError(f"Record `{record.name}` has no two rows with inputs within {longest:g} s.")
    step = interval
    if step is None:
        step = min(_find_grid(np.asarray(record.times)[p[0] : p[-1] + 1], None).interval for p in parts)
    return tuple(
        from_record(_select_rows(record, part, k, len(parts)), inputs, outputs, step, units)
        for k, part in enumerate(parts, start=1)
    )


def split_at_gaps(
    record: Record,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
) -> tuple[Sampled, ...]:
    """Split a table into records without gaps in the inputs, because a model needs all inputs.

    A gap exceeds three typical intervals. Each record has its own initial state. Tables with irregular times stay
    whole.

    Raises:
        DataError: see `from_record`.
    """
    times = np.asarray(record.times)
    whole = partial(from_record, record, inputs, outputs, interval, units)
    if len(times) < 2 or out_of_order(record.times) is not None:
        return (whole(),)
    rows = _find_known_rows(record, inputs)
    usual = float(np.median(np.diff(times)))
    gaps = np.diff(times[rows]) > (APART + 0.5) * usual
    if not gaps.any() or _find_grid(times, None).places is None:
        return (whole(),)
    parts = pieces_of_record(record, inputs, outputs, (APART + 0.5) * usual, interval, units)
    long = [part for part in parts if len(part) >= LEAST_ROWS]
    if not long:
        return (whole(),)
    missing = float(np.diff(times[rows])[gaps].sum())
    count = f"{int(gaps.sum())} gaps" if gaps.sum() > 1 else "a gap"
    remark = (
        f"Inputs are missing for {missing:.4g} s in {count}; the record is split there into {len(long)} of their own"
    )
    short = len(parts) - len(long)
    remark += f", {short} shorter than {LEAST_ROWS} rows left out." if short else "."
    return (replace(long[0], remarks=(remark, *long[0].remarks)), *long[1:])


def _find_known_rows(record: Record, inputs: Sequence[str]) -> Numbers:
    return np.flatnonzero(np.all(np.isfinite([np.asarray(record[name], dtype=float) for name in inputs]), axis=0))


def _select_rows(record: Record, part: Numbers, number: int, count: int) -> Record:
    rows = slice(int(part[0]), int(part[-1]) + 1)
    name = record.name if count == 1 else f"{record.name} ({number})"
    return replace(record, name=name, columns={n: c[rows] for n, c in record.columns.items()})


def _list_columns(
    record: Record, names: Sequence[str], units: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, Numbers]]:
    unknown = next((name for name in units if name not in record.columns), None)
    if unknown is not None:
        raise DataError(
            f"A unit is given for `{unknown}`, but record `{record.name}` has no such column. "
            f"{suggest_name(unknown, record.columns)}"
        )
    spelled: dict[str, str] = {}
    columns: dict[str, Numbers] = {}
    for name in names:
        column, unit = np.asarray(record[name], dtype=float), record.units[name]
        spelled[name] = units.get(name, unit_table.choose_readable_unit(unit))
        factor, offset = unit_table.find_conversion(spelled[name], unit)
        columns[name] = (column - offset) / factor
    return spelled, columns


def _fill_held_inputs(
    record: str, columns: Mapping[str, Numbers], inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[Numbers, Numbers, int, list[str]]:
    """Return inputs without gaps, outputs, the first row with all inputs, and remarks."""
    first, remarks = 0, list[str]()
    filled: list[Numbers] = []
    for name in inputs:
        finite = np.isfinite(columns[name])
        if not finite.any():
            raise DataError(f"Input `{name}` of record `{record}` is missing throughout.")
        first = max(first, int(np.argmax(finite)))
        last = np.maximum.accumulate(np.where(finite, np.arange(len(finite)), 0))
        filled.append(columns[name][last])
        missing = int((~finite[np.argmax(finite) :]).sum())
        if missing:
            remarks.append(f"Input `{name}` is missing in {missing} rows; the one before is held.")
    if first:
        remarks.append(f"The first {first} rows lack an input and were left out.")
    y = np.stack([columns[name] for name in outputs], axis=1)
    none = next((n for n, column in zip(outputs, y.T, strict=True) if np.isnan(column).all()), None)
    if none is not None:
        raise DataError(f"Output `{none}` of record `{record}` is missing throughout.")
    return np.stack(filled, axis=1), y, first, remarks


@dataclass(frozen=True)
class _Grid:
    interval: float
    places: Numbers | None
    """Grid index of each row; None if the rows are on no grid."""


def _find_grid(times: Numbers, wanted: float | None) -> _Grid:
    """Return the grid of some times, or the grid for resampling."""
    if len(times) < 2:
        return _Grid(wanted or 1.0, np.zeros(len(times), int))
    steps = np.diff(times)
    usual = float(np.median(steps))
    plain = np.arange(len(times))
    counted = np.concatenate([[0], np.cumsum(np.maximum(np.rint(steps / usual), 1.0))]).astype(int)
    for places in (plain, counted):
        interval = float(times[-1] - times[0]) / float(places[-1])
        if np.max(np.abs(times - times[0] - places * interval)) <= CLOSE * interval:
            return _Grid(_round_interval(interval, len(times)), places)
    return _Grid(min(usual, wanted or usual), None)


def _round_interval(interval: float, rows: int) -> float:
    """Return the shortest decimal number near an interval, without rounding errors of times."""
    for digits in range(1, 12):
        short = float(f"{interval:.{digits}g}")
        if abs(short - interval) * rows <= 1e-3 * interval:
            return short
    return interval


def _on_grid(times: Numbers, u: Numbers, y: Numbers, grid: _Grid) -> tuple[tuple[Numbers, Numbers], list[str]]:
    """Return inputs and outputs on the grid, and remarks."""
    if grid.places is None:
        return _interpolate_record(times, u, y, grid.interval)
    count = int(grid.places[-1]) + 1
    if count == len(times):
        return (u, y), []
    outputs = np.full((count, y.shape[1]), np.nan)
    outputs[grid.places] = y
    before = np.searchsorted(grid.places, np.arange(count), side="right") - 1
    gaps = sum(int(b - a > 1) for a, b in pairwise(grid.places))
    remark = (
        f"{count - len(times)} rows in {gaps} gaps are missing; inputs are held over them, outputs are missing there."
    )
    return (u[before], outputs), [remark]


def _interpolate_record(
    times: Numbers, u: Numbers, y: Numbers, interval: float
) -> tuple[tuple[Numbers, Numbers], list[str]]:
    steps = np.diff(times)
    at = times[0] + interval * np.arange(int((times[-1] - times[0]) / interval + 1e-6) + 1)
    rows = cast("Numbers", np.searchsorted(times, at + 1e-9 * interval, side="right"))
    before = np.clip(rows - 1, 0, len(u) - 1)
    columns = [_interpolate_column(at, times, column) for column in y.T]
    remark = (
        f"Times are irregular, {steps.min():.4g} to {steps.max():.4g} s apart; the record was "
        f"brought to {interval:.4g} s, inputs held, outputs interpolated."
    )
    return (u[before], np.stack(columns, axis=1)), [remark]


def _interpolate_column(at: Numbers, times: Numbers, column: Numbers) -> Numbers:
    """Return a column at other times; NaN within gaps."""
    finite = np.isfinite(column)
    times, column = times[finite], column[finite]
    if len(times) < 2:
        return np.full(len(at), np.nan)
    right = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
    wide = times[right] - times[right - 1] > APART * float(np.median(np.diff(times)))
    on_row = np.isclose(at, times[right]) | np.isclose(at, times[right - 1])
    outside = (at < times[0] - 1e-9) | (at > times[-1] + 1e-9)
    return np.where((wide & ~on_row) | outside, np.nan, np.interp(at, times, column))
