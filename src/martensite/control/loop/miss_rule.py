"""Rule by which a loop reports, without measuring its output, that it may miss its reference.

    expected = √(mean of (x̂ - r)² + s²) / span of r        miss: expected > 4.5 %, or mean confidence < 0.8

x̂ is the controlled estimate, s its standard deviation and r the reference. Samples count after the estimates have
settled: 30 s after the calibration of the observer, or from the start without a calibration.

Both bounds were chosen on random wires of the seeds 11 to 14, with and without draughts, for at most 10 % of false
warnings (`benchmarks.unknown_wires`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from martensite.simulate.result import Result

EXPECTED, TRUSTED = 0.045, 0.8
"""Largest expected error over the span, and least mean confidence, without a miss."""
SETTLING = 30.0
"""Time after a calibration in which the estimates settle [s]."""


class Expectation(NamedTuple):
    """Expected error and confidence of a loop: numbers, or arrays over a batch."""

    error: Any
    """Expected rms error over the span of the reference; NaN if the reference is constant."""
    confidence: Any
    """Mean confidence."""

    @property
    def misses(self) -> Any:
        """Return True where the loop reports a miss."""
        return (self.error > EXPECTED) | (self.confidence < TRUSTED)


def expect_error(guess: Any, spread: Any, reference: Any, confidence: Any) -> Expectation:
    """Return the expected error and confidence over the given samples.

    Args:
        guess: controlled estimates, shape (samples, ...).
        spread: their standard deviations, of the same shape or 0.
        reference: reference, broadcast to this shape.
        confidence: confidence of the observer, shape (samples, ...).
    """
    size = np.sqrt(np.mean((guess - reference) ** 2 + np.square(spread), axis=0))
    span = float(np.ptp(reference))
    return Expectation(size / span if span > 0.0 else np.full_like(size, np.nan), np.mean(confidence, axis=0))


def find_settled(times: NDArray[np.float64], calibrating: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which samples count, from their times [s] and the calibrating samples."""
    if not calibrating.any():
        return np.ones(len(times), bool)
    return times > times[calibrating][-1] + SETTLING


def describe_expected_miss(result: Result, drive: str, name: str, reference: str) -> list[str]:
    """Return a warning if a loop expects to miss its reference; empty without a confidence.

    Args:
        result: run of the loop.
        drive: drive of its controller.
        name: column of the controlled estimate.
        reference: column of the reference.
    """
    owner, columns = name.rpartition(".")[0], result.columns
    names = name, f"{name}_std", reference, f"{owner}.confidence"
    if not set(names) <= set(columns):
        return []
    times = np.array(result.times)
    settled = find_settled(times, np.array(columns.get(f"{owner}.calibrating", np.zeros(len(times)))) > 0.5)
    if not settled.any():
        return [
            f"Warning: The run ends before the estimates have settled, {SETTLING:g} s after the calibration: it does "
            f"not show whether `{drive}` misses its reference. Try a longer `duration`."
        ]
    expectation = expect_error(*(np.array(columns[one])[settled] for one in names))
    if not expectation.misses:
        return []
    trusted = f"mean confidence of {expectation.confidence:.2f}"
    if np.isnan(expectation.error):
        return [f"Warning: `{drive}` may miss its reference: `{name}` has a {trusted}."]
    return [
        f"Warning: `{drive}` may miss its reference by more than 5 % of its span: by `{name}` it expects "
        f"{100.0 * expectation.error:.1f} % rms, with a {trusted}."
    ]
