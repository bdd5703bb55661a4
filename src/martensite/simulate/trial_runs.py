"""Trial runs for the required step of a scenario.

Fits and exported models use equal steps that do not depend on the parameters, so their results are smooth and
exactly differentiable. The steps are halved until the run agrees with a run with step size control.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.simulate.api import first_step, simulate
from martensite.simulate.drive_waveforms import Waveforms
from martensite.simulate.result import Result

HALVINGS = 12
HALVED = 0.5


class EqualStep(NamedTuple):
    """Longest step and error of a run on equal steps."""

    step: float
    """[s]"""
    apart: float
    """Largest difference of judged outputs, as a fraction of their ranges."""


def find_step(
    system: AbstractSystem, waveform: Waveforms, duration: float, tolerance: float, samples: int = 1001
) -> EqualStep:
    """Return the longest step [s], by halving, that keeps a run within a relative tolerance.

    Raises:
        SolveError: the run fails.
    """
    meant = simulate(system, waveform, duration, tolerance=HALVED * tolerance, samples=samples)
    step, apart = first_step(system, duration, 2), math.inf
    for _ in range(HALVINGS):
        run = simulate(system, waveform, duration, step=step, samples=samples)
        apart = _compare_runs(system, run, meant)
        if apart <= tolerance:
            break
        step *= HALVED
    return EqualStep(step, apart)


def _compare_runs(system: AbstractSystem, run: Result, meant: Result) -> float:
    """Return the largest difference of the judged outputs, as a fraction of their ranges."""
    shares: list[float] = []
    for name, least in system.convergence_scales().items():
        count = min(len(run.times), len(meant.times))
        apart = np.abs(run[name][:count] - meant[name][:count]).max()
        shares.append(float(apart) / max(meant.range(name), least))
    return max(shares, default=0.0)
