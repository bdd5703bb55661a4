"""The machines of the study: motor and beam as printed, calibrated, and with a wire."""

from __future__ import annotations

import math
from functools import cache, partial
from pathlib import Path
from typing import cast

from martensite.actuators.mechanics.beam_modes import BeamModes, CantileverBeam, beam_modes
from martensite.actuators.mechanisms.beam_motor import BeamMotor, modal_numbers
from martensite.studies.readings import load_once
from martensite.studies.tables import Printed

SCENARIO = Path(__file__).with_name("scenario.toml")
load_scenario = partial(load_once, SCENARIO)
STEP = 4e-4
"""Step of all runs [s]."""


@cache
def printed_motor(printed: Printed, coupling: str = "lagrange") -> BeamMotor:
    """Return the motor of Table 3."""
    return BeamMotor(
        coupling=coupling,
        mass=printed.mass,
        stiffness=printed.stiffness,
        damping=printed.damping,
        unbalance=printed.unbalance,
        eccentricity=printed.eccentricity,
        rotor_inertia=printed.rotor_inertia,
        rotor_friction=printed.friction,
        torque_constant=printed.constant,
        back_emf=printed.constant,
        resistance=printed.resistance,
        inductance=printed.inductance,
    )


@cache
def calibrated_motor() -> BeamMotor:
    """Return the motor of the scenario, without the wire."""
    motor = cast("BeamMotor", load_scenario().system.mechanism)
    return motor.with_parts(wire="none", wire_length=math.inf)


def natural_frequency(motor: BeamMotor) -> float:
    """Return √(k/M) of the first mode [rad/s]."""
    return math.sqrt(motor.stiffness / motor.mass)


def build_beam(printed: Printed) -> CantileverBeam:
    """Return the beam of Table 4, without a tip mass."""
    return CantileverBeam(
        E=printed.young, density=printed.density, width=printed.width, height=printed.height, length=printed.length
    )


@cache
def beam_with_motor(printed: Printed, frequency: float, modes: int) -> tuple[float, BeamModes]:
    """Return the tip mass [kg] for a natural frequency [Hz], and the modes of the beam."""
    bare = build_beam(printed)
    light, heavy = 0.0, 10.0
    for _ in range(50):
        middle = 0.5 * (light + heavy)
        modes_of_beam = beam_modes(bare.with_values({"tip_mass": middle}), 1)
        light, heavy = (middle, heavy) if modes_of_beam.frequencies[0] > frequency else (light, middle)
    return light, beam_modes(bare.with_values({"tip_mass": light}), modes)


def motor_with_modes(motor: BeamMotor, printed: Printed, modes: int) -> BeamMotor:
    """Return a motor on the beam of Table 4 in several modes, with its first natural frequency."""
    _, beam = beam_with_motor(printed, natural_frequency(motor) / (2.0 * math.pi), modes)
    return motor.with_parts(**modal_numbers(beam))
