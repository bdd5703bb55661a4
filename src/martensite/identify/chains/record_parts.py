"""Parts of a record: rising and falling input, and stretches of equal length.

A turning point is followed by a return of more than a fraction of the range of the signal, so that noise is no turn. A
constant level belongs to the movement before it; before any movement the signal counts as falling. For pulses the
parts are heating and cooling.
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
"""Return after a turning point, as a fraction of the range."""
RISING, FALLING = "rising", "falling"
Masks = Mapping[str, Any]


def find_rising(signal: Any, reversal: float = REVERSAL) -> Numbers:
    """Return True where a signal of shape (samples,) rises, or is constant after rising.

    Args:
        signal: the signal.
        reversal: return after a turning point, as a fraction of the range.

    Raises:
        ParameterError: the reversal is not between 0 and 1.
    """
    if not 0.0 < reversal < 1.0:
        raise ParameterError(f"Argument `reversal` must be between 0 and 1, but is {reversal}.")
    values = np.asarray(signal, dtype=float)
    least = reversal * float(np.max(values) - np.min(values))
    rising = np.zeros(len(values), dtype=bool)
    sense, turn, low, high = 0, 0, 0, 0
    for i, value in enumerate(values.tolist()):
        low = i if value <= values[low] else low
        high = i if value >= values[high] else high
        if sense <= 0 and value - values[low] > least:
            turn, sense, high = low + 1, 1, i
        elif sense >= 0 and values[high] - value > least:
            rising[turn : high + 1] |= sense > 0
            sense, low = -1, i
    if sense > 0:
        rising[turn:] = True
    return rising


def split_by_direction(
    record: Sampled, masks: Masks | None = None, number: int = 0, reversal: float = REVERSAL
) -> dict[str, Numbers]:
    """Return the samples of rising and falling input (see `find_rising`), or of given masks (samples,), by name.

    Raises:
        DataError: a mask does not have one value per sample.
    """
    if masks is None:
        up = find_rising(record.inputs[:, number], reversal)
        return {RISING: up, FALLING: ~up}
    parts = {name: np.asarray(mask, dtype=bool) for name, mask in masks.items()}
    for name, mask in parts.items():
        if mask.shape != (len(record),):
            raise DataError(
                f"Mask `{name}` needs {len(record)} values, one per sample of record "
                f"`{record.name}`, but has the shape {mask.shape}."
            )
    return parts


COUNT = 10
"""Number of stretches of a record."""


@dataclass(frozen=True)
class ErrorStretch:
    """Errors of one output between two times."""

    output: str
    begin: float
    """Start [s]."""
    end: float
    """End [s]."""
    rms: float
    largest: float

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
        return asdict(self)


def summarise_segments(times: Numbers, residuals: Numbers, output: str, count: int = COUNT) -> list[ErrorStretch]:
    """Return the errors in stretches of equal length, without empty stretches."""
    stretches: list[ErrorStretch] = []
    for t, e in zip(np.array_split(times, count), np.array_split(residuals, count), strict=True):
        finite = e[np.isfinite(e)]
        if len(finite):
            size, largest = float(np.sqrt(np.mean(finite**2))), float(np.max(np.abs(finite)))
            stretches.append(ErrorStretch(output, float(t[0]), float(t[-1]), size, largest))
    return stretches


def known_stretch(values: Numbers) -> slice:
    """Return the longest run of finite values."""
    finite = np.concatenate([[False], np.isfinite(values), [False]]).astype(int)
    edges = np.flatnonzero(np.diff(finite))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return slice(0, 0)
    top = int(np.argmax(ends - begins))
    return slice(int(begins[top]), int(ends[top]))
