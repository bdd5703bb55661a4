"""Runs side by side in C are single runs, whatever drives them and however they step.

Source of truth: `simulate` of the same system, with a tolerance fifty times smaller. A single run is a batch of one
lane, whose kernels are printed without vectors.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.problem_b import Wire, system, waveform
from builders import problem_a

import martensite as ms
from martensite.actuators.assembly import AbstractSystem
from martensite.base.status import Status
from martensite.design.sweep.subject import list_waveforms
from martensite.scenario.scenario import load
from martensite.signals.base import AbstractWaveform
from martensite.simulate.ensembles import Ensemble
from martensite.simulate.variants import VariantSetup

EXAMPLES = Path(__file__).parents[2] / "examples"
SAMPLES = 101
FINE = 2e-6
SURELY = 3.0
"""Of the bound on an error: no run of the laboratory is further off, and 99 of 100 keep to it."""


def run_lanes(
    whole: AbstractSystem,
    waves: Mapping[str, AbstractWaveform],
    duration: float,
    values: Mapping[str, Any],
    signals: Mapping[str, Any] | None = None,
    runtime: str = "c",
) -> Ensemble:
    judged = tuple(whole.convergence_scales())
    course = VariantSetup(whole, waves, duration, SAMPLES, None, judged, runtime)
    found = course.run({p: np.asarray(v) for p, v in values.items()}, signals)
    assert found.status.tolist() == [Status.OK] * len(found.status)
    return found


def check_run(
    found: Ensemble, row: int, whole: AbstractSystem, waves: Mapping[str, AbstractWaveform], duration: float
) -> None:
    """A row is about as far from an exact run as it says, at most."""
    exact = ms.run(whole, waves, duration, samples=SAMPLES, tolerance=FINE, runtime="c")
    for name, least in whole.convergence_scales().items():
        apart = np.abs(found.columns[name][row] - exact[name]).max()
        assert apart <= (SURELY * found.accuracy[row] + FINE) * max(exact.range(name), least)


@pytest.mark.parametrize(
    "name", [pytest.param("antagonistic_wires", marks=pytest.mark.slow), "tensile-test", "pwm_bias_spring"]
)
def test_examples_in_lanes(name: str, c_compiler: str) -> None:
    """Several drives, a prescribed one, pulses."""
    scenario = load(EXAMPLES / f"{name}.toml")
    whole, waves = scenario.whole, list_waveforms(scenario)
    path = next(leaf.path for leaf in whole.leaves() if leaf.path.endswith("diameter"))
    nominal = next(leaf.value for leaf in whole.leaves() if leaf.path == path)
    values = {path: nominal * np.linspace(0.99, 1.0, 18)}
    duration = min(scenario.duration, 30.0)
    found = run_lanes(whole, waves, duration, values)
    check_run(found, 17, whole, waves, duration)


@pytest.mark.parametrize(
    ("law", "wave"),
    [("mas", ms.signals.PulseWidthModulation(high=4.0, frequency=1.0, duty=0.4)), ("mas-hybrid", waveform())],
    ids=["mas-pulses", "mas-hybrid-ramps"],
)
def test_laws_of_layers_in_lanes(law: str, wave: AbstractWaveform, c_compiler: str) -> None:
    whole = system(Wire(), law)
    values = {whole.resolve("h"): np.linspace(160.0, 240.0, 20)}
    found = run_lanes(whole, {"drive": wave}, 20.0, values)
    for row in (0, 13):
        one = whole.with_values({"h": float(values[whole.resolve("h")][row])})
        check_run(found, row, one, {"drive": wave}, 20.0)


SINE = ms.Sine(low=0.0, high=2.5, frequency=0.1)
FAST = ms.Sine(low=0.0, high=3.5, frequency=50.0)


@pytest.mark.parametrize("runtime", ["c", "floats"])
@pytest.mark.parametrize(
    ("wave", "duration", "name", "numbers"),
    [
        (SINE, 10.0, "frequency", [0.05, 0.1, 0.2]),
        (FAST, 1.0, "high", [2.0, 3.0, 3.5]),
        (ms.signals.PulseWidthModulation(high=5.0, frequency=2.0, duty=0.2), *(10.0, "duty", [0.1, 0.2, 0.3])),
        (ms.signals.Triangle(high=2.5, frequency=0.1), 10.0, "high", [1.5, 2.0, 2.5]),
    ],
    ids=["slow", "fast", "pulses", "ramps"],
)
def test_lanes_with_drives_of_their_own(
    wave: AbstractWaveform, duration: float, name: str, numbers: list[float], runtime: str, c_compiler: str
) -> None:
    whole = problem_a()
    signals = {"drive": {name: np.array(numbers)}}
    found = run_lanes(whole, {"drive": wave}, duration, {}, signals, runtime)
    for row in (0, 2):
        own = wave.with_values({name: numbers[row]})
        check_run(found, row, whole, {"drive": own}, duration)
