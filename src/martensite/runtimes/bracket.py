"""Bracketed Newton iteration of fixed count: compiles, batches and differentiates.

For a strictly increasing function. An iterate on an end of the bracket is refused, else flat
sides make plain clipping cycle between the ends for ever. Long iterations, which have the
time, also refuse a step across the bracket that halves neither it nor the last step, else they
may cycle near the ends. A correction at round-off level is always accepted, since a comparison
near the root may round differently in its several uses. The slope is exact (dual numbers), so
the function needs no derivative of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

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

    def turn(x: Scalar, low: Scalar, high: Scalar, last: Scalar) -> tuple[Scalar, ...]:
        value, slope = (xp.store(v) for v in value_and_slope(xp, function, x))
        above, width = value > 0.0, high - low
        high, low = xp.where(above, x, high), xp.where(above, low, x)
        newton = x - value / slope
        step = xp.abs(newton - x)
        inside = xp.both(low < newton, newton < high)
        if iterations > UNROLLED:
            gains = xp.either(high - low <= 0.5 * width, step <= 0.5 * last)
            inside = xp.both(inside, xp.either(gains, step <= 0.25 * (high - low)))
        accept = xp.either(inside, step <= ROUND_OFF * xp.eps())
        after = xp.where(accept, newton, 0.5 * (low + high))
        return after, low, high, xp.abs(after - x)

    root = turns(xp, iterations, turn, start, *bracket, float("inf"))[0]
    at = xp.detach(root)
    value, slope = value_and_slope(xp, function, at)
    return xp.solved(root, at - value / xp.detach(slope))


def turns(
    xp: Namespace, count: int, body: Callable[..., Sequence[Scalar]], *state: Scalar
) -> Sequence[Scalar]:
    """The state after `count` turns: written out if few, which runs faster, else as a loop."""
    return (xp if count > UNROLLED else floats).repeat(count, body, *state)


class Unrolled:
    """A namespace that writes long iterations out: for a solve inside a loop over rows."""

    def __init__(self, xp: Namespace) -> None:
        self._xp = xp

    def __getattr__(self, operation: str) -> Any:
        return getattr(self._xp, operation)

    def repeat(
        self, count: int, body: Callable[..., Sequence[Scalar]], *state: Scalar
    ) -> Sequence[Scalar]:
        """The state after `count` turns of `body`."""
        return floats.repeat(count, body, *state)


def unrolled(xp: Namespace) -> Namespace:
    """The namespace with long iterations written out."""
    return cast("Namespace", Unrolled(xp))
