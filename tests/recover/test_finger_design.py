"""The finger designed: derivatives of all its measures, and the design beside brute force.

Sources of truth: central differences, and a grid of designs around and beyond the one found.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from design_cases import differences

from martensite.design.optimise.evaluate import DesignEvaluator
from martensite.design.optimise.optimise import optimise_design
from martensite.design.optimise.question import read_question
from martensite.design.optimise.search import scan_designs
from martensite.scenario.scenario import load
from martensite.simulate.waveform_levels import WaveformLevels

SCENARIO = Path(__file__).parents[2] / "examples" / "finger_design.toml"
BOX = ("strand.diameter=0.06..0.1 mm", "mechanism.offset=4..8 mm", "drive.waveform.high=2..6 W")
NEAR = ("strand.diameter=0.068..0.076 mm", "mechanism.offset=5.3..5.9 mm", "drive.waveform.high=3.6..4 W")
LIMITS = ("stroke >= 60 deg", "rise-time <= 0.5 s", "fall-time <= 0.5 s")
pytestmark = pytest.mark.usefixtures("c_compiler")


def test_derivatives_are_those_of_differences() -> None:
    one = load(SCENARIO)
    steering = WaveformLevels(one.system, one.waveform, 4.0)
    limits = (*LIMITS, "max(stress) <= 172 MPa", "max(hottest) <= 120 degC")
    free = "element.count=1..6", *BOX
    question = read_question(steering, free, "energy", limits)
    designs = DesignEvaluator(steering, question, samples=81, step=0.01)
    for z in (np.array([0.7, 0.4, 0.4, 0.6]), np.array([0.5, 0.6, 0.3, 0.4])):
        exact, near = designs.slopes(z), differences(designs, z, 1e-5)
        assert exact is not None
        size = np.abs(near).max(axis=2, keepdims=True)
        apart = np.abs(exact.slopes - near) / (1e-12 + size)
        assert apart.max() < 1e-5
        assert np.abs(exact.slopes * (1.0 + 1e-4) - near).max(initial=0.0, where=size > 0) > 0.0
        assert (size > 0.0).sum() >= 4


@pytest.mark.slow
def test_it_agrees_with_brute_force() -> None:
    one = load(SCENARIO)
    best = optimise_design(
        one.system,
        one.waveform,
        one.duration,
        ("element.count=1..12", *BOX),
        subject=LIMITS,
        life=0.0,
        samples=one.samples,
    )
    assert best.feasible
    assert best.numbers[0] == 4.0
    coarse = optimise_box(BOX, "element.count=3..5", best.step)
    grid = scan_designs(coarse, [3, 9, 9, 9])
    assert grid.best is not None
    assert grid.numbers[0] == 4.0  # none of the grid with three wires keeps all limits
    assert best.goal <= grid.values[0] * (1.0 + 1e-5)
    near = optimise_box(NEAR, "element.count=4..5", best.step)
    fine = scan_designs(near, [2, 9, 9, 9])
    z = np.array([f.share(v) for f, v in zip(near.question.free, best.numbers, strict=True)])
    assert fine.best is not None
    assert best.goal <= fine.values[0] * (1.0 + 1e-5) <= best.goal * 1.05
    assert max(fine.cells(z)[2:]) <= 3.0
    assert best.counts.simulations + best.counts.slopes < len(grid.z)


def optimise_box(box: tuple[str, ...], count: str, step: float) -> DesignEvaluator:
    """Designs of the finger in another box."""
    one = load(SCENARIO)
    steering = WaveformLevels(one.system, one.waveform, one.duration)
    limits = (*LIMITS, "max(stress) <= 172 MPa", "max(hottest) <= 120 degC")
    question = read_question(steering, (count, *box), "energy", limits)
    return DesignEvaluator(steering, question, samples=one.samples, step=step)
