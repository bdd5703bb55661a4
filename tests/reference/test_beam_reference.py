"""Beam, motor and hot wire against one page that shares nothing with the package (`beam_reference`)."""

from typing import Any

import numpy as np
import pytest
from beam_reference import run_beam

from martensite.kernels.compiler import find_compiler
from martensite.scenario.scenario import load
from martensite.signals.ramp import Ramp
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.studies.sommerfeld import machines, runs, wire

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")


def run_package(slack: float, waves: dict[str, Any], duration: float, samples: int, **how: Any) -> Any:
    """The machine of the study with another slack, in C."""
    system = load(machines.SCENARIO, {"mechanism.slack": slack}).system
    return simulate(system, waves, duration, samples=samples, runtime="c", **how)


def test_a_hot_wire_on_the_beam_is_that_of_the_page() -> None:
    """Over 6 s in which the wire is heated until it turns to austenite and is drawn into martensite by every swing."""
    count = 8_000
    rows = np.array(run_beam(0.005, 0.5, 6.0, 1.4, 0.0, 6.0 / count))
    waves = {"motor": Ramp(high=3.0, end=6.0), "drive": Step(high=1.4, at=0.0)}
    found = run_package(0.005, waves, 6.0, count + 1)
    place, speed, heat = (np.array(found[name])[1:] for name in ("displacement", "rotor_speed", "temperature"))
    fraction = np.array(found["martensite_fraction"])
    assert fraction.min() < 0.01 and np.diff(fraction).max() > 1e-4 and max(found["stress"]) > 300e6
    assert np.abs(rows[:, 0] - place).max() < 1e-3 * np.ptp(place)
    assert np.abs(rows[:, 1] - speed).max() < 1e-3 * np.ptp(speed)
    assert np.abs(rows[:, 2] - heat).max() < 0.02


def test_steps_are_no_shorter_than_speeds_are_known_for() -> None:
    """Kinks of the wire cut steps to nanoseconds, over which differences of places say nothing of speeds."""
    waves = {"motor": Ramp(high=4.5, end=5.0), "drive": Step(high=1.1, at=0.0)}
    found = run_package(0.01, waves, 8.0, 101)
    assert found.accuracy < 0.01
    fixed = run_package(0.01, waves, 8.0, 101, step=2e-4)
    assert max(found["displacement"]) == pytest.approx(max(fixed["displacement"]), rel=2e-3)


@pytest.mark.slow
def test_jump_and_amplitude_of_the_ramp_are_those_of_the_page() -> None:
    """The whole ramp of the study with its best slack."""
    step, ramp = 4e-4, wire.REACH / wire.RATE
    rows = np.array(run_beam(0.015, wire.RATE, ramp, 1.1, 3.124, step))
    size = round(runs.WINDOW / step)
    cut = rows[: len(rows) // size * size].reshape(-1, size, 3)
    captured = cut[:, :, 1].mean(axis=1) < runs.CAPTURED * machines.natural_frequency(machines.calibrated_motor())
    waves = {"motor": Ramp(high=wire.REACH, end=ramp), "drive": Step(high=1.1, at=3.124)}
    found = run_package(0.015, waves, ramp, round(ramp / wire.PERIOD) + 1, step=step)
    windows = runs.split_windows(found, machines.calibrated_motor())
    assert int(np.flatnonzero(captured)[-1]) == windows.end
    assert 0.5 * np.ptp(cut[:, :, 0], axis=1).max() == pytest.approx(windows.peak, rel=2e-3)
