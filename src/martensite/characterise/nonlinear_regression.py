"""Nonlinear least squares of a handful of numbers, with the standard errors of each.

The trust-region method of SciPy (`scipy.optimize.least_squares`) with central differences. With
residuals r at the minimum, their Jacobian J, n rows and p numbers

    s² = Σ r²/(n - p),    covariance = s² (JᵀJ)⁻¹,

which takes residuals as independent and of equal size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.errors import SolveError
from martensite.characterise.estimate import MeasuredValue

TOLERANCE = 1e-14
"""Relative change of the squares, the numbers and the gradient at which the search ends."""
MOST = 200
"""Evaluations after which the search is given up."""


@dataclass(frozen=True)
class NonlinearFit:
    """Numbers of least squares, and the residuals that are left."""

    estimates: tuple[MeasuredValue, ...]
    residuals: tuple[float, ...]

    @property
    def values(self) -> tuple[float, ...]:
        """The numbers without their errors."""
        return tuple(one.value for one in self.estimates)

    @property
    def rms(self) -> float:
        """Root mean square of the residuals."""
        return root_mean_square(self.residuals)


def root_mean_square(numbers: Sequence[float]) -> float:
    """Root of the mean of the squares."""
    return math.sqrt(sum(number * number for number in numbers) / len(numbers))


def fit_residuals(residuals: Callable[[tuple[float, ...]], Any], start: Sequence[float]) -> NonlinearFit:
    """Minimise the sum of squared residuals.

    Args:
        residuals: residuals for a tuple of numbers; at least as many as numbers.
        start: numbers to begin with, in the valley of the wanted minimum and of order 1.

    Raises:
        SolveError: the search has not settled, or a number makes no difference.
    """
    import numpy as np
    from scipy.optimize import least_squares

    found = least_squares(
        lambda numbers: residuals(tuple(map(float, numbers))),
        start,
        jac="3-point",
        x_scale="jac",
        max_nfev=MOST,
        **dict.fromkeys(("ftol", "xtol", "gtol"), TOLERANCE),
    )
    if not found.success:
        raise SolveError(f"A least-squares fit has not settled after {MOST} steps.")
    freedom = len(found.fun) - len(start)
    variance = 2.0 * found.cost / freedom if freedom else math.nan
    upper = np.linalg.qr(found.jac, mode="r")
    if not np.abs(np.diag(upper)).min() > 0.0:
        raise SolveError("A least-squares fit has not settled: a number makes no difference.")
    errors = np.sqrt(variance * np.sum(np.linalg.inv(upper) ** 2, axis=1))
    pairs = zip(found.x, errors, strict=True)
    estimates = tuple(MeasuredValue(float(value), float(error), freedom) for value, error in pairs)
    return NonlinearFit(estimates, tuple(map(float, found.fun)))
