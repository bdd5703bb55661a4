"""Common functions of studies: the runtime of their runs, and values read from a sampled curve."""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.kernels.compiler import find_compiler
from martensite.signals.sampling.sampled import Numbers


def choose_runtime() -> str:
    """C where there is a compiler, else plain floats: the same to 1e-12, only slower."""
    return "floats" if find_compiler() is None else "c"


def passing_time(times: Sequence[float] | Numbers, values: Sequence[float] | Numbers, level: float) -> float:
    """When values first pass a level upwards, between two samples; NaN if never.

    To read off where they pass it downwards, negate values and level. Any other column may
    stand for the times.
    """
    for k in range(1, len(values)):
        if values[k - 1] < level <= values[k]:
            return level_time(times, values, k - 1, level)
    return math.nan


def level_time(times: Sequence[float] | Numbers, values: Sequence[float] | Numbers, k: int, level: float) -> float:
    """When values are at a level, on the straight line from sample k to the next."""
    share = (level - values[k]) / (values[k + 1] - values[k])
    return times[k] + share * (times[k + 1] - times[k])
