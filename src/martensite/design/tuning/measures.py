"""How good a loop is, in numbers that people know: errors, overshoot, settling, energy, heat.

    IAE = ∫ |e| dt      ISE = ∫ e² dt      ITAE = ∫ t |e| dt, t from the last step of the reference
    rms = √(ISE/T)      energy = ∫ P dt

Overshoot is the largest excess over a new level, in shares of the span of the reference; settling
is the longest time after which the output stays within 5 % of a step around its level, infinite
where it never does so before the reference moves again. Both count steps after which the reference
stands.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.design.tuning.goals import Course, Numbers
from martensite.design.tuning.loop_runs import Seen
from martensite.design.tuning.response import BAND


@dataclass(frozen=True)
class Measures:
    """Numbers of one run, in SI units of what is controlled."""

    itae: float
    """[unit s²]"""
    iae: float
    """[unit s]"""
    rms: float
    """[unit]"""
    overshoot: float
    """In shares of the span of the reference."""
    settling: float
    """[s]"""
    energy: float
    """[J]"""
    activity: float
    """Mean change of the signal from sample to sample."""
    hottest: float
    """[K]"""

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


UNITS = {
    "itae": "{} s^2",
    "iae": "{} s",
    "rms": "{}",
    "overshoot": "1",
    "settling": "s",
    "energy": "J",
    "activity": "signal",
    "hottest": "K",
}
"""Unit of every measure; {} is that of what is controlled."""


def measure_loop(seen: Seen, course: Course) -> Measures:
    """Numbers of one run, arrays of shape (samples,)."""
    e = seen.reference - seen.output
    period, after = course.period, np.abs(e[1:])
    iae = float(after.sum() * period)
    return Measures(
        itae=compute_itae(seen, course),
        iae=iae,
        rms=float(np.sqrt((e**2).mean())),
        overshoot=max(float((-e * course.way).max()), 0.0) / course.span + 0.0,
        settling=_measure_settling(e, course),
        energy=float(seen.power[:-1].sum() * period),
        activity=float(np.abs(np.diff(seen.signal)).mean()),
        hottest=float(seen.hottest.max()),
    )


def compute_itae(seen: Seen, course: Course) -> Any:
    """∫ t |e| dt of runs, shape (..., samples) -> (...,); NaN where a run failed."""
    found = np.abs(seen.reference - seen.output) @ course.clock * course.period
    return float(found) if np.ndim(found) == 0 else found


def _measure_settling(e: Numbers, course: Course) -> float:
    """Longest settling of all steps after which the reference stands [s]."""
    found, ends = 0.0, np.flatnonzero((course.way == 0.0) | course.steps).tolist()
    for first in np.flatnonzero(course.steps & (course.way != 0.0)).tolist():
        last = next((place for place in ends if place > first), len(e))
        outside = np.abs(e[first:last]) > BAND * abs(course.change[first])
        late = int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0
        found = max(found, late * course.period if late < last - first else np.inf)
    return found
