"""Whole trajectories of problem A agree on all runtimes: steps that agree one by one may not."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import SINE_A, FunctionWaveform, example_system, examples, label, problem_a

from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.step import Step
from martensite.simulate.api import simulate

TOLERANCE = 1e-12


def random_steps() -> FunctionWaveform:
    """60 random voltages, each held 0.5 s, off about every third time."""
    rng = np.random.default_rng(5)
    volts = (rng.uniform(0, 3.6, 60) * (rng.random(60) > 0.35)).tolist()
    return FunctionWaveform(function=lambda t: volts[min(int(2.0 * t), 59)], kinks=tuple(k / 2 for k in range(1, 60)))


DRIVES = {
    "sine": (SINE_A, 0.02),
    "random steps": (random_steps(), 0.02),
    "pwm": (PulseWidthModulation(high=5.0, frequency=10.0, duty=0.17), 0.01),
}


def table(system, drive, runtime, duration=30.0):
    """All outputs as shares of their ranges, (samples, outputs)."""
    wave, step = DRIVES[drive]
    result = simulate(system, wave, duration, step=step, samples=301, runtime=runtime)
    return np.array(list(result.columns.values())).T


def disagreement(a, b):
    """Largest difference as a share of the range of its column, or of its size if constant."""
    span = np.maximum(np.ptp(a, axis=0), 1e-3 * np.abs(a).max(axis=0))
    return float((np.abs(a - b).max(axis=0) / np.maximum(span, 1e-300)).max())


@pytest.fixture(params=["resume", "restart"])
def history(request):
    return request.param


@cache
def half_a_minute_on_floats(drive, history):
    """What half a minute means."""
    return table(problem_a(history), drive, "floats")


@pytest.mark.parametrize("history", ["resume", "restart"])
@pytest.mark.parametrize("drive", DRIVES)
def test_runtimes_agree_over_half_a_minute(drive, history, c_compiler):
    meant = half_a_minute_on_floats(drive, history)
    assert np.ptp(meant[:, 2]) > 0.1  # the wire does transform
    assert disagreement(meant, table(problem_a(history), drive, "c")) <= TOLERANCE


LEVELS = {"V": 2.5, "A": 0.55, "W": 2.0, "K": 330.0, "1": 0.8}
PARTS = [
    thing
    for kind in ("law", "element", "mechanism", "drive")
    for thing in examples(kind)
    if kind != "mechanism" or len(thing.ports()) == 1
]


def is_first(part):
    """Whether it is the first form of its class; kernels of all forms are compared in C one by one."""
    return label(part) == label(next(one for one in PARTS if type(one) is type(part)))


@pytest.mark.parametrize(
    "thing", [pytest.param(part, marks=[] if is_first(part) else pytest.mark.slow) for part in PARTS], ids=label
)
def test_every_part_runs_the_same_in_c(thing, c_compiler):
    """Three seconds of on and off with any registered part in a system of one element.

    Coordinates settle to 1e-11: one pass more or less is what rounding decides.
    """
    system: Any = example_system(thing)
    source = system.source
    rest = system.environment.temperature if source.sets_temperature else 0.0
    sign = -1.0 if getattr(source, "conducts", "both") == "negative" else 1.0
    wave = Step(low=rest, high=sign * LEVELS[source.unit], at=0.1, until=1.5)
    runs = [
        simulate(system, {"drive": wave}, 3.0, step=0.01, samples=31, runtime=runtime) for runtime in ("floats", "c")
    ]
    meant, found = (np.array(list(run.columns.values())).T for run in runs)
    assert not runs[0].status.failed
    settled = 100.0 * TOLERANCE if isinstance(thing, AbstractMultibody) else TOLERANCE
    assert disagreement(meant, found) <= settled
    assert runs[0].range("temperature") > 5.0


def test_a_perturbed_constant_is_noticed(c_compiler):
    system = problem_a()
    other = system.with_values({"heat_capacity": 400.0 * (1 + 1e-10)})
    meant = table(system, "sine", "floats", 5.0)
    apart = disagreement(meant, table(other, "sine", "c", 5.0))
    assert apart > TOLERANCE
