"""Time constant of an exponential rise or fall, from all rows of a record.

    y(t) = y_∞ + a exp[-(t - t₀)/τ],    t₀ the first row

is fitted by least squares. τ does not depend on the time of the step, if all rows lie after it. The time to 63.2 %
would depend on the time of the step, on y_∞ and on noise. Standard errors take residuals as independent and of equal
variance. Correlated residuals (`follows` is False) mean that the record is not one exponential, because of rows before
the step, a second time constant, or a limit of the supply.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL
from martensite.base.errors import DataError, SolveError
from martensite.characterise.estimate import MeasuredValue, check_columns
from martensite.characterise.regression import fit_residuals

LEAST_ROWS = 6
"""Least number of rows for a fit."""
_ALONG = 0.5
_SMALL = 2e-3


@dataclass(frozen=True)
class Rise:
    """Exponential from one level to another."""

    tau: MeasuredValue
    """Time constant τ [s]."""
    final: MeasuredValue
    """Final level y_∞, in the unit of the values."""
    change: MeasuredValue
    """y_∞ minus the fitted value at the first row, in the unit of the values."""
    deviation: float
    """Root mean square of the residuals, in the unit of the values."""
    correlation: float
    """Correlation of each residual with the next; near 0 for noise."""

    @property
    def follows(self) -> bool:
        """Return whether the record follows an exponential: residuals small, or without a pattern."""
        small = self.deviation <= _SMALL * abs(self.change.value)
        return small or self.correlation < _ALONG

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        estimates = {name: getattr(self, name) for name in ("tau", "final", "change")}
        numbers = {name: getattr(self, name) for name in ("deviation", "correlation", "follows")}
        return {name: one.to_dict(level) for name, one in estimates.items()} | numbers


def fit_rise(times: Sequence[float], values: Sequence[float]) -> Rise:
    """Fit an exponential to a record that begins at or after the step.

    Args:
        times: times of the rows [s], rising.
        values: settling quantity, such as speed or current, in any unit.

    Raises:
        DataError: the rows are too few, not finite or not in order, do not change, or end before one time constant.
    """
    _check_record(times, values)
    span, last = times[-1] - times[0], values[-1]
    scale = max(values) - min(values)
    at = (np.asarray(times, np.float64) - times[0]) / span
    shares = (np.asarray(values, np.float64) - last) / scale

    def residuals(numbers: tuple[float, ...]) -> Any:
        final, change, tau = numbers
        return shares - final + change * np.exp(np.minimum(-at / tau, 50.0))

    sign = math.copysign(1.0, last - values[0])
    try:
        fit = fit_residuals(residuals, (0.0, sign, _guess_time(at, shares)))
    except SolveError as error:
        raise DataError(f"No exponential fits the record of {span:.4g} s. Record until the values settle.") from error
    final, change, tau = fit.estimates
    if not 0.0 < tau.value < 1.0:
        raise DataError(
            f"The fitted time constant, {span * tau.value:.4g} s, is longer than the record of {span:.4g} s. "
            "Record until the values settle."
        )
    return Rise(
        tau.scaled(span),
        final.scaled(scale, last),
        change.scaled(scale),
        scale * fit.rms,
        _lag_correlation(fit.residuals),
    )


def _guess_time(at: Any, values: Any) -> float:
    """Return τ of the linear regression y = c + (y_∞/τ) t - (1/τ) ∫y dt (Jacquelin 2009).

    Noise biases it towards short times, but not out of the basin of the minimum.
    """
    from scipy.integrate import cumulative_trapezoid

    columns = np.stack([np.ones_like(at), at, cumulative_trapezoid(values, at, initial=0.0)], 1)
    rate = -float(np.linalg.lstsq(columns, values, rcond=None)[0][2])
    return min(max(1.0 / rate, at[1]), 1.0) if rate > 0.0 else 1.0


def _lag_correlation(residuals: Sequence[float]) -> float:
    """Return the correlation of each value with the next."""
    mean = sum(residuals) / len(residuals)
    numbers = [r - mean for r in residuals]
    total = sum(r * r for r in numbers)
    return sum(a * b for a, b in pairwise(numbers)) / total if total else 0.0


def _check_record(times: Sequence[float], values: Sequence[float]) -> None:
    check_columns("a time constant", "rows", LEAST_ROWS, times=times, values=values)
    if any(after <= before for before, after in pairwise(times)):
        raise DataError("Times of a rise must increase from row to row.")
    if max(values) == min(values):
        raise DataError(f"All {len(values)} values are {values[0]:.6g}: nothing rises or falls.")
