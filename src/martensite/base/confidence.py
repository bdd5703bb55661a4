"""Confidence intervals of least squares from Student's t distribution.

    P(|T_ν| ≤ t) = level    gives the interval    value ± t(level, ν) error

with ν degrees of freedom. T_ν² has Fisher's F distribution with 1 and ν degrees of freedom, so that
`two_sided_probability` is also the F-test of one additional term. `scipy.special` is used because `scipy.stats` takes
four times as long to import.
"""

from __future__ import annotations

import math
from importlib import import_module
from typing import Any

from martensite.base.errors import ParameterError

LEVEL = 0.95
"""Default confidence level."""
Interval = tuple[float, float]
EVERYTHING: Interval = (-math.inf, math.inf)


def student_quantile(level: float, freedom: int) -> float:
    """Return the t that bounds the fraction `level` of Student's distribution on both sides.

    Raises:
        ParameterError: the level is not between 0 and 1, or there are no degrees of freedom.
    """
    stdtrit: Any = import_module("scipy.special").stdtrit

    _check_freedom(freedom)
    if not 0.0 < level < 1.0:
        raise ParameterError(f"Argument `level` must be between 0 and 1, but is {level:g}.")
    return float(stdtrit(freedom, 0.5 + 0.5 * level))


def two_sided_probability(t: float, freedom: int) -> float:
    """Return the probability that |T_ν| is at least |t|; `ParameterError` for 0 degrees of freedom."""
    stdtr: Any = import_module("scipy.special").stdtr

    _check_freedom(freedom)
    return float(2.0 * stdtr(freedom, -abs(t)))


def interval_contains(interval: Interval, value: float = 0.0) -> bool:
    """Return whether a value lies in an interval."""
    return interval[0] <= value <= interval[1]


def _check_freedom(freedom: int) -> None:
    if freedom < 1:
        raise ParameterError(
            f"Argument `freedom` must be at least 1 (more points than coefficients), but is {freedom}."
        )
