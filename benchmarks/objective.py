"""The gradient task of problem A: J(q) = mean[(x(theta q) - x_d)^2] / range(x_d)^2 at q = 1.

x_d = x(theta q1) comes from the same engine, so that every engine differentiates its own model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from benchmarks.problem_a import target_factors

Simulate = Callable[[list[float]], Sequence[float]]  # q -> x [mm]


def mismatch(x: Sequence[float], x_d: Sequence[float]) -> float:
    """J [1] of two displacement records."""
    squares = sum((a - b) ** 2 for a, b in zip(x, x_d, strict=True))
    return squares / len(x_d) / (max(x_d) - min(x_d)) ** 2


def objective(simulate: Simulate) -> float:
    """J at q = 1."""
    return mismatch(simulate([1.0] * 10), simulate(target_factors()))


def differences(simulate: Simulate, h: float = 1e-5) -> Callable[[], list[float]]:
    """Thunk of the gradient of J at q = 1 by central differences: 20 runs."""
    x_d = simulate(target_factors())

    def slope(i: int) -> float:
        up = [1.0 + h * (i == j) for j in range(10)]
        down = [1.0 - h * (i == j) for j in range(10)]
        return (mismatch(simulate(up), x_d) - mismatch(simulate(down), x_d)) / (2 * h)

    return lambda: [slope(i) for i in range(10)]
