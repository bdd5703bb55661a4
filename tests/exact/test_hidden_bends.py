"""Bends of a law next to the end of a step, where the halves of the step miss the same as the whole.

Source of truth: runs of the same case to a tolerance a thousand times tighter, in which the steps end elsewhere.
"""

import math

import numpy as np
import pytest
from builders import chamber, example, through

from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.physics.laws.base import LAWS
from martensite.simulate.api import simulate

MPA = 1e6
SECTION = 0.25 * math.pi * 0.381e-3**2
STIFFNESS = 100 * MPA * SECTION / (0.05 * 0.25)
WAVES = {
    "cycles": through([240.0, 500.0, 240.0, 500.0, 240.0], 100.0),
    "random": through([300.0, 305.728, 268.629, 321.339, 325.356, 267.244, 267.801], 20.0),
}


@pytest.mark.parametrize(
    ("name", "wave", "stiffness", "preload", "tolerance", "runtime"),
    [
        ("brinson", "cycles", 1.0, 0.0, 1e-4, "c"),
        *(("tanaka", "random", 1.6543, 20.0, 1e-3, runtime) for runtime in ("floats", "c")),
    ],
)
def test_a_bend_next_to_the_end_of_a_step_is_met(name, wave, stiffness, preload, tolerance, runtime):
    spring = BiasSpring(stiffness=stiffness * STIFFNESS, preload=preload * MPA * SECTION)
    system, duration = chamber(example(LAWS[name])).with_parts(mechanism=spring), 400.0 if wave == "cycles" else 120.0
    rough, fine = (
        simulate(system, WAVES[wave], duration, samples=401, runtime=runtime, tolerance=each)
        for each in (tolerance, 1e-3 * tolerance)
    )
    for column in ("martensite_fraction", "stress"):
        error = np.abs(rough[column] - fine[column]).max() / np.ptp(fine[column])
        assert error <= rough.accuracy
