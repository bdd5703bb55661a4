"""Student's t for whole degrees of freedom: probabilities and quantiles in closed form.

With θ = arctan(t/√ν) the probability of |T| ≤ t is a finite sum,

    ν odd     A = (2/π) {θ + sin θ [cos θ + (2/3) cos³θ + … ]}
    ν even    A = sin θ {1 + (1/2) cos²θ + (1·3)/(2·4) cos⁴θ + … },

each with ν/2 terms (Abramowitz and Stegun 1964, 26.7.3 and 26.7.4). The square of T has
Fisher's F distribution with 1 and ν degrees of freedom, so that `two_sided` is also the
F-test for one additional term.
"""

from __future__ import annotations

import math
from functools import cache

from martensite.errors import ParameterError


def central(t: float, freedom: int) -> float:
    """Probability that Student's t lies within ±t.

    Raises:
        ParameterError: there is no degree of freedom.
    """
    _check(freedom)
    theta = math.atan(abs(t) / math.sqrt(freedom))
    sine, square = math.sin(theta), math.cos(theta) ** 2
    odd = freedom % 2
    term = math.cos(theta) if odd else 1.0
    total = 0.0
    for k in range(odd, freedom - 1, 2):
        total += term
        term *= square * (k + 1) / (k + 2)
    return (theta + sine * total) * 2.0 / math.pi if odd else sine * total


def two_sided(t: float, freedom: int) -> float:
    """Probability of a value at least as far from zero as t; exact to about 1e-15."""
    return max(1.0 - central(t, freedom), 0.0)


@cache
def quantile(level: float, freedom: int) -> float:
    """The t within which the share `level` of Student's distribution lies.

    Raises:
        ParameterError: the level is not between 0 and 1, or there is no degree of freedom.
    """
    _check(freedom)
    if not 0.0 < level < 1.0:
        raise ParameterError(f"Argument `level` must be between 0 and 1, but is {level:g}.")
    low, high = 0.0, 1.0
    while central(high, freedom) < level:
        low, high = high, 2.0 * high
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if central(middle, freedom) < level else (low, middle)
    return high


def _check(freedom: int) -> None:
    if freedom < 1:
        raise ParameterError(
            f"Argument `freedom` must be at least 1 (more points than coefficients), "
            f"but is {freedom}."
        )
