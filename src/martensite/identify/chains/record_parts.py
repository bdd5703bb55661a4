"""Which samples of a record belong to a rising input, and which to a falling one.

A signal is rising from one of its turning points to the next. A turning point is one from which
the signal comes back by more than a share of its range, so that noise and ripple are no turns;
a level that is held belongs to the movement that led to it, and what comes before any movement
counts as falling. On records of pulses the input rises
at the start of a pulse and falls at its end: these are then heating and cooling.

A record in stretches of equal length: where the errors are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.identify.blocks.base import Numbers
from martensite.signals.sampling.sampled import Sampled

REVERSAL = 0.02
"""Share of the range by which a signal must come back to have turned."""
RISING, FALLING = "rising", "falling"
Masks = Mapping[str, Any]


def find_rising(signal: Any, reversal: float = REVERSAL) -> Numbers:
    """True where a signal of shape (samples,) rises, or holds after it has risen.

    It has turned when it comes back by the share `reversal` of its range.

    Raises:
        ParameterError: the reversal is not between 0 and 1.
    """
    if not 0.0 < reversal < 1.0:
        raise ParameterError(f"Argument `reversal` must be between 0 and 1, but is {reversal}.")
    values = np.asarray(signal, dtype=float)
    least = reversal * float(np.max(values) - np.min(values))
    found = np.zeros(len(values), dtype=bool)
    sense, turn, low, high = 0, 0, 0, 0
    for i, value in enumerate(values.tolist()):
        low = i if value <= values[low] else low
        high = i if value >= values[high] else high
        if sense <= 0 and value - values[low] > least:
            turn, sense, high = low + 1, 1, i
        elif sense >= 0 and values[high] - value > least:
            found[turn : high + 1] |= sense > 0
            sense, low = -1, i
    if sense > 0:
        found[turn:] = True
    return found


def split_by_direction(
    record: Sampled, masks: Masks | None = None, number: int = 0, reversal: float = REVERSAL
) -> dict[str, Numbers]:
    """Samples by name: those of a rising and of a falling input, see `find_rising`, or those of given masks (samples,).

    Raises:
        DataError: a mask does not have one value per sample.
    """
    if masks is None:
        up = find_rising(record.inputs[:, number], reversal)
        return {RISING: up, FALLING: ~up}
    found = {name: np.asarray(mask, dtype=bool) for name, mask in masks.items()}
    for name, mask in found.items():
        if mask.shape != (len(record),):
            raise DataError(
                f"Mask `{name}` needs {len(record)} values, one per sample of record "
                f"`{record.name}`, but has the shape {mask.shape}."
            )
    return found


COUNT = 10
"""Stretches of a record."""


@dataclass(frozen=True)
class ErrorStretch:
    """Errors of one output from one time to another."""

    output: str
    begin: float
    """[s]"""
    end: float
    """[s]"""
    rms: float
    largest: float
    """Largest error, whatever its sign."""

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
        return asdict(self)


def summarise_segments(times: Numbers, residuals: Numbers, output: str, count: int = COUNT) -> list[ErrorStretch]:
    """Return the errors in stretches of equal length, without those in which nothing is known."""
    found: list[ErrorStretch] = []
    for t, e in zip(np.array_split(times, count), np.array_split(residuals, count), strict=True):
        known = e[np.isfinite(e)]
        if len(known):
            size, largest = float(np.sqrt(np.mean(known**2))), float(np.max(np.abs(known)))
            found.append(ErrorStretch(output, float(t[0]), float(t[-1]), size, largest))
    return found


def known_stretch(values: Numbers) -> slice:
    """Return the longest run of finite values."""
    known = np.concatenate([[False], np.isfinite(values), [False]]).astype(int)
    edges = np.flatnonzero(np.diff(known))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return slice(0, 0)
    top = int(np.argmax(ends - begins))
    return slice(int(begins[top]), int(ends[top]))
