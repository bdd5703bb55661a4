"""Linear least squares of polynomials, and nonlinear least squares, with standard errors.

    y_i = Σ_k c_k x_i^k + e_i,    e_i independent, normal, of one unknown variance s²

    s² = Σ r_i²/(n - p),    covariance of c = s² (XᵀX)⁻¹

for n points and p terms. Intervals are c_k ± t(level, n - p) times the standard error. If n = p, standard errors are
NaN
and intervals unbounded.

For exact ordinates and noisy abscissae, such as temperatures of a wire under a known power, `fit_noisy_abscissae`
minimises the squares of the abscissae. The same formulas hold with s in the unit of x.

Nonlinear least squares of a few parameters use the trust-region method of SciPy (`scipy.optimize.least_squares`) with
central differences. With residuals r at the minimum, their Jacobian J, n rows and p parameters

    s² = Σ r²/(n - p),    covariance = s² (JᵀJ)⁻¹

for independent residuals of equal variance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from martensite.base.confidence import EVERYTHING, LEVEL, Interval, student_quantile, two_sided_probability
from martensite.base.errors import DataError, ParameterError, SolveError
from martensite.characterise.estimate import MeasuredValue, check_columns


@dataclass(frozen=True)
class LinearFit:
    """Coefficients of the requested powers, and their covariance."""

    terms: tuple[int, ...]
    """Powers of x."""
    values: tuple[float, ...]
    """Coefficient of each term."""
    covariance: tuple[tuple[float, ...], ...]
    """Covariance of the coefficients; NaN without degrees of freedom."""
    squares: float
    """Sum of the squared residuals."""
    points: int

    @property
    def freedom(self) -> int:
        """Return the degrees of freedom, n - p."""
        return self.points - len(self.terms)

    @property
    def deviation(self) -> float:
        """Return the standard deviation s of the residuals; NaN without degrees of freedom."""
        return math.sqrt(self.squares / self.freedom) if self.freedom else math.nan

    def error(self, term: int) -> float:
        """Return the standard error of the coefficient of a power; NaN without degrees of freedom."""
        place = self._place(term)
        return math.sqrt(self.covariance[place][place])

    def interval(self, term: int, level: float = LEVEL) -> Interval:
        """Return the confidence interval of the coefficient of a power."""
        return self.coefficient(term).interval(level) if self.freedom else EVERYTHING

    def p_value(self, term: int) -> float:
        """Return the p-value of a term by the F-test; NaN without degrees of freedom."""
        error = self.error(term)
        if not self.freedom:
            return math.nan
        value = self.values[self._place(term)]
        if not error > 0.0:
            return float(value == 0.0)
        return two_sided_probability(value / error, self.freedom)

    def coefficient(self, term: int) -> MeasuredValue:
        """Return the coefficient of a power, with its standard error."""
        return MeasuredValue(self.values[self._place(term)], self.error(term), self.freedom)

    def value(self, x: float) -> float:
        """Return the fitted polynomial at x."""
        return sum(c * x**k for k, c in zip(self.terms, self.values, strict=True))

    def half_width(self, x: float, level: float = LEVEL) -> float:
        """Return half the confidence band of the polynomial at x; infinite without degrees of freedom."""
        if not self.freedom:
            return math.inf
        powers = [x**k for k in self.terms]
        variance = sum(a * b * self.covariance[i][j] for i, a in enumerate(powers) for j, b in enumerate(powers))
        return student_quantile(level, self.freedom) * math.sqrt(max(variance, 0.0))

    def _place(self, term: int) -> int:
        if term not in self.terms:
            raise ParameterError(f"Power {term} was not fitted, only {self.terms}.")
        return self.terms.index(term)


def fit_powers(x: Sequence[float], y: Sequence[float], terms: Sequence[int]) -> LinearFit:
    """Fit Σ c_k x^k over the given powers k to points (x, y).

    Raises:
        ParameterError: the terms are not distinct whole numbers from 0 on.
        DataError: the points are not finite, or do not determine the terms.
    """
    check_columns("a polynomial", "points", 2, abscissae=x, ordinates=y)
    _check_terms(terms)
    scale = max(abs(number) for number in x) or 1.0
    columns = np.stack([(np.asarray(x, np.float64) / scale) ** k for k in terms], axis=1)
    left, sizes, right = np.linalg.svd(columns, full_matrices=False)
    if len(x) < len(terms) or sizes[-1] <= len(x) * np.finfo(float).eps * sizes[0]:
        raise DataError(
            f"Points at {len(set(x))} different abscissae do not determine {len(terms)} "
            "coefficients; measure at more, or fit fewer terms."
        )
    values = right.T @ ((left.T @ np.asarray(y, np.float64)) / sizes)
    squares = float(np.sum((np.asarray(y) - columns @ values) ** 2))
    units = np.asarray([scale**k for k in terms])
    spread = (right.T / sizes**2) @ right / np.outer(units, units)
    freedom = len(x) - len(terms)
    spread *= squares / freedom if freedom else math.nan
    return LinearFit(tuple(terms), _as_floats(values / units), tuple(map(_as_floats, spread)), squares, len(x))


def fit_noisy_abscissae(
    x: Sequence[float], y: Sequence[float], terms: Sequence[int], origin: float | None = None
) -> LinearFit:
    """Fit y = (x - origin) Σ c_k x^k to points with exact y and equal noise in x.

    The fit minimises Σ (x_i - ξ_i)², where the fitted curve has the ordinate y_i at ξ_i. Each iteration linearises the
    curve about the last ξ: a linear fit with the weights (dx/dy)². Without convergence, such as for a curve that falls
    at a point, the first iteration is the result.

    Args:
        x: abscissae with noise.
        y: exact ordinates.
        terms: fitted powers of x.
        origin: zero of the curve, or None for the polynomial alone.

    Returns:
        Coefficients with their covariance; `squares` has the unit of x².

    Raises:
        ParameterError: the terms are not distinct whole numbers from 0 on.
        DataError: the points are not finite, or do not determine the terms.
    """
    fit_powers(x, y, terms)  # checks points and terms
    given, ordinates, scale = np.asarray(x, np.float64), np.asarray(y, np.float64), max(map(abs, x)) or 1.0
    weigh = partial(_weigh_slopes, given / scale, ordinates, terms, None if origin is None else origin / scale)
    first = last = weigh(given / scale, None)
    for _ in range(TURNS):
        before, last = last, weigh(last.fitted, last.values)
        if np.abs(last.fitted - before.fitted).max() <= SETTLED * np.ptp(given) / scale:
            break
    else:
        last = first
    units = np.asarray([scale ** (k + (origin is not None)) for k in terms])
    squares = float(np.sum((given / scale - last.fitted) ** 2))
    freedom = len(x) - len(terms)
    spread = last.spread / np.outer(units, units) * (squares / freedom if freedom else math.nan)
    return LinearFit(
        tuple(terms), _as_floats(last.values / units), tuple(map(_as_floats, spread)), scale**2 * squares, len(x)
    )


class _Turn(NamedTuple):
    fitted: Any
    values: Any
    spread: Any
    """(XᵀX)⁻¹, with rows of unit noise in x."""


def _weigh_slopes(x: Any, y: Any, terms: Sequence[int], origin: float | None, fitted: Any, values: Any) -> _Turn:
    """Iterate `fit_noisy_abscissae` once about the last abscissae; without values, fit without weights."""
    powers = np.stack([fitted**k for k in terms], axis=1)
    slopes = np.stack([k * fitted ** max(k - 1, 0) for k in terms], axis=1)
    arm = 1.0 if origin is None else (fitted - origin)[:, None]
    columns, rises = powers * arm, slopes * arm + (0.0 if origin is None else powers)
    if values is None:
        values = np.linalg.lstsq(columns, y, rcond=None)[0]
    rise = rises @ values
    rise = np.maximum(rise, FLATTEST * np.abs(rise).max())
    weighted = columns / rise[:, None]
    coefficients = np.linalg.lstsq(weighted, (y - rise * (x - fitted)) / rise, rcond=None)[0]
    spread = np.linalg.pinv(weighted.T @ weighted)
    return _Turn(fitted + (y - columns @ coefficients) / rise, coefficients, spread)


def _as_floats(numbers: Any) -> tuple[float, ...]:
    return tuple(map(float, numbers))


def _check_terms(terms: Sequence[int]) -> None:
    if not terms or len(set(terms)) != len(terms) or min(terms) < 0:
        raise ParameterError(f"Argument `terms` must be distinct powers from 0 on, but is {tuple(terms)}.")


TURNS, SETTLED = 20, 1e-10
"""Largest number of iterations, and the change, as a fraction of the range of x, at which they end."""
FLATTEST = 0.05
"""Least slope of the curve at a weighted point, as a fraction of the greatest slope."""
TOLERANCE = 1e-14
"""Relative change of squares, parameters and gradient at which the search ends."""
MOST_EVALUATIONS = 200
"""Largest number of evaluations."""


@dataclass(frozen=True)
class NonlinearFit:
    """Parameters of nonlinear least squares, with the residuals."""

    estimates: tuple[MeasuredValue, ...]
    residuals: tuple[float, ...]

    @property
    def values(self) -> tuple[float, ...]:
        """Return the parameters without their errors."""
        return tuple(one.value for one in self.estimates)

    @property
    def rms(self) -> float:
        """Return the root mean square of the residuals."""
        return root_mean_square(self.residuals)


def root_mean_square(numbers: Sequence[float]) -> float:
    """Return the root mean square."""
    return math.sqrt(sum(number * number for number in numbers) / len(numbers))


def fit_residuals(residuals: Callable[[tuple[float, ...]], Any], start: Sequence[float]) -> NonlinearFit:
    """Minimise the sum of squared residuals, at least one per parameter.

    The start must be in the basin of the wanted minimum, with parameters of order 1.

    Raises:
        SolveError: the search has not converged, or a parameter has no effect.
    """
    from scipy.optimize import least_squares

    solution = least_squares(
        lambda numbers: residuals(tuple(map(float, numbers))),
        start,
        jac="3-point",
        x_scale="jac",
        max_nfev=MOST_EVALUATIONS,
        **dict.fromkeys(("ftol", "xtol", "gtol"), TOLERANCE),
    )
    if not solution.success:
        raise SolveError(f"A least-squares fit has not converged after {MOST_EVALUATIONS} steps.")
    freedom = len(solution.fun) - len(start)
    variance = 2.0 * solution.cost / freedom if freedom else math.nan
    upper = np.linalg.qr(solution.jac, mode="r")
    if not np.abs(np.diag(upper)).min() > 0.0:
        raise SolveError("A least-squares fit has not converged: one parameter has no effect.")
    errors = np.sqrt(variance * np.sum(np.linalg.inv(upper) ** 2, axis=1))
    pairs = zip(solution.x, errors, strict=True)
    estimates = tuple(MeasuredValue(float(value), float(error), freedom) for value, error in pairs)
    return NonlinearFit(estimates, tuple(map(float, solution.fun)))
