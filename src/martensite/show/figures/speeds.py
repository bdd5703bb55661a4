"""The figure of speeds: courses of the output, times of rise and fall, largest rates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.design.analysis.speed import Speeds
from martensite.show.figures.labels import label_difference
from martensite.show.figures.machine import choose_colours
from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, HEATING, QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 10.0, 3.4
DASHES: tuple[Any, ...] = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
"""Loads, in their order; then again."""


def plot_speeds(found: Speeds, title: str = "") -> Figure:
    """Draw steps up and down again, and how fast they were.

    Args:
        found: of `speeds`.
        title: headline; by default what was asked.
    """
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        ((course, times, rates),) = add_panels(figure, 1, 3, (0.6, 0.15, 0.71, 0.51))
        write_headline(figure, title or f"Steps of {found.drive}: heating against cooling")
        _draw_courses(course, found)
        unit, size = label_difference(found.units[1])
        _draw_both(times, found, found.rise, found.fall)
        times.set_title("time to 90 % of the way [s]")
        _draw_both(rates, found, found.fastest_up / size, found.fastest_down / size)
        rates.set_title(f"largest rate [{unit}/s]")
        for axes in (times, rates):
            axes.set_xlabel(_label_axis(found.drive, found.units[0]))
            axes.set_ylim(0.0, 1.06 * axes.get_ylim()[1])
        figure.legend(
            *times.get_legend_handles_labels(),
            loc="upper right",
            bbox_to_anchor=(0.99, 1.0),
            ncols=min(len(found.loads), 6),
            columnspacing=1.4,
        )
        return figure


def _draw_courses(axes: Any, found: Speeds) -> None:
    """The output over time; colours are signals, dashes loads."""
    unit, size = label_difference(found.units[1])
    drive = units.choose_readable_unit(found.units[0])
    for rows, dash, load in _list_loads(found, found.courses):
        for row, signal, tint in zip(rows, found.signals, choose_colours(len(found.signals)), strict=True):
            word = f"{units.from_si(float(signal), drive, found.units[0]):.3g}"
            first = load == 0
            label = word if first else "_nolegend_"
            axes.plot(found.times, (row - row[0]) / size, color=tint, linestyle=dash, label=label)
    axes.axvline(found.hold, color=QUIET, linewidth=0.7, zorder=1.0)
    axes.set_title(f"{found.output.replace('_', ' ')} [{unit}]")
    axes.set_xlabel("$t$ [s]")
    axes.set_xlim(0.0, found.times[-1])
    axes.legend(title=_label_axis(found.drive, found.units[0]), title_fontsize=8.0, loc="upper right")


def _draw_both(axes: Any, found: Speeds, up: Any, down: Any) -> None:
    """Heating and cooling over the signal; dashes are loads."""
    shown = units.choose_readable_unit(found.units[0])
    signals = [units.from_si(float(one), shown, found.units[0]) for one in found.signals]
    pairs = zip(_list_loads(found, up), _list_loads(found, down), strict=True)
    for (heat, dash, load), (cool, _, _) in pairs:
        for row, tint, word in ((heat, HEATING, "heating"), (cool, COOLING, "cooling")):
            finite = np.where(np.isfinite(row), row, np.nan)
            label = f"{word}{_name_load(found, load)}"
            axes.plot(signals, finite, ".", color=tint, linestyle=dash, label=label)


def _list_loads(found: Speeds, table: Any) -> list[tuple[Any, Any, int]]:
    """Rows of a table by load, with the dashes of each."""
    return [(table[k], DASHES[k % len(DASHES)], k) for k in range(len(found.loads))]


def _name_load(found: Speeds, k: int) -> str:
    """What a load is called."""
    if not found.load:
        return ""
    return f", {found.load.rpartition('.')[2]} {found.loads[k]:.3g}"


def _label_axis(name: str, unit: str) -> str:
    """A drive with its unit."""
    shown = units.choose_readable_unit(unit)
    return name if shown == "1" else f"{name} [{ {'degC': '°C'}.get(shown, shown) }]"
