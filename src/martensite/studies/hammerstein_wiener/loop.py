"""The bench under PID control: what the paper does with its real wire.

The controller of `martensite.control.controllers.pid` on plain floats, at 500 Hz: in every sample
the
encoder is read, the controller answers with a duty, and the bench goes on under it.
"""

from __future__ import annotations

import numpy as np

from martensite.control.controllers.pid import Gains, PidLaw
from martensite.control.sensors.base import Numbers
from martensite.control.tuning.closed_loop import Trajectory
from martensite.control.tuning.measures import build_steps
from martensite.control.tuning.tuning import ModelTuning
from martensite.kernels import floats
from martensite.studies.hammerstein_wiener.bench import INTERVAL, ReferenceBench, RunningBench

LEVELS = ((0.0, 2.0), (3e-3, 13.0), (6e-3, 15.0))
"""Steps of the reference: position [m] and time [s]."""
TUNING = ModelTuning(LEVELS, beyond_data=True)
"""Tuning of gains on a model: with the same steps, errors in mm and duties in percent."""
SINE = (4e-3, 1.5e-3, 25.0, 10.0)
"""Mean [m], amplitude [m], period [s] and time of the first zero [s] of the sine."""
SINE_TIME, SINE_SCORED = 70.0, 20.0
"""Length of the run with the sine, and from where on it is judged [s]."""


def step_reference() -> Numbers:
    """Return the reference of steps [m]."""
    return build_steps(LEVELS, INTERVAL)


def sine_reference() -> Numbers:
    """Return the reference with a sine [m]: at its mean until the sine begins."""
    mean, amplitude, period, begin = SINE
    times = INTERVAL * np.arange(round(SINE_TIME / INTERVAL))
    return mean + amplitude * np.sin(2.0 * np.pi * np.maximum(times - begin, 0.0) / period)


def run_controlled(
    gains: Gains, reference: Numbers, bench: ReferenceBench | None = None, seed: int = 3, law: PidLaw | None = None
) -> Trajectory:
    """Return a run of the bench from rest; the position is the one measured [m].

    Args:
        gains: in duty per metre, per sample.
        reference: position that is wanted [m], one per sample.
        bench: what is controlled; the reference bench if left out.
        seed: of the noise of the sensors.
        law: limits, set-point weights and filter of the controller.
    """
    plant, law = RunningBench(bench or ReferenceBench(), seed), law or PidLaw()
    positions: list[float] = []
    duties: list[float] = []
    memory = None
    for wanted in reference.tolist():
        _, position = plant.measured()
        memory = memory or law.rest(floats, wanted, position)
        duty, memory = law.answer(floats, gains, memory, wanted, position, INTERVAL, sampled=True)
        positions.append(position)
        duties.append(duty)
        plant.step(duty)
    return Trajectory(reference, np.array(positions), np.array(duties), INTERVAL)
