"""Halving the time step of a MuJoCo model: first order as it is, second if forces are centred.

Source of truth: the closed form of an oscillator, x = (v/ω) sin ωt.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install mujoco)")

from mujoco_cases import actuator, stiffness, weighed


def errors(coupling: str) -> list[float]:
    """Largest errors over a period, in 160, 320 and 640 steps."""
    mass, speed, found = 0.5, 1e-2, list[float]()
    frequency = math.sqrt(stiffness(actuator(elastic=True)) / mass)
    for steps in (160, 320, 640):
        dt = 2.0 * math.pi / frequency / steps
        bridge = weighed(mass, dt, coupling)
        bridge.data.joint("x").qvel[0] = speed
        result = bridge.run(steps * dt, {"wire": 0.0}, samples=steps + 1)
        # velocities of MuJoCo belong to half steps: at the start x is 0 and v is half a step old
        exact = speed / frequency * np.sin(frequency * np.array(result.times))
        found.append(float(max(abs(np.array(result["x"]) - exact))))
    return found


@pytest.mark.parametrize(("coupling", "order"), [("end", 1.0), ("centred", 2.0)])
def test_order_of_the_coupling(coupling: str, order: float) -> None:
    coarse, middle, fine = errors(coupling)
    assert math.log2(coarse / middle) == pytest.approx(order, abs=0.1)
    assert math.log2(middle / fine) == pytest.approx(order, abs=0.05)


def test_centred_is_the_better_one() -> None:
    """So that an order of 2 is not one of an error that is large."""
    assert errors("centred")[0] < 0.1 * errors("end")[0]
