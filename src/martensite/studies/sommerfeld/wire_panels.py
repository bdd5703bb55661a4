"""Panels of the third row: the wire on the beam, and on its own test bench."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.show.figures.style import COOLING, HEATING, QUIET, SIMULATED
from martensite.studies.figures import add_right_axis, label_axes
from martensite.studies.readings import ZERO
from martensite.studies.sommerfeld import actuator, machines, wire
from martensite.studies.tables import Printed

SHOWN = 0.6
"""Duration of the drawn loops before the jump [s]."""


def draw_control(axes: Any, printed: Printed) -> None:
    """Draw temperature and current of the wire over the motor voltage."""
    run = wire.run_controlled(printed).result
    volts = np.asarray(run["motor"])
    axes.plot(volts, np.asarray(run["temperature"]) - ZERO, color=HEATING, linewidth=1.0, label="temperature (left)")
    axes.set_ylabel("$T$ [°C]", color=HEATING)
    axes.set_ylim(15.0, 115.0)
    other = add_right_axis(axes, "$I$ [A]", -0.05, 1.6, QUIET)
    other.plot(volts, run["current"], color=QUIET, linewidth=1.4, label="current of the wire (right)")
    handles = [*axes.get_lines(), *other.get_lines()]
    axes.legend(handles=handles, loc="upper right")
    axes.set_title("wire: on at 3 Hz, off at 30 % of the peak")
    axes.set_xlabel("motor voltage [V]")
    axes.set_xlim(0.0, 10.0)


def draw_loops(axes: Any, printed: Printed) -> None:
    """Draw tension of the wire over the displacement of the tip, shortly before the jump."""
    controlled = wire.run_controlled(printed)
    end = round(controlled.sweep.jump / wire.RATE / wire.PERIOD)
    part = slice(end - round(SHOWN / wire.PERIOD), end)
    x, force = (np.asarray(controlled.result[name])[part] for name in ("displacement", "force"))
    axes.plot(
        1e3 * x, force, linestyle="none", marker=".", markersize=2.8, color=SIMULATED, label="tension of the hot wire"
    )
    ends = np.array([0.0, x.max()])
    axes.plot(
        1e3 * ends,
        machines.calibrated_motor().stiffness * ends,
        color=COOLING,
        linewidth=0.9,
        linestyle=(0, (4, 1.5)),
        label="spring of the beam, $k x$",
    )
    axes.set_ylim(-2.5, 55.0)
    label_axes(
        axes,
        "last turns before the jump: slack, then a loop",
        "displacement of the tip [mm]",
        "force [N]",
        "upper left",
    )


def draw_bench(axes: Any, printed: Printed, name: str) -> None:
    """Draw recovered strain or current over time for all voltages."""
    import matplotlib as mpl

    colours = mpl.colormaps["viridis"]
    count = len(printed.heating_voltages)
    for k, volts in enumerate(printed.heating_voltages):
        run = actuator.run_heated(volts)
        column = np.asarray(run[name])
        curve = 100.0 * (column[0] - column) if name == "strain" else column
        axes.plot(run.times, curve, color=colours(0.92 - 0.92 * k / (count - 1)), linewidth=1.2, label=f"{volts:.1f} V")
    words = "strain recovered" if name == "strain" else "current"
    label_axes(
        axes,
        f"wire alone under 500 g, heated 60 s: {words}",
        "time [s]",
        "strain [%]" if name == "strain" else "$I$ [A]",
    )
    axes.set_xlim(0.0, actuator.LENGTH)
    if name == "current":
        axes.legend(loc="upper right", ncols=1, fontsize=7.0)
