"""Bracketed Newton iteration of fixed count: compiles, batches and differentiates.

For a strictly increasing function. An iterate on an end of the bracket is refused, else flat
sides make plain clipping cycle between the ends for ever; a correction at round-off level is
always accepted, since a comparison near the root may round differently in its several uses.
The slope is exact (dual numbers), so the function needs no derivative of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from martensite.runtimes import floats
from martensite.runtimes.dual import value_and_slope
from martensite.runtimes.namespace import Namespace, Scalar

ITERATIONS = 4
UNROLLED = 6
"""Iterations up to which a loop is written out."""
ROUND_OFF = 32.0
"""A correction of so many roundings is always accepted."""


def solve_bracketed(
    xp: Namespace,
    function: Callable[[Namespace, Scalar], Scalar],
    start: Scalar,
    bracket: tuple[Scalar, Scalar],
    iterations: int = ITERATIONS,
) -> Scalar:
    """Root of an increasing `function(xp, x)` inside the bracket, from `start`.

    A bracket that reaches beyond a possible end of the solutions lets a root there be hit
    exactly. With slopes of at least 1, |function(root)| bounds the error of the root.
    """

    def turn(x: Scalar, low: Scalar, high: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        value, slope = (xp.store(v) for v in value_and_slope(xp, function, x))
        above = value > 0.0
        high, low = xp.where(above, x, high), xp.where(above, low, x)
        newton = x - value / slope
        inside = xp.both(low < newton, newton < high)
        accept = xp.either(inside, xp.abs(newton - x) <= ROUND_OFF * xp.eps())
        return xp.where(accept, newton, 0.5 * (low + high)), low, high

    root, _, _ = turns(xp, iterations, turn, start, *bracket)
    return root


def turns(
    xp: Namespace, count: int, body: Callable[..., Sequence[Scalar]], *state: Scalar
) -> Sequence[Scalar]:
    """`count` times state = body(*state): unrolled if short, which runs faster, else a loop."""
    return (xp if count > UNROLLED else floats).repeat(count, body, *state)
