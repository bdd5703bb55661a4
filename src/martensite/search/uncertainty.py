"""Uncertainty of fitted parameters: intervals, correlations, effective number of samples.

With residuals r, their Jacobian J and n samples, near the optimum

    s² = Σ r_i²/(n - p),    covariance of z = s² (JᵀJ)⁻¹,    z ± t(level, n - p) error

for parameters z scaled to their search ranges. A value x(z) has the error abs(dx/dz) error(z) (Laplace's
approximation; Seber and Wild (1989), Nonlinear Regression, ch. 5). The inverse and the count p omit directions that J
does not determine. Every parameter in such a direction has an infinite error.

Samples of a log are rarely independent. With autocorrelation, n samples are equivalent to n_eff independent samples,
and errors are too small by √(n/n_eff). Intervals of `widen_interval` have this factor and t(level, n_eff - p);
`interval` has neither.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.confidence import EVERYTHING, LEVEL, Interval, student_quantile
from martensite.base.errors import DataError, require_known
from martensite.search.identifiability import PRECISION
from martensite.search.quantity_text import format_number, list_names
from martensite.search.scaled_jacobian import balance_columns, reduce_rows, scale_parameters
from martensite.search.whiteness import count_effective_samples

Matrix: TypeAlias = NDArray[np.float64]
CONFOUNDED = 0.95
"""Correlation above which two parameters are reported as confounded."""
CHANCE = 1.1
"""Ratio of HC3 errors to ordinary errors that chance alone can produce for 100 or more samples."""
_TURNED = 1e-3
_MANY = 10_000
"""Largest degrees of freedom for Student's t; beyond it t is at most 1e-4 too large."""


@dataclass(frozen=True)
class Uncertainty:
    """Errors of fitted parameters, all in SI units."""

    names: tuple[str, ...]
    values: tuple[float, ...]
    errors: tuple[float, ...]
    """Standard errors for independent samples; infinite for an undetermined parameter, NaN without degrees of freedom.
    """
    correlation: tuple[tuple[float, ...], ...]
    """Correlation of the parameters; NaN for an undetermined parameter."""
    noise: float
    """Standard deviation s of a weighted residual; NaN without degrees of freedom."""
    samples: int
    rank: int
    """Number of determined directions."""
    effective: float
    """Equivalent number n_eff of independent samples."""

    @property
    def freedom(self) -> int:
        """Return the degrees of freedom, n - p."""
        return self.samples - self.rank

    @property
    def widening(self) -> float:
        """Compute √(n/n_eff), the factor on errors for autocorrelated residuals."""
        return math.sqrt(self.samples / self.effective)

    @property
    def covariance(self) -> tuple[tuple[float, ...], ...]:
        """Return the covariance for independent samples; infinite or NaN for undetermined parameters."""
        rows = zip(self.errors, self.correlation, strict=True)
        return tuple(tuple(c * one * other for c, other in zip(row, self.errors, strict=True)) for one, row in rows)

    def interval(self, name: str, level: float = LEVEL) -> Interval:
        """Return the confidence interval of a parameter for independent samples."""
        return self._about(name, level, self.freedom, 1.0)

    def widen_interval(self, name: str, level: float = LEVEL) -> Interval:
        """Return the confidence interval of a parameter for n_eff samples."""
        return self._about(name, level, self._spare, self.widening)

    def half_width(self, gradient: Any, level: float = LEVEL) -> float:
        """Return half the widened interval of a quantity, from its derivatives (n,) with respect to values in SI."""
        moving = np.flatnonzero(gradient)
        some = np.array(self.covariance)[np.ix_(moving, moving)]
        if self.freedom < 1 or not np.isfinite(some).all():
            return math.inf
        part = np.asarray(gradient)[moving]
        variance = max(float(part @ some @ part), 0.0)
        return student_quantile(level, min(self._spare, _MANY)) * math.sqrt(variance) * self.widening

    @property
    def _spare(self) -> int:
        """Return the degrees of freedom of the independent samples."""
        return min(max(int(self.effective) - self.rank, 1) if self.freedom > 0 else 0, self.freedom)

    def list_confounded(self, limit: float = CONFOUNDED) -> list[tuple[str, str, float]]:
        """Return the pairs of parameters with a stronger correlation, the strongest first."""
        count = len(self.names)
        pairs = [
            (self.names[i], self.names[j], self.correlation[i][j])
            for i in range(count)
            for j in range(i + 1, count)
            if abs(self.correlation[i][j]) > limit
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return remarks on the errors: undetermined, confounded, too few independent samples."""
        sentences: list[str] = []
        if lost := [n for n, e in zip(self.names, self.errors, strict=True) if e == math.inf]:
            sentences.append(f"The data do not determine {list_names(lost)}.")
        for one, other, value in self.list_confounded():
            together = "increase together" if value > 0.0 else "compensate each other"
            sentences.append(
                f"`{one}` and `{other}` {together} (correlation {value:.3f}), so the data hardly separate them."
            )
        if self.widening > 1.1:
            sentences.append(
                f"The residuals are autocorrelated: {self.samples} samples count as "
                f"{format_number(self.effective, 2)} independent samples. The intervals were widened by a factor of "
                f"{format_number(self.widening, 2)}."
            )
        return tuple(sentences)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name and the remarks, for JSON."""
        columns = zip(self.names, self.values, self.errors, strict=True)
        return {
            "parameters": {
                name: {
                    "value": value,
                    "standard_error": error,
                    "interval": list(self.interval(name, level)),
                    "widened_interval": list(self.widen_interval(name, level)),
                }
                for name, value, error in columns
            },
            "correlation": [list(row) for row in self.correlation],
            "noise": self.noise,
            "samples": self.samples,
            "effective_samples": self.effective,
            "widening": self.widening,
            "sentences": list(self.sentences),
        }

    def _about(self, name: str, level: float, freedom: int, factor: float) -> Interval:
        require_known("free parameter", name, self.names)
        place = self.names.index(name)
        value, error = self.values[place], self.errors[place]
        if freedom < 1 or not math.isfinite(error):
            return EVERYTHING
        half = student_quantile(level, min(freedom, _MANY)) * error * factor
        return value - half, value + half


def estimate_uncertainty(
    residuals: Any,
    jacobian: Any,
    names: Sequence[str],
    *,
    values: Sequence[float],
    scales: Sequence[float],
    lengths: Sequence[int] | None = None,
    precision: float = PRECISION,
    uneven: bool = False,
) -> Uncertainty:
    """Return the errors of fitted parameters from the residuals and their derivatives.

    Args:
        residuals: (samples,), weighted, at the optimum.
        jacobian: (samples, parameters), change of each residual per search range.
        names: names of the parameters.
        values: values of the parameters, in SI.
        scales: change of each value per search range, in SI (see `Axes`).
        lengths: samples of each record in `residuals`, by default one record.
        precision: relative precision of the Jacobian.
        uneven: True for residuals with uneven scatter from nonlinearity. Errors are then at least the HC3 errors less
            10 %.

    Raises:
        DataError: residuals or Jacobian are not finite, or differ in length.
        ParameterError: values, scales and names differ in length.
    """
    free = scale_parameters(names, values, scales)
    matrix, errors = free.jacobian(jacobian), np.asarray(residuals, np.float64)
    if errors.shape != (len(matrix),):
        raise DataError(f"{errors.shape} residuals have a Jacobian of {len(matrix)} rows.")
    effective = count_effective_samples(errors, lengths)
    spread, rank = _compute_unit_covariance(matrix, precision)
    spare = len(errors) - rank
    noise = math.sqrt(float(errors @ errors) / spare) if spare > 0 else math.nan
    deviations = np.sqrt(np.diag(spread))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.clip(spread / np.outer(deviations, deviations), -1.0, 1.0)
        own = np.where(np.isinf(deviations), math.inf, noise * deviations)
    if uneven and spare > 0:
        own = np.fmax(own, _estimate_uneven(matrix, errors, spread) / CHANCE)
    np.fill_diagonal(correlation, 1.0)
    turned = np.outer(np.sign(free.scales), np.sign(free.scales)) * correlation
    return Uncertainty(
        free.names,
        free.values,
        tuple(map(float, own * np.abs(free.scales))),
        tuple(tuple(map(float, row)) for row in turned),
        noise,
        len(errors),
        rank,
        effective,
    )


def _estimate_uneven(matrix: Matrix, errors: Any, spread: Matrix) -> Any:
    """Return the standard errors of HC3, from each residual enlarged by its leverage.

    MacKinnon and White (1985), Journal of Econometrics 29; NaN for undetermined parameters.
    """
    inverse = np.where(np.isfinite(spread), spread, 0.0)
    leverage = np.clip(np.einsum("ij,jk,ik->i", matrix, inverse, matrix), 0.0, 0.99)
    turned = (errors / (1.0 - leverage))[:, None] * (matrix @ inverse)
    return np.where(np.isfinite(np.diag(spread)), np.linalg.norm(turned, axis=0), math.nan)


def _compute_unit_covariance(matrix: Matrix, precision: float) -> tuple[Matrix, int]:
    """Compute (JᵀJ)⁻¹ with infinite variance of undetermined parameters, and the rank of J.

    A parameter is undetermined if its component in the omitted directions exceeds the effect of the imprecision of J.
    In
    doubt it is undetermined.
    """
    columns, norms = balance_columns(matrix)
    _, sizes, right = np.linalg.svd(reduce_rows(columns))
    rank = int(np.sum(sizes > precision * sizes[0]))
    half = right[:rank].T / sizes[:rank] / norms[:, None]
    spread = half @ half.T
    turned = min(10.0 * precision * sizes[0] / sizes[rank - 1], _TURNED) if rank else 0.0
    lost = np.linalg.norm(right[rank:], axis=0) > turned
    spread[lost, :] = math.nan
    spread[:, lost] = math.nan
    spread[lost, lost] = math.inf
    return spread, rank
