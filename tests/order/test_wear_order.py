"""A worn wire is marched at first order, as `physics.laws.wear` says; without wear it would be the second.

Source of truth: errors against a run of eight times finer steps fall with the step.
"""

import numpy as np
import pytest
from builders import SINE_A, problem_a

from martensite.physics.laws.wear import Wear
from martensite.simulate.api import simulate

STEPS = (40e-3, 20e-3, 10e-3)
WEAR = Wear(settling_cycles=5.0, residual_strain=0.004, stroke_loss=0.2, temperature_shift=-6.0)


def test_numbers_that_lag_by_a_step_are_of_first_order() -> None:
    worn = problem_a().with_parts(element=problem_a().element.with_parts(wear=WEAR))
    runs = [np.array(simulate(worn, SINE_A, 60.0, step=h, samples=121)["position"]) for h in (*STEPS, STEPS[-1] / 8.0)]
    errors = [np.abs(run - runs[-1]).max() / np.ptp(runs[-1]) for run in runs[:-1]]
    assert np.polyfit(np.log(STEPS), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.3)
    assert errors[0] < 3e-4
