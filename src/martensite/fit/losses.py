"""Losses by which a fit weighs its residuals: few large ones should not decide it.

The cost is C = Σ ½ c² ρ((r/c)²) with c = tuning × scale, and its least squares with weights
w = ρ'((r/c)²) have the same optimum (iteratively reweighted). With z = (r/c)²

    linear     ρ = z                                 w = 1
    soft-l1    ρ = 2 (√(1 + z) - 1)                  w = 1/√(1 + z)
    huber      ρ = z, beyond z = 1: 2 √z - 1         w = 1, beyond z = 1: 1/√z
    cauchy     ρ = log(1 + z)                        w = 1/(1 + z)

as in `scipy.optimize.least_squares`. The tunings make a mean of normal residuals of standard
deviation `scale` 95 % as efficient as by least squares (Holland and Welsch (1977),
Communications in Statistics 6, for huber and cauchy; computed for this project for soft-l1).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError, ParameterError, UnknownNameError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

NORMAL = 1.4826022185056018
"""Standard deviation of a normal distribution over its median absolute deviation."""


@dataclass(frozen=True)
class Loss:
    """One loss function."""

    name: str
    tuning: float
    """Size, in standard deviations, from which on residuals count for less."""
    rho: Callable[[Vector], Vector]
    """ρ(z)."""
    weight: Callable[[Vector], Vector]
    """ρ'(z)."""

    @property
    def scipy_name(self) -> str:
        """Its name in `scipy.optimize.least_squares`, with `f_scale` = tuning × scale."""
        return self.name.replace("-", "_")

    def cost(self, residuals: Any, scale: float = 1.0) -> float:
        """Σ ½ c² ρ((r/c)²), in the square of the residuals' unit.

        Raises:
            ParameterError: the scale is not above 0.
        """
        import numpy as np

        return 0.5 * (self.tuning * scale) ** 2 * float(np.sum(self.rho(self._z(residuals, scale))))

    def weights(self, residuals: Any, scale: float = 1.0) -> Vector:
        """Weight of each squared residual, 0 to 1.

        Raises:
            ParameterError: the scale is not above 0.
        """
        return self.weight(self._z(residuals, scale))

    def _z(self, residuals: Any, scale: float) -> Vector:
        import numpy as np

        if not 0.0 < scale < math.inf:
            raise ParameterError(f"Argument `scale` must be above 0, but is {scale:g}.")
        return (np.asarray(residuals, np.float64) / (self.tuning * scale)) ** 2


def _weigh_linear(z: Vector) -> Vector:
    return 0.0 * z + 1.0


def _rho_soft_l1(z: Vector) -> Vector:
    import numpy as np

    return 2.0 * (np.sqrt(1.0 + z) - 1.0)


def _weigh_soft_l1(z: Vector) -> Vector:
    return (1.0 + z) ** -0.5


def _rho_huber(z: Vector) -> Vector:
    import numpy as np

    return np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0)


def _weigh_huber(z: Vector) -> Vector:
    import numpy as np

    return np.maximum(z, 1.0) ** -0.5


def _rho_cauchy(z: Vector) -> Vector:
    import numpy as np

    return np.log1p(z)


def _weigh_cauchy(z: Vector) -> Vector:
    return 1.0 / (1.0 + z)


LOSSES = {
    one.name: one
    for one in (
        Loss("linear", 1.0, lambda z: z, _weigh_linear),
        Loss("soft-l1", 1.2870992, _rho_soft_l1, _weigh_soft_l1),
        Loss("huber", 1.3449975, _rho_huber, _weigh_huber),
        Loss("cauchy", 2.3849471, _rho_cauchy, _weigh_cauchy),
    )
}
"""All losses by name."""


def find_loss(name: str) -> Loss:
    """The loss of a name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in LOSSES:
        raise UnknownNameError("loss", name, LOSSES)
    return LOSSES[name]


def estimate_scale(residuals: Any) -> float:
    """Standard deviation by the median absolute deviation, 1.4826 median(abs(r - median(r))).

    Up to half of the residuals may be outliers. 0 if more than half are equal.

    Raises:
        DataError: there is no residual, or one is not finite.
    """
    import numpy as np

    errors = np.asarray(residuals, np.float64)
    if not errors.size or not np.isfinite(errors).all():
        raise DataError("Residuals must be finite and at least one, but are not.")
    return NORMAL * float(np.median(np.abs(errors - np.median(errors))))
