"""Root between two ends of opposite sign by Brent's method, in plain Python.

The steps are the same as in `brentq` of SciPy, whose import takes longer than most searches.

Source: R. P. Brent, Algorithms for Minimization Without Derivatives (1973), chapter 4.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

from martensite.base.errors import SolveError

RELATIVE = 4.0 * sys.float_info.epsilon
"""Relative tolerance of a root."""
MOST_TURNS = 100


def find_root(
    function: Callable[[float], float], low: float, high: float, tolerance: float = 1e-14, relative: float = RELATIVE
) -> float:
    """Return a root of a function between two ends, within an absolute and a relative tolerance.

    Raises:
        ValueError: the function has the same sign at both ends.
        SolveError: the tolerances are not met after `MOST_TURNS` turns.
    """
    before, here = low, high
    value_before, value = function(before), function(here)
    if value_before == 0.0:
        return before
    if value != 0.0 and (value_before < 0.0) == (value < 0.0):
        raise ValueError(f"The function has the same sign at {low} and {high}.")
    other, value_other, last, step = before, value_before, 0.0, 0.0
    for _ in range(MOST_TURNS):
        if (value_before < 0.0) != (value < 0.0):
            other, value_other = before, value_before
            last = step = here - before
        if abs(value_other) < abs(value):
            before, here, other = here, other, here
            value_before, value, value_other = value, value_other, value
        least, half = 0.5 * (tolerance + relative * abs(here)), 0.5 * (other - here)
        if value == 0.0 or abs(half) < least:
            return here
        tried = _extrapolate((before, value_before), (here, value), (other, value_other))
        limit = min(abs(last), 3.0 * abs(half) - least) if abs(last) > least else 0.0
        last, step = (step, tried) if 2.0 * abs(tried) < limit else (half, half)
        before, value_before = here, value
        here += step if abs(step) > least else math.copysign(least, half)
        value = function(here)
    raise SolveError(f"No root was found in {MOST_TURNS} turns of Brent's method, between {low:.6g} and {high:.6g}.")


def _extrapolate(before: tuple[float, float], here: tuple[float, float], other: tuple[float, float]) -> float:
    """Return the step to the root of the secant through two points, or of the inverse parabola through three.

    It is infinite after a step without a smaller value, or for equal values.
    """
    (a, fa), (b, fb), (c, fc) = before, here, other
    if not abs(fb) < abs(fa) or (a != c and fc in (fa, fb)):
        return float("inf")
    if a == c:
        return -fb * (b - a) / (fb - fa)
    da, dc = (fa - fb) / (a - b), (fc - fb) / (c - b)
    return -fb * (fc * dc - fa * da) / (dc * da * (fc - fa))
