"""Measures of a loop: errors, overshoot, settling, energy, temperature.

    IAE = ∫ |e| dt      ISE = ∫ e² dt      ITAE = ∫ t |e| dt, t from the last step of the reference
    rms = √(ISE/T)      energy = ∫ P dt

Overshoot is the largest excess over a new level, over the span of the reference. Settling is the longest time after
which the output stays within 5 % of a step around its level, infinite if it does not before the reference moves again.
Both count steps after which the reference is constant.

For a reference of steps, each lasting until the next:

    rise        time from the step until the output has made 90 % of it
    settling    time from the step after which the output stays within 5 % of it around the new level
    overshoot   excess over the new level, over the step
    error       mean of reference less output over the last tenth of the level
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import InputError
from martensite.control.tuning.goals import Course, Numbers
from martensite.control.tuning.loop_runs import LoopOutputs

RISE, BAND, LAST = 0.90, 0.05, 0.1


class StepResponse(NamedTuple):
    """Response to one step."""

    before: float
    after: float
    rise: float
    """Rise time [s]."""
    settling: float
    """Settling time [s]."""
    overshoot: float
    """Overshoot over the step."""
    error: float


def build_steps(levels: Sequence[tuple[float, float]], interval: float) -> Numbers:
    """Return a reference that is constant at each level for some time.

    Args:
        levels: pairs of level and time [s].
        interval: sample time [s].

    Raises:
        InputError: a level lasts less than a sample.
    """
    counts = [round(time / interval) for _, time in levels]
    if not counts or min(counts) < 1:
        raise InputError(f"Every level must last a sample of {interval:g} s at least.")
    return np.repeat([level for level, _ in levels], counts).astype(float)


def measure_steps(reference: Numbers, output: Numbers, interval: float) -> list[StepResponse]:
    """Measure the responses to all steps of a reference, both of shape (samples,) in one unit, at an interval [s]."""
    turns = np.flatnonzero(np.diff(reference)) + 1
    ends = [*turns[1:], len(reference)]
    return [
        _measure_step(float(reference[a - 1]), float(reference[a]), output[a:b], interval)
        for a, b in zip(turns, ends, strict=True)
    ]


def _measure_step(before: float, after: float, output: Numbers, interval: float) -> StepResponse:
    progress = (output - before) / (after - before)
    risen = np.flatnonzero(progress >= RISE)
    outside = np.flatnonzero(np.abs(progress - 1.0) > BAND)
    last = int(outside[-1]) + 1 if len(outside) else 0
    tail = output[len(output) - max(round(LAST * len(output)), 1) :]
    return StepResponse(
        before,
        after,
        rise=float(risen[0]) * interval if len(risen) else math.inf,
        settling=last * interval if last < len(output) else math.inf,
        overshoot=max(float(progress.max()) - 1.0, 0.0),
        error=after - float(tail.mean()),
    )


@dataclass(frozen=True)
class Measures:
    """Measures of one run, in SI units of the controlled output."""

    itae: float
    """[unit s²]"""
    iae: float
    """[unit s]"""
    rms: float
    """[unit]"""
    overshoot: float
    settling: float
    """[s]"""
    energy: float
    """[J]"""
    activity: float
    hottest: float
    """[K]"""

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
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
"""Unit of every measure; {} is the unit of the controlled output."""


def measure_loop(outputs: LoopOutputs, course: Course) -> Measures:
    """Return the measures of one run, arrays of shape (samples,)."""
    e = outputs.reference - outputs.output
    period, after = course.period, np.abs(e[1:])
    iae = float(after.sum() * period)
    return Measures(
        itae=compute_itae(outputs, course),
        iae=iae,
        rms=float(np.sqrt((e**2).mean())),
        overshoot=max(float((-e * course.way).max()), 0.0) / course.span + 0.0,
        settling=_measure_settling(e, course),
        energy=float(outputs.power[:-1].sum() * period),
        activity=float(np.abs(np.diff(outputs.signal)).mean()),
        hottest=float(outputs.hottest.max()),
    )


def compute_itae(outputs: LoopOutputs, course: Course) -> Any:
    """Return ∫ t |e| dt of runs, shape (..., samples) -> (...,); NaN for a failed run."""
    itae = np.abs(outputs.reference - outputs.output) @ course.clock * course.period
    return float(itae) if np.ndim(itae) == 0 else itae


def _measure_settling(e: Numbers, course: Course) -> float:
    """Return the longest settling time of all steps with a constant reference [s]."""
    settling, ends = 0.0, np.flatnonzero((course.way == 0.0) | course.steps).tolist()
    for first in np.flatnonzero(course.steps & (course.way != 0.0)).tolist():
        last = next((place for place in ends if place > first), len(e))
        outside = np.abs(e[first:last]) > BAND * abs(course.change[first])
        late = int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0
        settling = max(settling, late * course.period if late < last - first else np.inf)
    return settling
