"""Powers with whole exponents, as products: the same to the last bit wherever they are computed."""

from __future__ import annotations

from typing import Any


def expand_power(x: Any, exponent: int) -> Any:
    """`x` to a whole exponent by repeated squaring; 1 for 0, the inverse for one below 0."""
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
    """The whole number that an exponent is, if it is one: `2` and `2.0` are."""
    if isinstance(exponent, float):
        return int(exponent) if exponent.is_integer() else None
    return exponent.__index__() if hasattr(exponent, "__index__") else None
