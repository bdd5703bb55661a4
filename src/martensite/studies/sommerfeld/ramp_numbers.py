"""Numbers of the measured ramps: implications, and the calibrated motor without the wire."""

from __future__ import annotations

from typing import Any

from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.studies.sommerfeld import averages, beam_numbers, machines, runs, wire
from martensite.studies.sommerfeld.runs import Windows
from martensite.studies.tables import Printed

RATES = (0.1, 0.5, 1.0)
"""Other rates of the ramp [V/s]."""
LAST = 12.0
"""End of the ramps with changed stiffness or damping [V]."""


def compute_ramp(printed: Printed) -> dict[str, Any]:
    """Return the values of Table 3 in a ramp, calibration, rates, and required changes."""
    without, motor = wire.run_without_wire(printed), machines.calibrated_motor()
    stiff, damped = averages.required_changes(printed)
    return {
        **compare_jumps(printed),
        "up_rate": beam_numbers.UP[0],
        "ramp_table_3": runs.run_upward(machines.printed_motor(printed), *beam_numbers.UP).jump,
        "calibration": averages.calibrate_beam(printed),
        "amplitude_mm": 1e3 * averages.AMPLITUDE,
        "rate": wire.RATE,
        "ramp_jump": without.jump,
        "ramp_amplitude": without.peak,
        "rates": [{"other_rate": rate, "other_jump": runs.run_upward(motor, rate, 8.0).jump} for rate in RATES],
        "required_stiffness": stiff,
        "required_damping": damped,
        **{f"with_{name}": windows.jump for name, windows in ramp_variants(printed).items()},
    }


def compare_jumps(printed: Printed) -> dict[str, float]:
    """Return the jumps from printed numbers alone."""
    _, after = whole_millimetres(printed)
    sooner = printed.jump - printed.jump_with_wire
    return {"earlier": sooner, "left_mm": after, "current_drop_table_3": sooner / printed.resistance}


def whole_millimetres(printed: Printed) -> tuple[int, int]:
    """Return the amplitudes within 6 mm of the printed one that give the printed reduction [mm]."""
    text, wanted = round(1e3 * printed.amplitude_in_text), round(100.0 * printed.reduction, 2)
    return next(
        (before, after)
        for before in range(text - 6, text + 7)
        for after in range(before)
        if round(100.0 * (1.0 - after / before), 2) == wanted
    )


def ramp_variants(printed: Printed) -> dict[str, Windows]:
    """Return the ramps with the stiffness, the damping, or both changed as required."""
    base = machines.calibrated_motor()
    stiff, damped = averages.required_changes(printed)
    more = {"stiffness": stiff * base.stiffness, "damping": damped * base.damping}
    changed: dict[str, BeamMotor] = {
        "stiffness": base.with_values({"stiffness": more["stiffness"]}),
        "damping": base.with_values({"damping": more["damping"]}),
        "both": base.with_values(more),
    }
    return {name: runs.run_upward(motor, wire.RATE, LAST) for name, motor in changed.items()}
