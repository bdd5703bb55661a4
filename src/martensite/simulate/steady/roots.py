"""A root between two bounds, by Brent's method of SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def find_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Find the root of a function with different signs at the bounds, to rounding."""
    from scipy import optimize  # pyright: ignore[reportMissingTypeStubs]

    brent: Any = optimize.brentq  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]  # its stubs ask for types of NumPy
    return float(brent(function, low, high, xtol=1e-14, rtol=1e-14))
