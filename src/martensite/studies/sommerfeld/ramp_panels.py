"""Panels of the second row: the calibrated motor in a ramp, without and with the wire."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.show.figures.style import HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.signals.ramp import Ramp
from martensite.simulate.result import Result
from martensite.studies.figures import add_right_axis, label_axes
from martensite.studies.sommerfeld import machines, runs, wire
from martensite.studies.sommerfeld.runs import Windows
from martensite.studies.tables import Printed

WITHOUT, WITH = MEASURED[0], SIMULATED
DOTTED = (0, (1, 1.5))
HERTZ = 1.0 / (2.0 * np.pi)


def list_pairs(printed: Printed) -> tuple[tuple[Windows, str, str], ...]:
    """Return windows, label and colour of both ramps."""
    return (
        (wire.run_without_wire(printed), "without the wire", WITHOUT),
        (wire.run_controlled(printed).sweep, "with the wire", WITH),
    )


def draw_displacement(axes: Any, printed: Printed) -> None:
    """Draw extremes of the displacement over the rising voltage."""
    duration = printed.last_voltage / wire.RATE
    wave = Ramp(high=printed.last_voltage, end=duration)
    bare = runs.run_course(machines.calibrated_motor(), wave, duration)
    both = (bare, wire.run_controlled(printed).result)
    for run, (windows, label, colour) in zip(both, list_pairs(printed), strict=True):
        volts, low, high = _window_extremes(run)
        axes.fill_between(
            volts,
            1e3 * low,
            1e3 * high,
            color=colour,
            linewidth=0.0,
            alpha=0.55 if colour == WITHOUT else 0.8,
            label=f"{label}: jump at {windows.jump:.2f} V, amplitude {1e3 * windows.peak:.1f} mm",
        )
    for volts in (printed.jump, printed.jump_with_wire):
        axes.axvline(volts, color=INK, linestyle=DOTTED, linewidth=0.9)
        axes.text(
            volts + 0.05, -57.0, f"printed: {volts:g} V", fontsize=8.0, ha="left" if volts == printed.jump else "right"
        )
    axes.set_xlim(0.0, printed.last_voltage)
    axes.set_ylim(-62.0, 62.0)
    label_axes(
        axes,
        f"displacement of the tip in a ramp of {wire.RATE:g} V/s",
        "motor voltage [V]",
        "displacement [mm]",
        "upper right",
    )


def _window_extremes(run: Result) -> tuple[Any, Any, Any]:
    """Return the voltage, lowest and highest displacement [m] in each fifth of a second."""
    size = round(0.2 / (run.times[1] - run.times[0]))
    count = len(run.times) // size
    volts, x = (np.asarray(run[name][: count * size]).reshape(count, size) for name in ("motor", "displacement"))
    return volts.mean(axis=1), x.min(axis=1), x.max(axis=1)


def _over_voltage(axes: Any, printed: Printed, name: str, scale: float) -> None:
    for windows, label, colour in list_pairs(printed):
        axes.plot(windows.voltage, scale * getattr(windows, name), color=colour, linewidth=1.8, label=label)
    axes.set_xlabel("motor voltage [V]")
    axes.set_xlim(0.0, 10.0)


def draw_speed(axes: Any, printed: Printed) -> None:
    """Draw speed of the rotor over the voltage."""
    _over_voltage(axes, printed, "speed", HERTZ)
    axes.axhline(printed.measured_frequency, color=INK, linestyle=DOTTED, linewidth=0.9)
    words = f"printed: $f_n$ = {printed.measured_frequency:g} Hz"
    axes.text(6.8, printed.measured_frequency + 1.2, words, fontsize=8.0)
    axes.set_title("speed of the motor")
    axes.set_ylabel("speed of the rotor [Hz]")
    axes.set_ylim(0.0, 80.0)
    axes.legend(loc="upper left")


def draw_current(axes: Any, printed: Printed) -> None:
    """Draw current of the motor over the voltage."""
    _over_voltage(axes, printed, "current", 1.0)
    drop = wire.run_without_wire(printed).most_current - wire.run_controlled(printed).sweep.most_current
    axes.text(6.75, 0.62, f"peak lower by {drop:.2f} A\n(printed: about {printed.current_drop:g} A)", fontsize=8.0)
    axes.set_title("current of the motor, mean over 0.25 s")
    axes.set_ylabel("$i$ [A]")


def draw_fit(axes: Any, printed: Printed) -> None:
    """Draw jump voltage and reduction over the slack."""
    trials = wire.run_trials(printed)
    slacks = [100.0 * one.slack for one in trials]
    axes.plot(
        slacks, [one.jump for one in trials], marker="o", markersize=4.0, color=SIMULATED, label="jump voltage (left)"
    )
    axes.axhline(printed.jump_with_wire, color=SIMULATED, linestyle=DOTTED, linewidth=1.0)
    axes.set_ylabel("jump [V]", color=SIMULATED)
    axes.set_ylim(4.2, 6.2)
    other = add_right_axis(axes, "reduction [%]", 20.0, 60.0, HEATING)
    other.plot(
        slacks,
        [100.0 * one.reduction for one in trials],
        marker="s",
        markersize=4.0,
        color=HEATING,
        label="reduction of the amplitude (right)",
    )
    other.axhline(100.0 * printed.reduction, color=HEATING, linestyle=DOTTED, linewidth=1.0)
    axes.axvline(100.0 * wire.best_trial(printed).slack, color=QUIET, linewidth=0.8)
    handles = [*axes.get_lines()[:1], *other.get_lines()[:1]]
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.55, 0.0))
    axes.set_title("fit of the wire's slack (calibrated motor, ramp)")
    axes.set_xlabel("slack of the hot wire [%]")
