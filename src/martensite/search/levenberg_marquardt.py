"""Levenberg–Marquardt on normal equations, for sums of squares over any number of samples.

    (H + λ D²) step = -g,    D = max(√diag H, 10⁻³ median √diag H)

Networks require the floor on D, because idle units with tiny gradients would take huge steps. Plateaus are common, so
the search ends only after several consecutive steps with little gain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
SCALE_FLOOR = 1e-3
"""Least scale of a parameter, relative to the median of all."""
MOST_DAMPINGS = 18
"""Largest number of dampings tried per step."""


class Normal(NamedTuple):
    """Sum of squares V with its gradient g = ½ dV/dθ and H = JᵀJ."""

    value: float
    gradient: Numbers
    hessian: Numbers


class LeastSquaresCost(Protocol):
    """Cost function."""

    def value(self, theta: Numbers) -> float:
        """Return the sum of squares; not finite for a failure."""
        ...

    def normal(self, theta: Numbers) -> Normal:
        """Return the sum of squares with its derivatives."""
        ...


@dataclass(frozen=True)
class CostMinimum:
    """End of a search."""

    theta: Numbers
    value: float
    iterations: int
    converged: bool
    """False if the limit of iterations stopped the search."""


def minimise_cost(
    cost: LeastSquaresCost,
    theta: Numbers,
    iterations: int = 100,
    tolerance: float = 1e-7,
    patience: int = 4,
    free: NDArray[np.bool_] | None = None,
    watch: Callable[[int, float, Numbers], None] | None = None,
) -> CostMinimum:
    """Return the nearest minimum from a start, within a number of iterations.

    The search ends after `patience` consecutive steps with a relative gain below the tolerance. `free` is True for
    moving parameters, by default all. `watch` is called after every step with its number, the value and θ.
    """
    theta = np.array(theta, dtype=float)
    moving = np.flatnonzero(np.ones(len(theta), bool) if free is None else free)
    normal = cost.normal(theta)
    damping, little = 1e-3, 0
    for count in range(iterations):
        step = _try_step(cost, theta, normal, damping, moving)
        if step is None or not len(moving):
            return CostMinimum(theta, normal.value, count, True)
        theta, damping = step
        before, normal = normal.value, cost.normal(theta)
        if watch is not None:
            watch(count + 1, normal.value, theta)
        little = little + 1 if before - normal.value <= tolerance * before else 0
        if little >= patience:
            return CostMinimum(theta, normal.value, count + 1, True)
    return CostMinimum(theta, normal.value, iterations, False)


def _try_step(
    cost: LeastSquaresCost, theta: Numbers, normal: Normal, damping: float, moving: NDArray[np.intp]
) -> tuple[Numbers, float] | None:
    """Return the next point and damping; None if no step is an improvement."""
    gradient, hessian = normal.gradient[moving], normal.hessian[np.ix_(moving, moving)]
    scale = np.sqrt(np.maximum(np.diag(hessian), 0.0))
    positive = scale[scale > 0.0]
    if not len(positive) or not np.all(np.isfinite(hessian)):
        return None
    scale = np.maximum(scale, SCALE_FLOOR * float(np.median(positive)))
    scaled = hessian / np.outer(scale, scale)
    for _ in range(MOST_DAMPINGS):
        try:
            change = np.linalg.solve(scaled + damping * np.eye(len(scale)), gradient / scale)
        except np.linalg.LinAlgError:
            change = np.full(len(scale), np.nan)
        trial = theta.copy()
        trial[moving] -= change / scale
        if np.all(np.isfinite(trial)):
            value = cost.value(trial)
            if np.isfinite(value) and value < normal.value:
                return trial, max(damping / 5.0, 1e-15)
        damping *= 4.0
    return None
