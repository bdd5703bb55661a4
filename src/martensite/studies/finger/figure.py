"""The figure of the study."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from martensite.show.figures.labels import typeset_symbol
from martensite.show.figures.style import HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.studies.figures import add_right_axis, draw_page, label_axes
from martensite.studies.finger import bench, bending_numbers, crystal_numbers, loop_numbers
from martensite.studies.readings import ZERO
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (SIMULATED, HEATING, MEASURED[2])
DASHED = (0, (4, 1.6))


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure."""
    with draw_page(
        12.0,
        7.2,
        "Robotic finger: results of the published numbers",
        "quasi-static, power in the whole wire; positions of spring and brackets are assumed",
    ) as figure:
        left, right = figure.add_gridspec(
            1, 2, left=0.055, right=0.985, top=0.9, bottom=0.075, width_ratios=(1.0, 1.15), wspace=0.24
        )
        rows = left.subgridspec(3, 1, height_ratios=(1.0, 1.0, 0.55), hspace=0.28)
        first = figure.add_subplot(rows[0])
        panels = [first, figure.add_subplot(rows[1], sharex=first)]
        for axes, watts in zip(panels, printed.powers, strict=True):
            _draw_bending(axes, watts, printed)
        _draw_power(figure.add_subplot(rows[2], sharex=first), printed)
        panels[0].legend(loc="upper left")
        cells = right.subgridspec(2, 2, height_ratios=(1.15, 1.0), hspace=0.32, wspace=0.28)
        _draw_loop(figure.add_subplot(cells[0, :]), printed)
        _draw_crystals(figure.add_subplot(cells[1, 0]), printed)
        _draw_places(figure.add_subplot(cells[1, 1]), printed)
        return figure


def angle_degrees(result: Any) -> list[float]:
    """Return the angle of a run [°]."""
    return [math.degrees(angle) for angle in result["angle"]]


def _draw_bending(axes: Any, watts: float, printed: Printed) -> None:
    for r, colour in zip(printed.offsets, COLOURS, strict=True):
        run = bench.run_bending(watts, r, printed)
        axes.plot(run.times, angle_degrees(run), color=colour, label=f"r = {1e3 * r:.1f} mm")
        many = bench.run_bending(watts, r, printed, None, bench.POLYCRYSTAL)
        axes.plot(many.times, angle_degrees(many), color=colour, linestyle=DASHED, linewidth=0.9)
    axes.plot([], [], color=INK, linestyle=DASHED, linewidth=0.9, label="polycrystal")
    axes.set_title(f"angle at {watts:.1f} W")
    axes.set_ylabel(f"{typeset_symbol('θ')} [°]")
    axes.set_ylim(-4.0, 100.0)
    axes.tick_params(labelbottom=False)


def _draw_power(axes: Any, printed: Printed) -> None:
    warm = add_right_axis(axes, f"{typeset_symbol('T')} [°C]", 16.0, 104.0, HEATING)
    r = printed.offsets[1]
    for watts, style in zip(printed.powers, (DASHED, "solid"), strict=True):
        wave, run = bench.power_trapezoid(watts, printed), bench.run_bending(watts, r, printed)
        label = f"{watts:.1f} W"
        axes.plot(wave.times, wave.values, color=INK, linestyle=style, label=label, linewidth=1.1)
        celsius = [T - ZERO for T in run["temperature"]]
        warm.plot(run.times, celsius, color=HEATING, linestyle=style, linewidth=0.9)
    axes.set_xlim(0.0, 25.0)
    axes.set_ylim(-0.1, 2.2)
    label_axes(
        axes,
        f"power, and temperature of the wire at r = {1e3 * r:.1f} mm",
        f"{typeset_symbol('t')} [s]",
        f"{typeset_symbol('P')} [W]",
        "upper right",
    )


def _draw_loop(axes: Any, printed: Printed) -> None:
    frequency = printed.frequency
    looks = (
        (frequency, (), SIMULATED, "solid", f"{frequency:g} Hz"),
        (loop_numbers.SLOW * frequency, (), HEATING, "solid", f"{loop_numbers.SLOW * frequency:g} Hz"),
        (frequency, bench.STATIC, INK, DASHED, "no stored heat"),
    )
    for f, values, colour, style, label in looks:
        run = bench.run_loop(f, None, printed, values)
        half = len(run.times) // 2
        axes.plot(
            run["power"][half:],
            angle_degrees(run)[half:],
            color=colour,
            linestyle=style,
            label=f"{label}: {bench.loop_width(run):.2f} W",
        )
    label_axes(
        axes,
        f"calibration loop, {frequency:g} Hz, r = 1.5 mm: not quasi-stationary",
        f"{typeset_symbol('P')} [W]",
        f"{typeset_symbol('θ')} [°]",
    )
    axes.set_xlim(-0.1, 2.05)
    axes.legend(loc="center left", title="width", alignment="left")


def _draw_crystals(axes: Any, printed: Printed) -> None:
    powers, r = crystal_numbers.MIDDLE, printed.offsets[1]
    here = bench.build_finger().value_of("mechanism.arm")
    for arm, style in ((None, "solid"), (crystal_numbers.OUTER_ARM, DASHED)):
        for law, colour, name in ((bench.SINGLE, SIMULATED, "single"), (bench.POLYCRYSTAL, HEATING, "poly")):
            runs = [bench.run_bending(watts, r, printed, arm, law) for watts in powers]
            axes.plot(
                powers,
                [bench.top_angle(run, printed) for run in runs],
                color=colour,
                linestyle=style,
                marker="o",
                markersize=3.0,
                label=f"{name}, a = {1e3 * (arm or here):.0f} mm",
            )
    label_axes(
        axes, "single and polycrystal, 13 s, r = 3.5 mm", f"{typeset_symbol('P')} [W]", f"{typeset_symbol('θ')} [°]"
    )
    axes.set_ylim(-4.0, 82.0)
    axes.legend(loc="lower right", fontsize=7.0)


def _draw_places(axes: Any, printed: Printed) -> None:
    arms, low = bending_numbers.ARMS, min(printed.powers)
    for i, (r, colour) in enumerate(zip(printed.offsets, COLOURS, strict=True)):
        tops = [bending_numbers.top_angles(low, printed, arm)[i] for arm in arms]
        axes.plot([1e3 * arm for arm in arms], tops, color=colour, label=f"{1e3 * r:.1f} mm")
    here = 1e3 * bench.build_finger().value_of("mechanism.arm")
    axes.axvline(here, color=QUIET, linewidth=0.8, linestyle=DASHED)
    axes.set_title(f"at {low:.1f} W, over the spring's place")
    axes.set_xlabel(f"{typeset_symbol('a')} [mm]")
    axes.legend(loc="upper right", title="r")
