"""Levels and slopes of records: taken off before a fit, put back after it.

    y' = y - (a + b t),   t from the first sample

A trend is the mean of every signal, its straight line by least squares, or its level at rest at
the beginning. A model of what departs from a level is one of that level only: where the gain
depends on the level, as in every nonlinear system, take off nothing but the level at rest.
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
        return self._moved(record, -1.0)

    def restore_to(self, record: Sampled) -> Sampled:
        """Return a record with the trend put back."""
        return self._moved(record, 1.0)

    def _moved(self, record: Sampled, sign: float) -> Sampled:
        t = (record.times - record.start)[:, None]
        return replace(
            record,
            inputs=record.inputs + sign * (self.inputs + t * self.input_slopes),
            outputs=record.outputs + sign * (self.outputs + t * self.output_slopes),
        )


def find_trend(record: Sampled, kind: str = "mean", rest: float | None = None) -> Trend:
    """Find the trend of a record, of the kind `mean`, `line` or `rest`.

    For the last, `rest` says how long [s] the record is at rest at its beginning; by default until an input changes.

    Raises:
        DataError: the kind does not exist, or a signal is unknown where its level is needed.
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
    """Return a record without its trend, and the trend, which puts it back."""
    found = find_trend(record, kind, rest)
    return found.remove_from(record), found


def _count_resting(record: Sampled) -> int:
    """Return the samples until an input changes for the first time."""
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    return int(np.argmax(moved)) if moved.any() else len(record)


def _fit_line(t: Numbers, values: Numbers, sloped: bool, what: str) -> tuple[float, float]:
    """Return the level at the first sample, and slope."""
    known = np.isfinite(values)
    if not known.any():
        raise DataError(f"Signal {what} has no known samples to find its level from.")
    t, values = t[known], values[known]
    level, middle = _average_known(values), _average_known(t)
    spread = _average_known((t - middle) ** 2)
    if not sloped or spread == 0.0:
        return level, 0.0
    slope = _average_known((t - middle) * (values - level)) / spread
    return level - slope * middle, slope


def _average_known(values: Numbers) -> float:
    return float(np.sum(values)) / len(values)
