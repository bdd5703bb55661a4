"""Two motors on a beam against one page of SciPy (`motors_reference`), one motor, and what self-synchronisation is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from motors_reference import Motor, run_motors

from martensite.actuators.assembly import Machine
from martensite.actuators.mechanisms import BeamMotor, BeamMotors
from martensite.base.errors import ParameterError
from martensite.kernels.compiler import find_compiler
from martensite.signals import Constant
from martensite.simulate.api import simulate

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")

BEAM: dict[str, Any] = {"mass": 0.1961, "damping": 0.2335, "stiffness": 541.0}
FIRST: dict[str, Any] = {
    "unbalance": 0.012,
    "eccentricity": 0.02,
    "rotor_inertia": 0.82e-4,
    "rotor_friction": 8.17e-7,
    "torque_constant": 0.0211,
    "back_emf": 0.0211,
    "resistance": 6.22,
    "inductance": 3.1e-3,
}
SECOND: dict[str, Any] = {f"{name}_2": value for name, value in FIRST.items()}
MOTOR = Motor(0.012 * 0.02, 0.82e-4 + 0.012 * 0.02**2, 0.0211, 6.22, 3.1e-3, 8.17e-7)


def run(volts: tuple[float, float], duration: float, samples: int, tolerance: float = 1e-5, **changes: Any) -> Any:
    system = Machine(mechanism=BeamMotors(**{**BEAM, **FIRST, **SECOND, **changes}))
    waves = {"motor": Constant(level=volts[0]), "motor_2": Constant(level=volts[1])}
    return simulate(system, waves, duration, samples=samples, tolerance=tolerance, runtime="c")


def test_two_motors_are_those_of_a_page_of_scipy_and_energy_closes() -> None:
    """In opposite directions and of different speed, through resonance of the beam (52 rad/s)."""
    other: dict[str, Any] = {"unbalance_2": 0.008, "resistance_2": 5.0, "torque_constant_2": 0.02, "back_emf_2": 0.02}
    second = MOTOR._replace(moment=0.008 * 0.02, turning=0.82e-4 + 0.008 * 0.02**2, ohms=5.0, constant=0.02)
    found, times = run((2.5, -1.5), 2.0, 201, **other), np.linspace(0.0, 2.0, 201)
    wanted = run_motors((0.1961, 0.2335, 541.0), [MOTOR, second], [2.5, -1.5], times)
    for name, row, size in (("displacement", 0, 0.02), ("rotor_speed", 4, 50.0), ("rotor_speed_2", 5, 50.0)):
        assert np.abs(np.array(found[name]) - wanted[row]).max() < 1e-3 * size, name
    assert max(found["rotor_speed"]) > 52.0
    work = found.energy["work"]
    assert (work.residual or 1.0) < 1e-5


def test_without_its_unbalance_the_second_motor_leaves_the_first_alone() -> None:
    two = run((3.0, 2.0), 1.5, 151, unbalance_2=0.0)
    one = simulate(
        Machine(mechanism=BeamMotor(**BEAM, **FIRST)),
        Constant(level=3.0),
        1.5,
        samples=151,
        tolerance=1e-5,
        runtime="c",
    )
    for name, size in (("displacement", 0.02), ("rotor_speed", 100.0), ("motor_current", 0.5)):
        assert np.abs(np.array(two[name]) - np.array(one[name])).max() < 1e-4 * size, name


def find_lag(volts: tuple[float, float], **changes: Any) -> tuple[float, float]:
    """Mean phase between the rotors [rad], and how far one runs ahead, over the last of 10 s [rad]."""
    found = run(volts, 10.0, 1001, 1e-3, **changes)
    apart = np.array(found["rotor_angle_2"][-100:]) - np.array(found["rotor_angle"][-100:])
    return float(np.angle(np.exp(1j * apart).mean())), float(abs(apart[-1] - apart[0]))


def test_motors_of_different_speed_keep_step_through_the_beam() -> None:
    """Below the resonance of the beam in phase, above it against each other; without unbalance not at all."""
    below, slip = find_lag((0.9, 0.92))
    assert abs(below) < 0.2
    assert slip < 0.1
    above, slip = find_lag((3.0, 3.2))
    assert abs(above) > math.pi - 0.2
    assert slip < 1.0  # alone they would drift apart by 9 rad
    assert find_lag((0.9, 0.92), unbalance_2=0.0)[1] > 0.5


def test_the_mass_holds_both_unbalances() -> None:
    with pytest.raises(ParameterError, match="holds both unbalances"):
        BeamMotors(**(BEAM | FIRST | SECOND | {"unbalance_2": 0.19}))
