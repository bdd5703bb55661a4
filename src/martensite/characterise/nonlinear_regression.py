"""Small nonlinear least squares: Gauss–Newton with central differences and step halving.

Each step solves J δ = -r for the residuals r and is halved until the sum of squares falls. For
a handful of parameters of known size; the start must lie in the valley of the wanted minimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from martensite.errors import SolveError

Residuals = Callable[[tuple[float, ...]], Sequence[float]]
_STEP = 1e-6
_SETTLED = 1e-10
_MOST = 100


@dataclass(frozen=True)
class Solution:
    """Parameters of least squares, and the residuals that are left."""

    values: tuple[float, ...]
    residuals: tuple[float, ...]

    @property
    def rms(self) -> float:
        """Root mean square of the residuals."""
        return root_mean_square(self.residuals)


def root_mean_square(numbers: Sequence[float]) -> float:
    """Root of the mean of the squares."""
    return math.sqrt(sum(number * number for number in numbers) / len(numbers))


def least_squares(residuals: Residuals, start: Sequence[float]) -> Solution:
    """Minimise the sum of squared residuals.

    Args:
        residuals: residuals for a tuple of parameters; at least as many as parameters.
        start: parameters to begin with, none of them zero: they set the size of the steps.

    Raises:
        SolveError: the steps have not settled.
    """
    import numpy as np

    values = tuple(map(float, start))
    left = np.asarray(residuals(values), np.float64)
    for _ in range(_MOST):
        step, *_ = np.linalg.lstsq(jacobian(residuals, values), -left, rcond=None)
        moved, after = values, left
        for halving in range(40):
            moved = tuple(v + 0.5**halving * float(d) for v, d in zip(values, step, strict=True))
            after = np.asarray(residuals(moved), np.float64)
            if after @ after <= left @ left:
                break
        else:
            moved, after = values, left
        change = max(abs(m - v) / abs(s) for m, v, s in zip(moved, values, start, strict=True))
        values, left = moved, after
        if change <= _SETTLED:
            return Solution(values, tuple(map(float, left)))
    raise SolveError(f"A least-squares fit has not settled after {_MOST} steps; start it nearer.")


def jacobian(residuals: Residuals, values: tuple[float, ...]) -> Any:
    """Derivatives of all residuals (rows) with respect to the parameters (columns)."""
    import numpy as np

    return np.stack([_slope(residuals, values, k) for k in range(len(values))], axis=1)


def _slope(residuals: Residuals, values: tuple[float, ...], k: int) -> list[float]:
    """Derivative of all residuals with respect to the k-th parameter."""
    size = _STEP * max(abs(values[k]), 1e-12)
    above, below = (
        residuals((*values[:k], values[k] + sign * size, *values[k + 1 :])) for sign in (1.0, -1.0)
    )
    return [(a - b) / (2.0 * size) for a, b in zip(above, below, strict=True)]
