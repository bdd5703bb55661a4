"""Numbers of the beam and of the motor at constant voltages: chapter 4 and section 5.1."""

from __future__ import annotations

import math
from typing import Any

from martensite.studies.sommerfeld import averages, machines, rk4, runs
from martensite.studies.tables import Printed

FIRST = 6.0
"""First voltage of the search on the grid [V]."""
MASS_ROUNDING = 0.005
"""Half of the last printed digit of the masses [kg]."""
UP, DOWN = (0.5, 90.0), (0.02, (2.0, 0.8))
"""Sweeps with Table 3: rate [V/s], and end or both ends [V]."""


def compute_beam(printed: Printed) -> dict[str, Any]:
    """Return beam, capture from rest, integrator, energy, folds."""
    wrong, right = (machines.printed_motor(printed, form) for form in ("printed", "lagrange"))
    upper, lower = averages.find_folds(right)
    captured = runs.last_captured(wrong, FIRST)
    rotor = right.resistance * right.rotor_inertia
    return {
        **compute_frequencies(printed),
        "half_grid": 0.5 * runs.GRID,
        "captured_printed": captured,
        "captured_lagrange": runs.last_captured(right, FIRST),
        "captured_modes": runs.last_captured(machines.motor_with_modes(right, printed, 3), FIRST),
        "captured_speed": runs.from_rest(wrong, captured).speed / machines.natural_frequency(wrong),
        "captured_rk4": rk4.last_captured(wrong, printed.simulated_jump - 0.1),
        "step_limit": 1e3 * rk4.step_limit(right),
        "step_bound": 1e3 * (rk4.INTERVAL * printed.inductance / printed.resistance),
        "energy_percent": 100.0 * rk4.energy_drift(wrong),
        "energy_lagrange": rk4.energy_drift(right),
        "energy_printed": rk4.energy_drift(wrong),
        "upper": upper,
        "lower": lower,
        "fold_up": upper.voltage,
        "fold_down": lower.voltage,
        "up_rate": UP[0],
        "down_rate": DOWN[0],
        "sweep_up": runs.run_upward(right, *UP).jump,
        "sweep_down": runs.dropped_below(runs.run_downward(right, *DOWN), lower.speed),
        "rotor_lag": rotor / printed.constant**2,
    }


def compute_frequencies(printed: Printed) -> dict[str, float]:
    """Return the stiffness [N/m] of the beam, and its natural frequencies [Hz] with both printed masses."""
    other, frequency = (
        math.sqrt(k / m) / (2.0 * math.pi)
        for m, k in ((printed.mass, printed.stiffness), (printed.second_mass, printed.computed_stiffness))
    )
    return {
        "stiffness": machines.build_beam(printed).stiffness,
        "frequency": frequency,
        "other_frequency": other,
        "frequency_margin": 0.5 * frequency * MASS_ROUNDING / printed.second_mass,
        "needed_mass": printed.computed_stiffness / (2.0 * math.pi * printed.analytical_frequency) ** 2,
    }
