"""Common functions of studies: the runtime of their runs, and values of a sampled curve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

from martensite.kernels.compiler import find_compiler
from martensite.scenario.scenario import load
from martensite.signals.sampling.sampled import Numbers

ZERO = 273.15
"""0 °C [K]."""
load_once = cache(load)


def choose_runtime() -> str:
    """Return `c` if there is a compiler, else `floats`; both agree to 1e-12."""
    return "floats" if find_compiler() is None else "c"


def passing_time(times: Sequence[float] | Numbers, values: Sequence[float] | Numbers, level: float) -> float:
    """Return the time of the first upward crossing of a level, linear between samples; NaN without one.

    For a downward crossing, negate values and level. Any other column can replace the times.
    """
    for k in range(1, len(values)):
        if values[k - 1] < level <= values[k]:
            return level_time(times, values, k - 1, level)
    return math.nan


def level_time(times: Sequence[float] | Numbers, values: Sequence[float] | Numbers, k: int, level: float) -> float:
    """Return the time at which the line from sample k to the next has a level."""
    share = (level - values[k]) / (values[k + 1] - values[k])
    return times[k] + share * (times[k + 1] - times[k])
