"""Preparation of a log before a fit; each step is described in words.

"steps": [{"kind": "median", "column": "temperature", "width": 5}, …], applied in order

    smooth     column, width        mean of `width` rows about each
    median     column, width        median of `width` rows about each
    outliers   column, limit        samples `limit` scatters away from the median of 7 neighbours are missing
    zero       column, rows         minus the mean of the first rows
    offset     column, value        plus a value [SI]
    resample   interval             rows at an interval [s], linear interpolation
    cut        from, to             rows between two times [s]
    hold       column               the mean of the column in each row

Only these steps change the log. Each step reports the number of changed rows and the largest change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.app.messages import Request, require_choice, require_entry
from martensite.base import units
from martensite.base.errors import DataError, InputError
from martensite.search.quantity_text import format_change, format_number, format_quantity
from martensite.signals.records import Record

WIDEST = 1001
"""Largest number of rows of a window."""
NEIGHBOURS = 7
"""Rows of the window for outliers."""
SCATTER = 1.4826
"""Standard deviation over median absolute deviation of normal noise."""
MOST_ROWS = 200_000
"""Largest number of rows of a resampled log."""


@dataclass(frozen=True)
class PreparedRecord:
    """A record after some steps, and their descriptions."""

    record: Record
    words: tuple[str, ...] = ()


def prepare_record(record: Record, steps: Sequence[Request]) -> PreparedRecord:
    """Apply steps in order."""
    words: list[str] = []
    for step in steps:
        kind = require_choice(step, "kind", "step", STEPS)
        record, sentence = STEPS[kind](record, step)
        words.append(sentence)
    return PreparedRecord(record, tuple(words))


def _read_column(record: Record, step: Request) -> tuple[str, Any]:
    name = require_entry(step, "column", str)
    return name, np.asarray(record[name], float)


def _with_column(record: Record, name: str, values: Any) -> Record:
    return replace(record, columns=record.columns | {name: values})


def _list_windows(values: Any, width: int) -> Any:
    """Return the rows about each row (rows, width), NaN beyond the ends."""
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
    finite = np.isfinite(values)
    smoothed = np.full(values.size, np.nan)
    smoothed[finite] = take(_list_windows(values, width)[finite], axis=1)
    most = _format_most(record, name, values, smoothed)
    return _with_column(record, name, smoothed), f"`{name}`: {called} of {width} rows; at most {most} changed."


def _smooth_column(record: Record, step: Request) -> tuple[Record, str]:
    return _smooth_rows(record, step, np.nanmean, "mean")


def _take_median(record: Record, step: Request) -> tuple[Record, str]:
    return _smooth_rows(record, step, np.nanmedian, "median")


def _drop_outliers(record: Record, step: Request) -> tuple[Record, str]:
    """Mark outliers as missing by Hampel's rule."""
    (name, values), limit = _read_column(record, step), require_entry(step, "limit", float, 6.0)
    if not limit > 0.0:
        raise InputError(f"The limit of outliers must be above 0 scatters, but is {limit:g}.")
    finite = np.isfinite(values)
    apart, middle = np.zeros(values.size), np.full(values.size, np.nan)
    middle[finite] = np.nanmedian(_list_windows(values, NEIGHBOURS)[finite], axis=1)
    apart[finite] = np.abs(values - middle)[finite]
    scatter = SCATTER * float(np.median(apart[finite])) if finite.any() else 0.0
    # a column at rest has zero scatter: use a thousandth of its range
    scatter = scatter or 1e-3 * float(np.ptp(values[finite]) if finite.any() else 0.0)
    outliers = finite & (apart > limit * scatter)
    if outliers[finite].all():
        raise DataError(f"All samples of `{name}` would be outliers.")
    rows = ", ".join(str(row + 1) for row in np.flatnonzero(outliers)[:5]) + (", …" if outliers.sum() > 5 else "")
    sentence = f"{int(outliers.sum())} outliers beyond {limit:g} scatters count as missing (row {rows})"
    words = f"`{name}`: {sentence if outliers.any() else f'no sample beyond {limit:g} scatters'}."
    return _with_column(record, name, np.where(outliers, np.nan, values)), words


def _zero_column(record: Record, step: Request) -> tuple[Record, str]:
    (name, values), rows = _read_column(record, step), require_entry(step, "rows", int, 5)
    first = values[:rows][np.isfinite(values[:rows])] if rows > 0 else values[:0]
    if not first.size:
        raise DataError(f"The first {rows} rows of `{name}` hold no number.")
    zero = float(np.mean(first))
    # a difference has no offset
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
    sentence = f"`{name}`: its mean {format_quantity(mean, record.units[name])} in all rows; at most {most} changed."
    return _with_column(record, name, np.full(values.size, mean)), sentence


def _resample_rows(record: Record, step: Request) -> tuple[Record, str]:
    interval, times = require_entry(step, "interval", float), np.asarray(record.times)
    span = times[-1] - times[0]
    if not 0.0 < interval <= span or span / interval > MOST_ROWS:
        raise InputError(
            f"Rows must be {span / MOST_ROWS:.3g} s to {span:.3g} s apart, but are to be {interval:g} s apart."
        )
    grid = times[0] + interval * np.arange(int(span / interval + 1e-9) + 1)
    columns = {name: interpolate_column(grid, times, x) for name, x in record.columns.items()}
    sentence = f"Rows {interval:g} s apart, straight lines between: {len(grid)} of {len(times)}."
    return replace(record, columns=columns | {"time": grid}), sentence


def interpolate_column(grid: Any, times: Any, values: Any) -> Any:
    """Return linear interpolation; NaN next to a missing sample."""
    interpolated = np.interp(grid, times, np.where(np.isfinite(values), values, 0.0))
    lost = np.interp(grid, times, (~np.isfinite(values)).astype(float))
    return np.where(lost > 1e-9, np.nan, interpolated)


def _cut_rows(record: Record, step: Request) -> tuple[Record, str]:
    times = np.asarray(record.times)
    first = require_entry(step, "from", float, float(times[0]))
    last = require_entry(step, "to", float, float(times[-1]))
    rows = np.flatnonzero((times >= first) & (times <= last))
    if rows.size < 2:
        raise DataError(f"Between {first:.6g} s and {last:.6g} s there are {rows.size} rows.")
    columns = {name: column[rows] for name, column in record.columns.items()}
    sentence = f"Rows from {first:.6g} s to {last:.6g} s: {rows.size} of {len(times)}."
    return replace(record, columns=columns), sentence


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
