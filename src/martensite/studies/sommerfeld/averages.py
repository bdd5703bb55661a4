"""Averaged steady states near the resonance, their folds, and parameters of measured ramps.

At rotor speed ω the tip has amplitude X, and the resulting torque loads the motor:

    X(ω) = m r ω²/√[(k - M ω²)² + (c ω)²]
    V(ω) = K_B ω + (R/K_T) [b ω + ½ c ω X²]

Where V falls with ω the states are unstable; folds are its maximum and minimum. At the peak of a slow ramp ω = √(k/M),
so c ω A = m r ω² and, without b,

    M = k/ω²,    c = m r ω/A,    R = K_T (V - K_B ω)/(½ m r ω² A).

Two ramps of one motor compare without R: (V₂ - K_B ω₂)/(V₁ - K_B ω₁) = ω₂² A₂/(ω₁² A₁).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite import simulate
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.signals.sampling.sampled import Numbers
from martensite.studies.sommerfeld.machines import natural_frequency
from martensite.studies.tables import Printed

AMPLITUDE = 0.054
"""Peak amplitude of the ramp without the wire [m]: whole millimetres near the printed "approximately" 0.052 m that give
the printed reduction.
"""


@dataclass(frozen=True)
class Fold:
    """End of a branch of steady states."""

    speed: float
    """[rad/s]"""
    voltage: float
    """[V]"""


def amplitude_at(motor: BeamMotor, speed: float) -> float:
    """Return X [m] at a speed [rad/s]."""
    thrown = motor.unbalance * motor.eccentricity * speed * speed
    detuned = motor.stiffness - motor.mass * speed * speed
    return thrown / math.hypot(detuned, motor.damping * speed)


def voltage_at(motor: BeamMotor, speed: float) -> float:
    """Return V [V] at a speed [rad/s]."""
    torque = motor.rotor_friction + 0.5 * motor.damping * amplitude_at(motor, speed) ** 2
    return speed * (motor.back_emf + motor.resistance / motor.torque_constant * torque)


def find_folds(motor: BeamMotor) -> tuple[Fold, Fold]:
    """Return the upward and the downward fold of V(ω), followed from below √(k/M)."""
    peak = natural_frequency(motor)

    def missing(unknowns: Numbers) -> float:
        return voltage_at(motor, float(unknowns[0])) - float(unknowns[1])

    def sizes(unknowns: Numbers) -> tuple[float, float]:
        return math.hypot(float(unknowns[0]) - peak, motor.damping / motor.mass), abs(float(unknowns[1]))

    begin, most = 0.8 * peak, 2.0 * voltage_at(motor, peak)
    curve = simulate.trace_curve(missing, [begin, voltage_at(motor, begin)], 0.0, most, sizes=sizes)
    (upper, above), (lower, below) = curve.folds.tolist()[:2]
    return Fold(upper, above), Fold(lower, below)


@dataclass(frozen=True)
class RampCalibration:
    """Calibration of a slow ramp to the measurement."""

    mass: float
    """[kg]"""
    damping: float
    """[N s/m]"""
    resistance: float
    """[ohm]"""


def calibrate_beam(printed: Printed) -> RampCalibration:
    """Return M from the measured frequency, c from the amplitude, R from the jump voltage."""
    omega = 2.0 * math.pi * printed.measured_frequency
    moment = printed.unbalance * printed.eccentricity
    torque = 0.5 * moment * omega**2 * AMPLITUDE
    left = printed.jump - printed.constant * omega
    return RampCalibration(printed.stiffness / omega**2, moment * omega / AMPLITUDE, printed.constant * left / torque)


def required_changes(printed: Printed) -> tuple[float, float]:
    """Return the required factors of stiffness and damping by the wire, for any R."""
    first = 2.0 * math.pi * printed.measured_frequency
    share = 1.0 - printed.reduction

    def missing(omega: float) -> float:
        volts = printed.jump_with_wire - printed.constant * omega
        return volts / (printed.jump - printed.constant * first) - share * (omega / first) ** 2

    low, high = 0.5 * first, 4.0 * first
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if missing(middle) > 0.0 else (low, middle)
    ratio = low / first
    return ratio**2, ratio / share
