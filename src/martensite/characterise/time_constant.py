"""Time constant of an exponential rise or fall, from all rows of a record.

    y(t) = y_∞ + a exp[-(t - t₀)/τ],    t₀ the first row

is fitted by least squares. τ does not depend on when the step came, as long as all rows lie
behind it; reading the time to 63.2 % off one row would depend on that, on y_∞ and on noise.
Standard errors take the residuals as independent and of equal size. Residuals that run along
with each other (`follows` is False) say that the record is not one exponential: rows from before
the step, a second time constant, a limit of the supply.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from martensite.characterise.estimate import Estimate, parameters, propagated
from martensite.characterise.nonlinear_regression import least_squares
from martensite.confidence import LEVEL
from martensite.errors import DataError, SolveError

FEWEST = 6
"""Rows below which three numbers are not fitted."""
_TRIALS = 60
_ALONG = 0.5
_SMALL = 2e-3


@dataclass(frozen=True)
class Rise:
    """An exponential from one level to another."""

    tau: Estimate
    """Time constant τ [s]."""
    final: Estimate
    """Level y_∞ in the end, in the unit of the values."""
    change: Estimate
    """y_∞ less the fitted value at the first row, in the unit of the values."""
    deviation: float
    """Root mean square of the residuals, in the unit of the values."""
    correlation: float
    """Correlation of each residual with the next; near 0 for noise."""

    @property
    def follows(self) -> bool:
        """Whether the record follows an exponential: residuals small, or without a pattern."""
        small = self.deviation <= _SMALL * abs(self.change.value)
        return small or self.correlation < _ALONG

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """All numbers by name, for JSON."""
        return {
            "tau": self.tau.to_dict(level),
            "final": self.final.to_dict(level),
            "change": self.change.to_dict(level),
            "deviation": self.deviation,
            "correlation": self.correlation,
            "follows": self.follows,
        }


def fit_rise(times: Sequence[float], values: Sequence[float]) -> Rise:
    """Fit an exponential to a record that begins at or after the step.

    Args:
        times: times of the rows [s], rising.
        values: speed, current or whatever settles, in any unit.

    Raises:
        DataError: the rows are too few, not finite or not in order, do not change, or end
            before one time constant has passed.
    """
    _check(times, values)
    start, span = times[0], times[-1] - times[0]
    scale = max(values) - min(values)
    at = [time - start for time in times]
    guess = _guess(at, values)

    def residuals(numbers: tuple[float, ...]) -> list[float]:
        final, change, tau = numbers
        return [
            (value - values[-1]) / scale - (final - 1.0) + change * math.exp(min(-time / tau, 50.0))
            for time, value in zip(at, values, strict=True)
        ]

    sign = math.copysign(1.0, values[-1] - values[0])
    try:
        solution = least_squares(residuals, (1.0, sign, guess))
    except SolveError as error:
        raise DataError(
            f"A record of {span:.4g} s holds no time constant: no exponential fits best; record "
            "until the values settle."
        ) from error
    final, change, tau = parameters(residuals, solution)
    if not 0.0 < tau.value < span:
        raise DataError(
            f"A record of {span:.4g} s holds no time constant: the best fit has {tau.value:.4g} s; "
            "record until the values settle."
        )
    return Rise(
        tau,
        propagated(lambda share: values[-1] + scale * (share - 1.0), final),
        propagated(lambda share: scale * share, change),
        scale * solution.rms,
        _correlation(solution.residuals),
    )


def _guess(at: Sequence[float], values: Sequence[float]) -> float:
    """Best time constant of a row of trials, level and change being linear."""
    import numpy as np

    times, numbers = np.asarray(at, np.float64), np.asarray(values, np.float64)
    numbers = numbers - numbers[-1]
    best, least = math.nan, math.inf
    for tau in np.geomspace(times[1], 4.0 * times[-1], _TRIALS):
        columns = np.stack([np.ones_like(times), np.exp(-times / tau)], axis=1)
        fitted, *_ = np.linalg.lstsq(columns, numbers, rcond=None)
        left = numbers - columns @ fitted
        if left @ left < least:
            best, least = float(tau), float(left @ left)
    return best


def _correlation(residuals: Sequence[float]) -> float:
    """Correlation of each number with the next."""
    mean = sum(residuals) / len(residuals)
    numbers = [r - mean for r in residuals]
    total = sum(r * r for r in numbers)
    return sum(a * b for a, b in pairwise(numbers)) / total if total else 0.0


def _check(times: Sequence[float], values: Sequence[float]) -> None:
    if len(times) != len(values):
        raise DataError(
            f"Times and values must be equally many, but are {len(times)} and {len(values)}."
        )
    if len(times) < FEWEST:
        raise DataError(f"A time constant needs at least {FEWEST} rows, but has {len(times)}.")
    if not all(map(math.isfinite, (*times, *values))):
        raise DataError("Times and values of a rise must be finite, but are not all.")
    if any(after <= before for before, after in pairwise(times)):
        raise DataError("Times of a rise must increase from row to row, but do not.")
    if max(values) == min(values):
        raise DataError(f"All {len(values)} values are {values[0]:.6g}: nothing rises or falls.")
