"""Panels of the first row: the motor of Table 3 at constant and at slowly changing voltages."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.show.figures.style import COOLING, HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.studies.figures import label_axes
from martensite.studies.sommerfeld import averages, beam_numbers, machines, runs
from martensite.studies.sommerfeld.runs import SettledRun
from martensite.studies.tables import Printed

FORMS = (("printed", "(3.15) as printed", MEASURED[1], "s"), ("lagrange", "derived signs", SIMULATED, "o"))
COARSE = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
FINE = tuple(round(6.0 + 0.1 * k, 10) for k in range(1, 10))
HERTZ = 1.0 / (2.0 * np.pi)


def run_settled(printed: Printed, form: str) -> list[SettledRun]:
    """Return the runs from rest at all drawn voltages."""
    motor = machines.printed_motor(printed, form)
    return [runs.from_rest(motor, volts) for volts in sorted({*COARSE, *FINE})]


def _draw_dots(axes: Any, printed: Printed, name: str, scale: float) -> None:
    for form, label, colour, marker in FORMS:
        runs_at_rest = run_settled(printed, form)
        axes.plot(
            [one.voltage for one in runs_at_rest],
            [scale * getattr(one, name) for one in runs_at_rest],
            marker=marker,
            markersize=4.0 if form == "printed" else 2.6,
            linestyle="none",
            color=colour,
            label=label,
            alpha=0.9,
        )
    axes.axvline(printed.simulated_jump, color=INK, linestyle=(0, (1, 1.5)), linewidth=0.9)
    axes.set_xlabel("voltage, constant from rest [V]")
    axes.set_xlim(0.0, 10.3)


def draw_amplitude(axes: Any, printed: Printed) -> None:
    """Draw amplitude after 25 s over the voltage."""
    _draw_dots(axes, printed, "amplitude", 1e3)
    axes.set_title("jump: amplitude after 25 s at one voltage")
    axes.set_ylabel("amplitude [mm]")
    axes.text(printed.simulated_jump + 0.15, 36.0, f"printed: {printed.simulated_jump:g} V", fontsize=8.0)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.12))


def draw_speed(axes: Any, printed: Printed) -> None:
    """Draw speed after 25 s over the voltage."""
    motor = machines.printed_motor(printed)
    _draw_dots(axes, printed, "speed", HERTZ)
    natural = HERTZ * machines.natural_frequency(motor)
    axes.axhline(natural, color=QUIET, linewidth=0.8)
    axes.text(7.0, natural + 1.0, f"$\\sqrt{{k/M}}/2π$ = {natural:.2f} Hz", fontsize=8.0, color=QUIET)
    volts = np.array([0.0, 10.3])
    axes.plot(volts, HERTZ * volts / motor.back_emf, color=QUIET, linestyle=(0, (4, 1.5)))
    axes.text(1.6, 26.0, "$V/K_B$", fontsize=8.0, color=QUIET)
    slow = motor.resistance * motor.rotor_inertia / motor.back_emf**2
    axes.text(5.6, 24.0, f"free: still gaining speed,\n$R J/K^2$ = {slow:.0f} s", fontsize=8.0, color=QUIET)
    axes.set_title("plateau: speed after 25 s at one voltage")
    axes.set_ylabel("speed of the rotor [Hz]")
    axes.set_ylim(0.0, 80.0)


def draw_folds(axes: Any, printed: Printed) -> None:
    """Draw steady states over the voltage, and slow sweeps up and down."""
    motor = machines.printed_motor(printed)
    upper, lower = averages.find_folds(motor)
    speeds = np.concatenate([np.linspace(15.0, 90.0, 6000), np.linspace(90.0, 4300.0, 2000)[1:]])
    volts = np.array([averages.voltage_at(motor, w) for w in speeds.tolist()])
    for part, dashes in (
        (speeds <= upper.speed, "-"),
        ((speeds >= upper.speed) & (speeds <= lower.speed), (0, (2, 1.5))),
        (speeds >= lower.speed, "-"),
    ):
        label = "averaged steady states" if part[0] else None
        axes.plot(volts[part], HERTZ * speeds[part], color=INK, linestyle=dashes, linewidth=1.0, label=label)
    up = runs.run_upward(motor, *beam_numbers.UP)
    down = runs.run_downward(motor, *beam_numbers.DOWN)
    for sweep, colour, label in ((up, HEATING, "ramp up"), (down, COOLING, "ramp down")):
        axes.plot(sweep.voltage, HERTZ * sweep.speed, color=colour, linewidth=2.2, alpha=0.6, label=label)
    for fold, below in ((upper, False), (lower, True)):
        axes.plot(fold.voltage, HERTZ * fold.speed, "o", color=INK, markersize=4.5, zorder=4)
        axes.annotate(
            f"{fold.voltage:.3g} V",
            (fold.voltage, HERTZ * fold.speed),
            xytext=(8, -12) if below else (-4, -12),
            textcoords="offset points",
            fontsize=8.0,
            ha="left" if below else "right",
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(0.5, 110.0)
    axes.set_ylim(4.0, 700.0)
    label_axes(
        axes, "hysteresis of slow changes: no jump at 6.6 V", "voltage [V]", "speed of the rotor [Hz]", "upper left"
    )
