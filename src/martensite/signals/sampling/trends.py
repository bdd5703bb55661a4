"""Trends of records: removed before a fit and restored after it.

    y' = y - (a + b t),   t from the first sample

A trend is the mean of each signal, its least-squares line, or its initial steady level. For nonlinear systems, whose
gain depends on the level, remove only the initial steady level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import DataError, suggest_name
from martensite.signals.sampling.sampled import Numbers, Sampled

KINDS = ("mean", "line", "rest")
"""Kinds of trends."""


@dataclass(frozen=True, eq=False)
class Trend:
    """Levels at the first sample and slopes [1/s] of all signals."""

    inputs: Numbers
    """Levels, shape (inputs,)."""
    outputs: Numbers
    input_slopes: Numbers
    output_slopes: Numbers

    def remove_from(self, record: Sampled) -> Sampled:
        """Return a record without the trend."""
        return self._shift(record, -1.0)

    def restore_to(self, record: Sampled) -> Sampled:
        """Return a record with the trend added again."""
        return self._shift(record, 1.0)

    def _shift(self, record: Sampled, sign: float) -> Sampled:
        t = (record.times - record.start)[:, None]
        return replace(
            record,
            inputs=record.inputs + sign * (self.inputs + t * self.input_slopes),
            outputs=record.outputs + sign * (self.outputs + t * self.output_slopes),
        )


def find_trend(record: Sampled, kind: str = "mean", rest: float | None = None) -> Trend:
    """Return the trend of a record, of the kind `mean`, `line` or `rest`.

    `rest` is the steady time [s] at the beginning; by default it ends when an input first changes.

    Raises:
        DataError: the kind does not exist, or the level of a signal is unknown.
    """
    if kind not in KINDS:
        raise DataError(f"There is no trend `{kind}`. {suggest_name(kind, KINDS)}")
    part = record
    if kind == "rest":
        count = _count_resting(record) if rest is None else int(rest / record.interval + 1e-6)
        part = record.rows(0, max(count, 1))
    columns = [*part.inputs.T, *part.outputs.T]
    names = (*record.input_names, *record.output_names)
    t = part.times - part.start
    lines = [
        _fit_line(t, column, kind == "line", f"`{name}` of record `{record.name}`")
        for name, column in zip(names, columns, strict=True)
    ]
    levels, slopes = (np.array(numbers) for numbers in zip(*lines, strict=True))
    n = len(record.input_names)
    return Trend(levels[:n], levels[n:], slopes[:n], slopes[n:])


def remove_trend(record: Sampled, kind: str = "mean", rest: float | None = None) -> tuple[Sampled, Trend]:
    """Return a record without its trend, and the trend.

    Args:
        record: record in any units.
        kind: `mean`, `line` or `rest` (initial steady level).
        rest: steady time at the beginning [s]; by default until an input changes.

    Raises:
        DataError: the kind does not exist, or the level of a signal is unknown.
    """
    trend = find_trend(record, kind, rest)
    return trend.remove_from(record), trend


def _count_resting(record: Sampled) -> int:
    """Return the number of samples before an input first changes."""
    changed = np.any(record.inputs != record.inputs[0], axis=1)
    return int(np.argmax(changed)) if changed.any() else len(record)


def _fit_line(t: Numbers, values: Numbers, sloped: bool, what: str) -> tuple[float, float]:
    """Return the level at the first sample, and the slope."""
    finite = np.isfinite(values)
    if not finite.any():
        raise DataError(f"Signal {what} has no known samples to find its level from.")
    t, values = t[finite], values[finite]
    level, middle = _average_known(values), _average_known(t)
    spread = _average_known((t - middle) ** 2)
    if not sloped or spread == 0.0:
        return level, 0.0
    slope = _average_known((t - middle) * (values - level)) / spread
    return level - slope * middle, slope


def _average_known(values: Numbers) -> float:
    return float(np.sum(values)) / len(values)
