"""Brent's method in Python takes the steps of SciPy's.

Source of truth: `scipy.optimize.brentq`, in all bits and with the same calls.
"""

import math

import pytest
from scipy.optimize import brentq

from martensite.base.errors import SolveError
from martensite.kernels.brent import find_root

FUNCTIONS = {
    "cubic": (lambda x: x**3 - 2.0 * x - 5.0, 1.0, 4.0),
    "steep": (lambda x: math.tanh(50.0 * (x - 0.3)), 0.0, 1.0),
    "jump": (lambda x: -1.0 if x < 0.7 else 1.0, 0.0, 1.0),
    "stairs": (lambda x: math.floor(20.0 * x) - 7.0, 0.0, 1.0),
    "exponential": (lambda x: math.exp(-x) - 1e-3, 0.0, 50.0),
    "at the end": (lambda x: x, 0.0, 1.0),
    "falling": (lambda x: 2.0 - x, 1.0, 2.0),
}


@pytest.mark.parametrize("tolerance", [1e-2, 4e-4, 1e-14])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_roots_and_calls_are_those_of_scipy(name: str, tolerance: float) -> None:
    function, low, high = FUNCTIONS[name]
    calls: tuple[list[float], list[float]] = ([], [])

    def count(own: list[float], x: float) -> float:
        own.append(x)
        return function(x)

    found = find_root(lambda x: count(calls[0], x), low, high, tolerance)
    assert found == brentq(lambda x: count(calls[1], x), low, high, xtol=tolerance)
    assert calls[0] == calls[1]


def test_a_root_that_is_not_found_is_refused() -> None:
    with pytest.raises(SolveError, match="No root was found in 100 turns"):
        find_root(lambda x: (x - 1.3) ** 9, 0.0, 4.0)


def test_ends_of_one_sign_are_refused() -> None:
    with pytest.raises(ValueError, match="the same sign"):
        find_root(lambda x: x, 1.0, 2.0)
