"""The bench under PID control, as in the paper.

The controller of `martensite.control.controllers.pid` runs on plain floats at 500 Hz: read the encoder, compute a duty
cycle, advance the bench.
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
"""Tuning of gains on a model with the same steps; errors in mm, duty cycles in percent."""
SINE = (4e-3, 1.5e-3, 25.0, 10.0)
"""Mean [m], amplitude [m], period [s] and first zero [s] of the sine."""
SINE_TIME, SINE_SCORED = 70.0, 20.0
"""Duration of the sine run, and start of its scored part [s]."""


def step_reference() -> Numbers:
    """Return the reference of steps [m]."""
    return build_steps(LEVELS, INTERVAL)


def sine_reference() -> Numbers:
    """Return the sine reference [m], at its mean before the sine begins."""
    mean, amplitude, period, begin = SINE
    times = INTERVAL * np.arange(round(SINE_TIME / INTERVAL))
    return mean + amplitude * np.sin(2.0 * np.pi * np.maximum(times - begin, 0.0) / period)


def run_controlled(
    gains: Gains, reference: Numbers, bench: ReferenceBench | None = None, seed: int = 3, law: PidLaw | None = None
) -> Trajectory:
    """Return a run of the bench from the steady state; the position is measured [m].

    Args:
        gains: in duty cycle per metre, per sample.
        reference: reference position [m], one per sample.
        bench: by default the reference bench.
        seed: seed of the sensor noise.
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
