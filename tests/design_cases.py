"""A bundle of thin wires against a spring, to be designed; tests of designs share it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.design.optimise.evaluate import DesignEvaluator
from martensite.design.optimise.question import read_question
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.simulate.waveform_levels import WaveformLevels

BUNDLE = """
title = "bundle"
[element]
kind = "bundle"
material = "flexinol-90"
count = 2
[element.strand]
kind = "wire"
law = { kind = "liang-rogers", modulus = "mixture" }
diameter = "0.12 mm"
length = "200 mm"
[environment]
temperature = "22 degC"
cooling = { kind = "churchill-chu", fluid = { kind = "air" } }
[mechanism]
kind = "bias-spring"
stiffness = "0.4 N/mm"
preload = "2 N"
[drive]
kind = "power"
waveform = { kind = "step", high = "5 W", at = "0.2 s", until = "1.5 s" }
[run]
duration = "3 s"
samples = 121
"""
SAMPLES, STEP = 121, 0.025
COUNT, DIAMETER = "element.count=1..6", "strand.diameter=0.08..0.2 mm"
POWER = "drive.waveform.high=1..12 W"


@cache
def bundle() -> Scenario:
    """The scenario."""
    return read_scenario(BUNDLE)


def steering(**changes: float) -> WaveformLevels:
    """The bundle and its power, with changes of numbers by ending of their paths."""
    one = bundle()
    return WaveformLevels(one.system.with_values(changes), one.waveform, one.duration)


def designs(
    free: Sequence[str], goal: str, subject: Sequence[str], begin: WaveformLevels | None = None, **options: Any
) -> DesignEvaluator:
    """Designs of the bundle; options are those of `Designs`."""
    given = begin or steering()
    question = read_question(given, free, goal, subject)
    return DesignEvaluator(given, question, samples=SAMPLES, step=STEP, **options)


def differences(one: DesignEvaluator, z: NDArray[np.float64], apart: float) -> NDArray[np.float64]:
    """Central differences of what a design is judged by, (cases, aims, free)."""
    moved = apart * np.eye(len(z))
    up, down = one.values(z + moved), one.values(z - moved)
    return np.moveaxis((up - down) / (2.0 * apart), 0, 2)
