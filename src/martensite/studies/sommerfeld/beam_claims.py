"""Claims on the beam and on the motor at constant voltages: chapter 4 and section 5.1."""

from __future__ import annotations

import math

from martensite.studies.base import Claim
from martensite.studies.sommerfeld import averages, machines, rk4, runs
from martensite.studies.sommerfeld.printed import THESIS, Printed

TABLE_5, FREQUENCY = f"{THESIS}, Table 5", f"{THESIS}, section 5.1.2"
FIGURE_21, INTEGRATOR = f"{THESIS}, Figure 21", f"{THESIS}, equations (3.16) and (3.17)"
EQUATIONS = f"{THESIS}, equations (3.10) and (3.15)"
FIRST = 6.0
"""Voltage at which the search on the grid begins [V]."""
UP, DOWN = (0.5, 90.0), (0.02, (2.0, 0.8))
"""Sweeps with Table 3: rate [V/s], and end or both ends [V]."""


def claims(printed: Printed) -> list[Claim]:
    """Beam, capture from rest, integrator, energy, folds."""
    return [
        *_beam(printed), *_captured(printed), *_integrator(printed), *_energy(printed),
        *_folds(printed),
    ]  # fmt: skip


def _beam(printed: Printed) -> list[Claim]:
    hertz = 1.0 / (2.0 * math.pi)
    pairs = (
        (printed.mass, printed.stiffness, "Table 3"),
        (printed.second_mass, printed.computed_stiffness, "Table 5"),
    )
    return [
        Claim.checked(
            "stiffness", "stiffness of the beam of Table 4", TABLE_5, printed.computed_stiffness,
            machines.beam(printed).stiffness, "N/m", 0.1, "3 E I/l³; printed in Pa",
        ),
        *(
            Claim.checked(
                f"frequency-{mass:.2f}kg", f"natural frequency with the {mass:.2f} kg of {where}",
                FREQUENCY, printed.analytical_frequency, hertz * math.sqrt(k / mass), "Hz", 0.03,
                "√(k/M)/2π; neither of the two printed masses gives it",
            )
            for mass, k, where in pairs
        ),
    ]  # fmt: skip


def _captured(printed: Printed) -> list[Claim]:
    wrong, right = (machines.printed_motor(printed, form) for form in ("printed", "lagrange"))
    modes = machines.motor_with_modes(right, printed, 3)
    protocol = "constant voltage for 25 s from rest, mean speed of the last second, grid of 0.1 V"
    voltages = (
        ("printed", wrong, f"{protocol}; equation (3.15) as printed"),
        ("lagrange", right, f"{protocol}; signs derived anew: one step of the grid more"),
    )
    statement = "last voltage captured near the resonance"
    return [
        *(
            Claim.checked(
                f"captured-{name}", f"{statement}, {name} signs", FIGURE_21,
                printed.simulated_jump, runs.last_captured(motor, FIRST), "V", 0.5 * runs.GRID, why,
            )
            for name, motor, why in voltages
        ),
        Claim.reported(
            "captured-modes", f"{statement}, three modes of the beam",
            f"{THESIS}, section 5.1.3", runs.last_captured(modes, FIRST), "V",
            "the thesis expects better results from finite elements: beam of Table 4, tip mass "
            "chosen for the same √(k/M); the result is that of one mode",
        ),
        Claim.reported(
            "captured-speed", "speed at the last captured voltage over √(k/M)", FIGURE_21,
            runs.from_rest(wrong, runs.last_captured(wrong, FIRST)).speed
            / machines.natural(wrong), "1",
            "the plateau: amplitude and current grow with the voltage, the speed does not",
        ),
    ]  # fmt: skip


def _integrator(printed: Printed) -> list[Claim]:
    wrong, right = (machines.printed_motor(printed, form) for form in ("printed", "lagrange"))
    bound = rk4.INTERVAL * printed.inductance / printed.resistance
    return [
        Claim.checked(
            "captured-rk4", "last voltage captured, by the thesis's integrator", INTEGRATOR,
            printed.simulated_jump, rk4.last_captured(wrong, printed.simulated_jump - 0.1), "V",
            0.5 * runs.GRID, "RK4 in steps of 0.1 ms over the same equations, 10 s from rest",
        ),
        Claim.reported(
            "step-limit", "longest stable step of RK4", INTEGRATOR, 1e3 * rk4.step_limit(right),
            "ms", f"found by trying; 2.785 L/R = {1e3 * bound:.4f} ms; the thesis states no step",
        ),
    ]  # fmt: skip


def _energy(printed: Printed) -> list[Claim]:
    why = "no damping, friction or torque, RK4 in steps of 0.1 ms for 5 s from 40 rad/s"
    forms = (
        ("lagrange", "energy of the isolated system, derived signs: largest relative change", why),
        ("printed", "the same with equation (3.15) as printed", f"{why}; a sign is wrong"),
    )
    return [
        Claim.reported(
            f"energy-{form}", words, EQUATIONS,
            rk4.energy_drift(machines.printed_motor(printed, form)), "1", reason,
        )
        for form, words, reason in forms
    ]  # fmt: skip


def _folds(printed: Printed) -> list[Claim]:
    motor = machines.printed_motor(printed)
    upper, lower = averages.folds(motor)
    up = runs.upward(motor, *UP)
    down = runs.dropped_below(runs.downward(motor, *DOWN), lower.speed)
    return [
        Claim.reported(
            "fold-up", "upward fold of the steady states with Table 3", FIGURE_21, upper.voltage,
            "V", f"maximum of V(ω), at {upper.speed:.2f} rad/s",
        ),
        Claim.reported(
            "fold-down", "downward fold", FIGURE_21, lower.voltage, "V",
            f"minimum of V(ω), at {lower.speed:.2f} rad/s: a wide hysteresis",
        ),
        Claim.reported(
            "sweep-up", "jump in a slow ramp upwards with Table 3", FIGURE_21, up.jump, "V",
            f"{UP[0]:g} V/s from rest: the state is carried over, and there is no jump near 6.6 V",
        ),
        Claim.reported(
            "sweep-down", "fall below the speed of the fold in a slow ramp downwards", FIGURE_21,
            down, "V",
            f"{DOWN[0]:g} V/s; the rotor lags by R J/(K_T K_B) = "
            f"{motor.resistance * motor.rotor_inertia / printed.constant**2:.1f} s",
        ),
    ]  # fmt: skip
