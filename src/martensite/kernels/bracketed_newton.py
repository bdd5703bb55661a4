"""Bracketed Newton iteration for strictly increasing functions, which compiles, batches and differentiates.

An iterate on an end of the bracket is rejected, because flat sides would make clipping cycle between the ends. A step
across the bracket that halves neither it nor the last step is also rejected. A correction at round-off level is always
accepted, because comparisons near the root may round differently in their uses.

The iteration ends if the step is small, or if the next step would be. Newton's method squares the error, so the next
step is the cube of a step over the square of the previous step. After a halving no estimate exists; a negative step
marks the halving. Dual numbers give the exact derivative, so the function need not return it.
"""

from __future__ import annotations

from collections.abc import Callable

from martensite.kernels.dual import value_and_slope
from martensite.kernels.namespace import Flag, Namespace, Scalar

MOST_ITERATIONS = 40
"""Largest number of iterations before a failure."""
ROUND_OFF = 32.0
"""Correction, in roundings, that is always accepted."""
SMALL = 1e-13
"""Step at which the root is found."""
STEP_SAFETY = 10.0
"""Largest ratio of the next step to the expected step."""
FIRST = 1e30
"""Step before the first."""
NONE = 1e-30
"""Replacement of a step of length 0, which is the last."""


def solve_bracketed(
    xp: Namespace,
    function: Callable[[Namespace, Scalar], Scalar],
    start: Scalar,
    bracket: tuple[Scalar, Scalar],
    most: int = MOST_ITERATIONS,
    wanted: Flag = True,
    enough: float = SMALL,
    smooth: bool = True,
) -> Scalar:
    """Return the root of an increasing `function(xp, x)` inside the bracket, from `start`.

    A bracket beyond a possible end of the solutions permits an exact root there. With derivatives of at least 1,
    |function(root)| bounds the error of the root. A step of `enough` is the last; for a `smooth` function the estimate
    of the next step also counts. The estimate is invalid if the derivative changes by orders of magnitude. Where
    `wanted` is false, the result is `start`.
    """
    rounding = ROUND_OFF * xp.eps()
    last_step = xp.maximum(enough, rounding)

    def turn(_: Scalar, x: Scalar, low: Scalar, high: Scalar, last: Scalar) -> tuple[Scalar, ...]:
        value, slope = value_and_slope(xp, function, x)
        above, width = value > 0.0, high - low
        high, low = xp.where(above, x, high), xp.where(above, low, x)
        newton = x - value / slope
        step = xp.abs(newton - x)
        has_last = xp.both(last > 0.0, last < FIRST)
        gains = xp.either(high - low <= 0.5 * width, step <= 0.5 * xp.abs(last))
        gains = xp.either(gains, step <= 0.25 * (high - low))
        inside = xp.both(xp.both(low < newton, newton < high), gains)
        accept = xp.either(inside, step <= rounding)
        after = xp.where(accept, newton, 0.5 * (low + high))
        moved = xp.abs(after - x)
        ratio = moved / xp.maximum(xp.where(has_last, last, 1.0), NONE)
        next_step = xp.where(xp.both(accept, has_last), STEP_SAFETY * moved * ratio * ratio, moved)
        going = xp.both(moved > last_step, next_step > last_step) if smooth else moved > last_step
        return xp.where(going, 1.0, 0.0), after, low, high, xp.where(accept, moved, -moved)

    going = xp.where(wanted, 1.0, 0.0)
    root = xp.iterate(most, turn, going, start, *bracket, FIRST)[1]
    at = xp.detach(root)
    value, slope = value_and_slope(xp, function, at)
    return xp.implicit_root(root, at - value / xp.detach(slope))
