"""Trust-region least squares in the box (Branch, Coleman and Li; SciPy), with exact Jacobians.

This Levenberg–Marquardt method respects bounds. A failed run has ten times the largest residual of the start, so that
the search turns back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
SETTLED = 1e-8
"""Relative change of cost, parameters and gradient at which a descent stops."""
INSIDE = 1e-9
"""Fraction of a range by which a descent starts inside the bounds."""


class Residuals(Protocol):
    """Residuals at a point, optionally with their Jacobian."""

    @property
    def residuals(self) -> Numbers:
        """Return the scaled residuals (n,)."""
        ...

    @property
    def jacobian(self) -> Numbers:
        """Return the derivatives (n, parameters)."""
        ...


class DescentEnd(NamedTuple):
    """End of a descent."""

    shares: Numbers
    cost: float
    """Half the sum of squares, or its value under the loss."""
    converged: bool
    """False if the limit of evaluations stopped the descent."""


def descend_squares(
    evaluate: Callable[[Numbers, bool], Residuals | None],
    begin: Sequence[float] | Numbers,
    first: Residuals,
    *,
    most: int,
    loss: str = "linear",
    scale: float = 1.0,
    held: Sequence[int] = (),
    weights: Numbers | float = 1.0,
) -> DescentEnd:
    """Return the nearest minimum from a start.

    Args:
        evaluate: residuals at a point, with their Jacobian if the second argument is true, or None for a failed run.
        begin: fractions from 0 to 1.
        first: result of `evaluate` at the start.
        most: largest number of evaluations.
        loss: loss of SciPy.
        scale: residual from which the loss bends.
        held: fixed parameters.
        weights: square roots of the weights of the squared residuals.
    """
    begin = np.asarray(begin, np.float64)
    moving = np.setdiff1d(np.arange(len(begin)), held)
    penalty = np.full_like(first.residuals, 10.0 * (1.0 + np.abs(first.residuals).max()))

    def whole(x: Numbers) -> Numbers:
        point = begin.copy()
        point[moving] = x
        return point

    def residuals(x: Numbers) -> Numbers:
        outcome = evaluate(whole(x), False)
        return penalty if outcome is None else weights * outcome.residuals

    def jacobian(x: Numbers) -> Numbers:
        outcome = evaluate(whole(x), True)
        if outcome is None:
            return np.zeros((len(penalty), len(moving)))
        return (weights * outcome.jacobian.T[moving]).T

    outcome = import_module("scipy.optimize").least_squares(
        residuals,
        np.clip(begin[moving], INSIDE, 1.0 - INSIDE),
        jacobian,
        bounds=(0.0, 1.0),
        method="trf",
        ftol=SETTLED,
        xtol=SETTLED,
        gtol=SETTLED,
        max_nfev=most,
        loss=loss,
        f_scale=scale,
    )
    return DescentEnd(whole(outcome.x), float(outcome.cost), outcome.status > 0)
