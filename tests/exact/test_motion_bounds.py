"""The accuracy of motions with inertia is a bound, at tolerances near rounding and on steps that cannot be shorter.

Sources of truth: the free vibration of a damped beam and the start of a motor in closed form; SciPy's DOP853 over
the equations of a rotor with an unbalance on a beam, solved by hand for their second derivatives.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import integrate

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.scenario.running import run
from martensite.signals.constant import Constant
from martensite.simulate import marching
from martensite.simulate.result import Result

MASS, STIFFNESS, DAMPING, INERTIA = 0.1961, 541.0, 0.2335, 0.82e-4
UNBALANCE, ECCENTRICITY, SPEED, PUSHED = 0.012, 0.02, 40.0, 9e-3
NUMBERS: dict[str, Any] = {
    "mass": MASS,
    "stiffness": STIFFNESS,
    "rotor_inertia": INERTIA,
    "torque_constant": 0.0,
    "back_emf": 0.0,
    "resistance": 6.22,
    "inductance": 3.1e-3,
}
MOTOR: dict[str, Any] = {"torque_constant": 0.0211, "back_emf": 0.0211}
VOLTS = 5.0
BEAM = NUMBERS | {"damping": DAMPING, "unbalance": 0.0, "eccentricity": 0.0}
ROTOR = NUMBERS | {"damping": 0.0, "unbalance": UNBALANCE, "eccentricity": ECCENTRICITY}


def swing(numbers: dict[str, Any], duration: float, speed: float, **how: Any) -> Result:
    machine, start = Machine(mechanism=BeamMotor(**numbers)), {"displacement": PUSHED, "rotor_speed": speed}
    return run(machine, {"motor": Constant(level=0.0)}, duration, samples=101, initial=start, **how)


def miss(found: Any, exact: Any) -> float:
    """True error of an output as a fraction of its range."""
    return float(np.abs(found - exact).max() / np.ptp(exact))


def decay(times: Any) -> Any:
    """Displacement of the damped beam [m]."""
    rate = 0.5 * DAMPING / MASS
    omega = math.sqrt(STIFFNESS / MASS - rate * rate)
    return PUSHED * np.exp(-rate * times) * (np.cos(omega * times) + rate / omega * np.sin(omega * times))


def turn(times: Any) -> Any:
    """Displacement, velocity, angle and speed of the rotor with its unbalance on the beam."""
    moment = UNBALANCE * ECCENTRICITY
    turning = INERTIA + moment * ECCENTRICITY

    def rates(_: float, state: Any) -> list[float]:
        x, v, angle, w = state
        tied = moment * math.cos(angle)
        force = moment * w * w * math.sin(angle) - STIFFNESS * x
        whole = MASS * turning - tied * tied
        return [v, turning * force / whole, w, -tied * force / whole]

    start = [PUSHED, 0.0, 0.0, SPEED]
    return integrate.solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=3e-14, atol=1e-15).y


def start_motor(times: Any) -> Any:
    """Speed of a motor without friction [rad/s], from rest under a voltage."""
    constant, ohms, henry = MOTOR["back_emf"], NUMBERS["resistance"], NUMBERS["inductance"]
    mean = 0.5 * ohms / henry
    apart = math.sqrt(mean * mean - constant * constant / (henry * INERTIA))
    slow, fast = apart - mean, -apart - mean
    left = (fast * np.exp(slow * times) - slow * np.exp(fast * times)) / (fast - slow)
    return VOLTS / constant * (1.0 - left)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
def test_bound_of_a_damped_beam_holds(tolerance: float, c_compiler: str) -> None:
    found = swing(BEAM, 0.2, 0.0, tolerance=tolerance, runtime="c")
    assert found.accuracy is not None and found.accuracy < 1e3 * tolerance
    assert miss(found["displacement"], decay(np.array(found.times))) <= found.accuracy


def test_bound_of_a_rotor_with_an_unbalance_holds(c_compiler: str) -> None:
    found = swing(ROTOR, 0.1, SPEED, tolerance=1e-8, runtime="c")
    place, _, _, speed = turn(np.array(found.times))
    assert found.accuracy is not None and found.accuracy < 1e-6
    assert max(miss(found["displacement"], place), miss(found["rotor_speed"], speed)) <= found.accuracy


@pytest.mark.parametrize("how", [{"runtime": "floats"}, {"runtime": "c"}, {"runtime": "c", "over": {"damping": [0.1]}}])
def test_steps_that_cannot_be_shorter_are_part_of_the_bound(
    how: dict[str, Any], monkeypatch: pytest.MonkeyPatch, c_compiler: str
) -> None:
    """All passes sit on steps longer than the time constant of the winding, and so do not differ."""
    monkeypatch.setattr(marching, "FINEST", 0.2)
    monkeypatch.setattr(marching, "ROUGHNESS", 1.0)
    numbers: dict[str, Any] = BEAM | MOTOR
    motor = Machine(mechanism=BeamMotor(**numbers))
    found = run(motor, {"motor": Constant(level=VOLTS)}, 0.3, samples=101, tolerance=1e-7, **how)
    claimed: Any = found.accuracy if found.variants is None else found.variants.accuracy
    claimed = np.atleast_1d(claimed)[0]
    assert 1e-7 < miss(np.atleast_2d(found["rotor_speed"])[0], start_motor(np.array(found.times))) <= claimed
