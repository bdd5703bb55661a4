"""Plain floats: kernels as ordinary Python, without NumPy.

This is the reference meaning of every operation; it never raises on extreme arguments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

HALF_PI = math.pi / 2
ROOT_PI = math.sqrt(math.pi)
LARGEST = math.exp(700.0)
"""Largest value of an exponential, and of a power."""
WHOLE = 2.0**52
"""Least value from which all floats are whole numbers."""


def where(flag: bool, yes: float, no: float) -> float:
    """Return `yes` if the flag holds, otherwise `no`."""
    return yes if flag else no


def both(a: bool, b: bool) -> bool:
    """Return the logical and."""
    return a and b


def either(a: bool, b: bool) -> bool:
    """Return the logical or."""
    return a or b


def negate(a: bool) -> bool:
    """Return the logical not."""
    return not a


def minimum(a: float, b: float) -> float:
    """Return the smaller of two."""
    return a if a < b else b


def maximum(a: float, b: float) -> float:
    """Return the larger of two."""
    return a if a > b else b


def clip(x: float, low: float, high: float) -> float:
    """Return `x` limited to [low, high]."""
    return minimum(maximum(x, low), high)


def abs(x: float) -> float:
    """Return the absolute value."""
    return -x if x < 0.0 else x


def sqrt(x: float) -> float:
    """Return the square root; 0 for negative arguments."""
    return math.sqrt(x) if x > 0.0 else 0.0


def exp(x: float) -> float:
    """Return the exponential; the argument is limited to 700."""
    return math.exp(x if x < 700.0 else 700.0)


def log(x: float) -> float:
    """Return the natural logarithm; the argument is at least 1e-300."""
    return math.log(x if x > 1e-300 else 1e-300)


def expand_power(x: Any, exponent: int) -> Any:
    """Return `x` to a whole exponent by repeated squaring; 1 for 0, the inverse for a negative exponent.

    A power as products is identical to the last bit on all runtimes.
    """
    if exponent < 0:
        return 1.0 / expand_power(x, -exponent)
    result: Any = None
    while exponent:
        if exponent & 1:
            result = x if result is None else result * x
        exponent >>= 1
        if exponent:
            x = x * x
    return 1.0 if result is None else result


def find_whole_exponent(exponent: Any) -> int | None:
    """Return the whole number of an exponent such as `2` or `2.0`; otherwise None."""
    if isinstance(exponent, float):
        return int(exponent) if exponent.is_integer() else None
    return exponent.__index__() if hasattr(exponent, "__index__") else None


def power(base: float, exponent: float) -> float:
    """Return `base` to the `exponent`; 0 for a base of 0 or below. An `int` is multiplied out."""
    if isinstance(exponent, int):
        return expand_power(base, exponent)
    if not base > 0.0:
        return 0.0
    try:
        value = math.pow(base, exponent)
    except OverflowError:
        return LARGEST
    return value if value < LARGEST else LARGEST


sin = math.sin
cos = math.cos
tanh = math.tanh


def nearest(x: float) -> float:
    """Return the nearest whole number, the even number of two; large numbers are whole."""
    return float(round(x)) if -WHOLE < x < WHOLE else x


def quarter_sine(x: float) -> float:
    """Return sin(πx/2) for 0 ≤ x ≤ 1."""
    return math.sin(HALF_PI * x)


def erfcx(x: float) -> float:
    """Return exp(x²) erfc(x) for x ≥ 0; beyond 5 by its asymptotic continued fraction."""
    if x < 5.0:
        return math.exp(x * x) * math.erfc(x)
    tail = x
    for k in range(24, 0, -1):
        tail = x + 0.5 * k / tail
    return 1.0 / (ROOT_PI * tail)


def each(body: Callable[..., Sequence[float]], *columns: Sequence[float]) -> tuple[Sequence[float], ...]:
    """Return the columns of results of `body` over the rows of equally long columns."""
    return scan(body, (), *columns)


def scan(
    body: Callable[..., Sequence[float]], begin: Sequence[float], *columns: Sequence[float]
) -> tuple[Sequence[float], ...]:
    """Return the columns of results of `body` over a state and the rows; its first results are the next state."""
    state, result_rows = begin, list[Sequence[float]]()
    for row in zip(*columns, strict=True):
        result_rows.append(body(*state, *row))
        state = result_rows[-1][: len(begin)]
    return tuple(zip(*result_rows, strict=True))


def repeat(count: int, body: Callable[..., Sequence[float]], *state: float) -> Sequence[float]:
    """Return the state after `count` iterations of `body`."""
    current_state: Sequence[float] = state
    for _ in range(count):
        current_state = body(*current_state)
    return current_state


def iterate(most: int, body: Callable[..., Sequence[float]], *state: float) -> Sequence[float]:
    """Return the state after iterations of `body` while its first variable is above 0."""
    current_state: Sequence[float] = state
    for _ in range(most):
        if not current_state[0] > 0.0:
            break
        current_state = body(*current_state)
    return current_state


def detach(x: float) -> float:
    """Return `x`."""
    return x


def implicit_root(root: float, newton: float) -> float:
    """Return `root`."""
    return root


def eps() -> float:
    """Return the distance from 1 to the next number."""
    return 2.220446049250313e-16
