"""Losses for the residuals of a fit, which limit the effect of outliers.

SciPy minimises C = Σ ½ c² ρ((r/c)²) with c = tuning × scale. Least squares with weights w = ρ'((r/c)²) have the same
optimum (iteratively reweighted). With z = (r/c)²

    linear     ρ = z                                 w = 1
    soft-l1    ρ = 2 (√(1 + z) - 1)                  w = 1/√(1 + z)
    huber      ρ = z, beyond z = 1: 2 √z - 1         w = 1, beyond z = 1: 1/√z
    cauchy     ρ = log(1 + z)                        w = 1/(1 + z)

as in `scipy.optimize.least_squares`. The tunings give a mean of normal residuals 95 % of the efficiency of least
squares (Holland and Welsch (1977), Communications in Statistics 6, for huber and cauchy; computed for this project for
soft-l1).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, ParameterError, require_known

Vector: TypeAlias = NDArray[np.float64]
NORMAL = 1.4826022185056018
"""Standard deviation of a normal distribution divided by its median absolute deviation."""


@dataclass(frozen=True)
class Loss:
    """Loss function."""

    name: str
    tuning: float
    """Size, in standard deviations, from which residuals have less weight."""
    weight: Callable[[Vector], Vector]
    """ρ'(z)."""

    @property
    def scipy_name(self) -> str:
        """Return the name in `scipy.optimize.least_squares`, with `f_scale` = tuning × scale."""
        return self.name.replace("-", "_")

    def weights(self, residuals: Any, scale: float = 1.0) -> Vector:
        """Return the weight of each squared residual, 0 to 1.

        Raises:
            ParameterError: the scale is not above 0.
        """
        if not 0.0 < scale < math.inf:
            raise ParameterError(f"Argument `scale` must be above 0, but is {scale:g}.")
        return self.weight((np.asarray(residuals, np.float64) / (self.tuning * scale)) ** 2)


LOSSES = {
    one.name: one
    for one in (
        Loss("linear", 1.0, np.ones_like),
        Loss("soft-l1", 1.2870992, lambda z: (1.0 + z) ** -0.5),
        Loss("huber", 1.3449975, lambda z: np.maximum(z, 1.0) ** -0.5),
        Loss("cauchy", 2.3849471, lambda z: 1.0 / (1.0 + z)),
    )
}
"""All losses by name."""


def find_loss(name: str) -> Loss:
    """Return the loss with a given name.

    Raises:
        UnknownNameError: there is no such loss.
    """
    require_known("loss", name, LOSSES)
    return LOSSES[name]


def estimate_scale(residuals: Any) -> float:
    """Return the standard deviation by the median absolute deviation, 1.4826 median(abs(r - median(r))).

    Up to half of the residuals may be outliers. 0 if more than half are equal.

    Raises:
        DataError: residuals are missing or not finite.
    """
    errors = np.asarray(residuals, np.float64)
    if not errors.size or not np.isfinite(errors).all():
        raise DataError("Residuals must be finite and at least one, but are not.")
    return NORMAL * float(np.median(np.abs(errors - np.median(errors))))
