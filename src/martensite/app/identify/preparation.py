"""Preparation of a log before a fit: smoothing, median, outliers, zero, resampling, cut; each step in words.

"steps": [{"kind": "median", "column": "temperature", "width": 5}, …], applied in their order

    smooth     column, width        mean of so many rows about each
    median     column, width        median of so many rows about each
    outliers   column, limit        samples so many scatters away from the median of their 7 neighbours are missing
    zero       column, rows         less the mean of the first rows
    offset     column, value        plus a number [SI]
    resample   interval             rows so far apart [s], straight lines between
    cut        from, to             rows between two times [s]
    hold       column               the mean of the column in every row

Only these steps change the log. Each step reports the number of changed rows and the largest change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.app.messages import Request, require_entry
from martensite.base import units
from martensite.base.errors import DataError, InputError, suggest_name
from martensite.search.quantity_text import format_change, format_number, format_quantity
from martensite.signals.records import Record

WIDEST = 1001
"""Rows of the widest window."""
NEIGHBOURS = 7
"""Rows of the window in which outliers are told."""
SCATTER = 1.4826
"""Standard deviation over median absolute deviation of normal noise."""
MOST_ROWS = 200_000
"""Largest number of rows of a resampled log."""


@dataclass(frozen=True)
class Prepared:
    """A record after some steps, and what each did."""

    record: Record
    words: tuple[str, ...] = ()


def prepare_record(record: Record, steps: Sequence[Request]) -> Prepared:
    """Apply steps one after the other.

    Raises:
        InputError: a step is none, names no column, or leaves nothing.
    """
    words: list[str] = []
    for step in steps:
        kind = require_entry(step, "kind", str)
        if kind not in STEPS:
            raise InputError(f"There is no step `{kind}`. {suggest_name(kind, STEPS)}")
        record, said = STEPS[kind](record, step)
        words.append(said)
    return Prepared(record, tuple(words))


def _read_column(record: Record, step: Request) -> tuple[str, Any]:
    name = require_entry(step, "column", str)
    return name, np.asarray(record[name], float)


def _with_column(record: Record, name: str, values: Any) -> Record:
    return replace(record, columns=record.columns | {name: values.tolist()})


def _list_windows(values: Any, width: int) -> Any:
    """(rows, width): the rows about each; beyond the ends there is nothing (NaN)."""
    half = width // 2
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, half, constant_values=np.nan), width)


def _read_width(step: Request) -> int:
    width = require_entry(step, "width", int)
    if not 3 <= width <= WIDEST or width % 2 == 0:
        raise InputError(f"A window must have an odd number of rows, 3 to {WIDEST}, but has {width}.")
    return width


def _format_most(record: Record, name: str, before: Any, after: Any) -> str:
    apart = np.abs(after - before)
    most = float(np.nanmax(apart)) if np.isfinite(apart).any() else 0.0
    unit = record.units[name]
    if units.of_column(name, unit) == "%":
        return f"{format_number(100.0 * most, 3)} %"
    return format_change(most, unit, 3)


def _smooth_rows(record: Record, step: Request, take: Callable[..., Any], called: str) -> tuple[Record, str]:
    (name, values), width = _read_column(record, step), _read_width(step)
    known = np.isfinite(values)
    found = np.full(values.size, np.nan)
    found[known] = take(_list_windows(values, width)[known], axis=1)
    most = _format_most(record, name, values, found)
    return _with_column(record, name, found), f"`{name}`: {called} of {width} rows; at most {most} changed."


def _smooth_column(record: Record, step: Request) -> tuple[Record, str]:
    return _smooth_rows(record, step, np.nanmean, "mean")


def _take_median(record: Record, step: Request) -> tuple[Record, str]:
    return _smooth_rows(record, step, np.nanmedian, "median")


def _drop_outliers(record: Record, step: Request) -> tuple[Record, str]:
    """Hampel's rule."""
    (name, values), limit = _read_column(record, step), require_entry(step, "limit", float, 6.0)
    if not limit > 0.0:
        raise InputError(f"The limit of outliers must be above 0 scatters, but is {limit:g}.")
    known = np.isfinite(values)
    apart, middle = np.zeros(values.size), np.full(values.size, np.nan)
    middle[known] = np.nanmedian(_list_windows(values, NEIGHBOURS)[known], axis=1)
    apart[known] = np.abs(values - middle)[known]
    scatter = SCATTER * float(np.median(apart[known])) if known.any() else 0.0
    # a column at rest has zero scatter: use a thousandth of its range
    scatter = scatter or 1e-3 * float(np.ptp(values[known]) if known.any() else 0.0)
    gone = known & (apart > limit * scatter)
    if gone[known].all():
        raise DataError(f"All samples of `{name}` would be outliers.")
    rows = ", ".join(str(row + 1) for row in np.flatnonzero(gone)[:5]) + (", …" if gone.sum() > 5 else "")
    said = f"{int(gone.sum())} outliers beyond {limit:g} scatters count as missing (row {rows})"
    words = f"`{name}`: {said if gone.any() else f'no sample beyond {limit:g} scatters'}."
    return _with_column(record, name, np.where(gone, np.nan, values)), words


def _zero_column(record: Record, step: Request) -> tuple[Record, str]:
    (name, values), rows = _read_column(record, step), require_entry(step, "rows", int, 5)
    first = values[:rows][np.isfinite(values[:rows])] if rows > 0 else values[:0]
    if not first.size:
        raise DataError(f"The first {rows} rows of `{name}` hold no number.")
    zero = float(np.mean(first))
    # its offset is that of a difference
    most = _format_most(record, name, np.zeros(1), np.array([zero]))
    sign = "-" if zero < 0.0 else ""
    return (
        _with_column(record, name, values - zero),
        f"`{name}`: counted from the mean of its first {rows} rows, {sign}{most}.",
    )


def _shift_column(record: Record, step: Request) -> tuple[Record, str]:
    (name, values), value = _read_column(record, step), require_entry(step, "value", float)
    size = _format_most(record, name, np.zeros(1), np.array([value]))
    return _with_column(record, name, values + value), f"`{name}`: {size} {'less' if value < 0.0 else 'more'}."


def _hold_column(record: Record, step: Request) -> tuple[Record, str]:
    name, values = _read_column(record, step)
    if not np.isfinite(values).any():
        raise DataError(f"`{name}` holds no number.")
    mean = float(np.nanmean(values))
    most = _format_most(record, name, values, np.full(values.size, mean))
    said = f"`{name}`: its mean {format_quantity(mean, record.units[name])} in all rows; at most {most} changed."
    return _with_column(record, name, np.full(values.size, mean)), said


def _resample_rows(record: Record, step: Request) -> tuple[Record, str]:
    interval, times = require_entry(step, "interval", float), np.asarray(record.times)
    span = times[-1] - times[0]
    if not 0.0 < interval <= span or span / interval > MOST_ROWS:
        raise InputError(
            f"Rows must be {span / MOST_ROWS:.3g} s to {span:.3g} s apart, but are to be {interval:g} s apart."
        )
    grid = times[0] + interval * np.arange(int(span / interval + 1e-9) + 1)
    columns = {
        name: interpolate_column(grid, times, np.asarray(x, float)).tolist() for name, x in record.columns.items()
    }
    said = f"Rows {interval:g} s apart, straight lines between: {len(grid)} of {len(times)}."
    return replace(record, columns=columns | {"time": grid.tolist()}), said


def interpolate_column(grid: Any, times: Any, values: Any) -> Any:
    """Return the straight lines between neighbours; nothing beside a sample that is missing."""
    found = np.interp(grid, times, np.where(np.isfinite(values), values, 0.0))
    lost = np.interp(grid, times, (~np.isfinite(values)).astype(float))
    return np.where(lost > 1e-9, np.nan, found)


def _cut_rows(record: Record, step: Request) -> tuple[Record, str]:
    times = np.asarray(record.times)
    first = require_entry(step, "from", float, float(times[0]))
    last = require_entry(step, "to", float, float(times[-1]))
    kept = np.flatnonzero((times >= first) & (times <= last))
    if kept.size < 2:
        raise DataError(f"Between {first:.6g} s and {last:.6g} s there are {kept.size} rows.")
    columns = {name: [column[row] for row in kept] for name, column in record.columns.items()}
    said = f"Rows from {first:.6g} s to {last:.6g} s: {kept.size} of {len(times)}."
    return replace(record, columns=columns), said


STEPS: Mapping[str, Callable[[Record, Request], tuple[Record, str]]] = {
    "smooth": _smooth_column,
    "median": _take_median,
    "outliers": _drop_outliers,
    "zero": _zero_column,
    "offset": _shift_column,
    "resample": _resample_rows,
    "cut": _cut_rows,
    "hold": _hold_column,
}
