"""How a controlled output answers steps and sines of its reference.

    rise        time from the step until the output has gone 90 % of it
    settling    time from the step after which it stays within 5 % of it around the new level
    overshoot   how far it goes beyond the new level, in shares of the step
    error       mean of reference less output over the last tenth of the level

Infinite where it never happens; a step ends where the next begins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from martensite.base.errors import InputError
from martensite.signals.sampling.sampled import Numbers

RISE, BAND, LAST = 0.90, 0.05, 0.1


class StepResponse(NamedTuple):
    """How one step is answered."""

    before: float
    """Level of the reference before the step, in the unit of the output."""
    after: float
    """Level after it."""
    rise: float
    """[s]"""
    settling: float
    """[s]"""
    overshoot: float
    """In shares of the step."""
    error: float
    """Steady error, in the unit of the output."""


def build_steps(levels: Sequence[tuple[float, float]], interval: float) -> Numbers:
    """A reference that stands at levels, each for some time.

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
    """How an output answers every step of a reference.

    Args:
        reference: levels, shape (samples,).
        output: what follows it, of the same shape and unit.
        interval: sample time [s].
    """
    turns = np.flatnonzero(np.diff(reference)) + 1
    ends = [*turns[1:], len(reference)]
    return [
        _measure_step(float(reference[a - 1]), float(reference[a]), output[a:b], interval)
        for a, b in zip(turns, ends, strict=True)
    ]


def _measure_step(before: float, after: float, output: Numbers, interval: float) -> StepResponse:
    gone = (output - before) / (after - before)
    risen = np.flatnonzero(gone >= RISE)
    outside = np.flatnonzero(np.abs(gone - 1.0) > BAND)
    last = int(outside[-1]) + 1 if len(outside) else 0
    tail = output[len(output) - max(round(LAST * len(output)), 1) :]
    return StepResponse(
        before,
        after,
        rise=float(risen[0]) * interval if len(risen) else math.inf,
        settling=last * interval if last < len(output) else math.inf,
        overshoot=max(float(gone.max()) - 1.0, 0.0),
        error=after - float(tail.mean()),
    )
