"""The standard figure of a result: time series on the left, hysteresis loops on the right.

Of an element that differs along itself, temperature and fraction over time are maps beside it.

Figures are made with matplotlib's objects alone, without pyplot: nothing global is touched,
and no window or figure manager has to be closed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import PROFILES, System
from martensite.base import units
from martensite.base.errors import InputError
from martensite.base.formats import typeset_unit
from martensite.control.loop.bench import Bench
from martensite.show.figures.bench import plot_bench
from martensite.show.figures.hysteresis import LOOPS, draw_loops
from martensite.show.figures.labels import choose_limits, describe_axis, read_column, typeset_symbol
from martensite.show.figures.machine import draw_machine
from martensite.show.figures.panels import (
    WARNING_LINE,
    add_colour_bar,
    add_legend_above,
    add_panels,
    make_panels,
    wrap_warnings,
    write_headline,
)
from martensite.show.figures.record_overlays import (
    MeasuredRecord,
    Outside,
    Records,
    check_records,
    draw_key,
    draw_overlays,
    find_overlays,
    list_recorded,
)
from martensite.show.figures.style import SIMULATED, check_format, make_figure, use_style, write_figure
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, PANEL_HEIGHT = 12.0, 1.22
"""Width of the figure and height of one panel over time [inch]."""
HEAD, KEY, FOOT = 0.9, 0.22, 0.55
"""Room for title, key of records, and time axis [inch]."""
PANELS = ("drive", "temperature", "martensite_fraction", "strain", "stress", "mechanism", "resistance")
"""Quantities shown of every result, from top to bottom; all that the mechanism has for itself."""
COLOURS = {"cell_temperature": "inferno", "cell_fraction": "cividis"}


def plot_result(result: Result, records: Records = None, title: str | None = None, outside: Outside = None) -> Figure:
    """Return the standard figure: all quantities over time, and the loops ξ–T, ε–T, σ–ε.

    Of a run on a bench it is that of `plot_bench`.

    Args:
        result: the run to show.
        records: measured records, drawn over the simulation wherever they have the same
            quantity, with the RMS difference in the legend.
        title: first line of the figure; by default what was simulated.
        outside: controllers that ran outside of a bench, by drive.
    """
    if result.variants is not None:
        with use_style():
            return _draw_batch(result, title)
    if isinstance(result.system, Bench):
        return plot_bench(result, records, title, outside)
    measured = check_records(result, records)
    with use_style():
        if not isinstance(result.system, System):
            figure = draw_machine(result)  # records of machines are compared in numbers only
            _write_text(figure, result, title)
            return figure
        return _make_figure(result, measured, title)


def save_figure(
    result: Result,
    path: str | os.PathLike[str],
    records: Records = None,
    title: str | None = None,
    outside: Outside = None,
) -> None:
    """Write the standard figure as png, svg or pdf; the file is replaced whole or not at all."""
    path = Path(path)
    check_format(path)
    write_figure(plot_result(result, records, title, outside), path)


def _make_figure(result: Result, records: Sequence[MeasuredRecord], title: str | None) -> Figure:
    names = list_panels(result, records)
    warnings = wrap_warnings(result.warnings, WIDTH)
    head = HEAD + (KEY if records else 0.0)
    foot = FOOT + WARNING_LINE * len(warnings)
    figure = make_figure(WIDTH, head + foot + PANEL_HEIGHT * len(names))
    room = (0.84, 5.75, head, foot)
    over_time = list(add_panels(figure, len(names), 1, room, (0.0, 0.36), sharex=True)[:, 0])
    loops = list(add_panels(figure, len(LOOPS), 1, (7.11, 0.18, head, foot))[:, 0])
    draw_timeseries(over_time, result, names, records)
    draw_loops(loops, result, records)
    figure.align_ylabels(over_time)
    figure.align_ylabels(loops)
    if records:
        draw_key(figure, records, below=HEAD - 0.22)
    _write_text(figure, result, title, warnings)
    return figure


def _draw_batch(result: Result, title: str | None) -> Figure:
    import matplotlib

    names = list(result.columns)
    figure = make_figure(0.75 * WIDTH, HEAD + FOOT + 2.0 * PANEL_HEIGHT * len(names))
    room = (0.9, 0.27, HEAD, FOOT)
    panels = add_panels(figure, len(names), 1, room, (0.0, 0.56), sharex=True)[:, 0]
    colours: Any = matplotlib.colormaps["viridis"]
    for axes, name in zip(panels, names, strict=True):
        axis = describe_axis(result, name)
        lines = axes.plot(result.times, axis.values(result[name]).T, linewidth=1.0)
        for k, line in enumerate(lines):
            line.set_color(colours(k / max(len(lines) - 1, 1)))
        axes.set(title=axis.long_name, ylabel=axis.label, xlim=(result.times[0], result.times[-1]))
    panels[-1].set_xlabel(describe_axis(result, "time").label)
    _write_text(figure, result, title)
    return figure


def _write_text(figure: Figure, result: Result, title: str | None, warnings: Sequence[str] = ()) -> None:
    described = result.system.description()
    top = described[:1].upper() + described[1:] if title is None else title
    write_headline(figure, top, _write_lead(result), warnings)


def _write_lead(result: Result) -> str:
    if result.variants is not None:
        return f"{len(result.variants)} variants: {result.variants.count_endings()}"
    stroke = describe_axis(result, result.coordinate)
    factor, _ = units.find_conversion(stroke.display_unit, stroke.unit)
    parts = [f"stroke {result.stroke / factor:.3g} {stroke.difference_unit}", f"{result.steps:,} steps"]
    if result.accuracy is not None:
        parts.append(f"accuracy {result.accuracy:.1e} of range")
    if result.status:
        when = "" if result.status_time is None else f" at t = {result.status_time:.4g} s"
        parts.append(f"status {result.status.name.lower().replace('_', ' ')}{when}")
    return "  ·  ".join(parts)


def list_panels(result: Result, records: Sequence[MeasuredRecord] = ()) -> list[str]:
    """Return the quantities to show: the usual ones, and others that were measured.

    A drive that prescribes the temperature is the temperature, and is not shown twice.
    """
    (actuator,) = result.system.actuators().values()
    twice = actuator.source.sets_temperature
    several = {"mechanism": list(result.system.of_mechanism())}
    if "rphase_fraction" in result.columns:
        several["martensite_fraction"] = ["martensite_fraction", "rphase_fraction"]
    usual = [panel for name in PANELS if not (twice and name == "drive") for panel in several.get(name, [name])]
    return usual + [name for name in list_recorded(result, records) if name not in usual]


def draw_timeseries(
    panels: Sequence[Any], result: Result, names: Sequence[str], records: Sequence[MeasuredRecord] = ()
) -> None:
    """Draw one quantity per axes, measured records over it; only the last names the time."""
    fine = add_step_rows(result)
    for axes, name in zip(panels, names, strict=True):
        draw_panel(axes, fine, name, records)
    panels[-1].set_xlabel(describe_axis(result, "time").label)


def draw_panel(axes: Any, result: Result, name: str, records: Sequence[MeasuredRecord] = ()) -> None:
    """Draw one quantity over time [s]."""
    axis, values = describe_axis(result, name), read_column(result, name)
    overlays = find_overlays(result, records, name)
    axes.plot(result.times, values, color=SIMULATED, label="_simulated", zorder=2.2)
    draw_overlays(axes, axis, overlays)
    axes.set(title=axis.long_name, ylabel=axis.label, xlim=(result.times[0], result.times[-1]))
    axes.set(ylim=choose_limits(name, values, *(overlay.values for overlay in overlays)))
    axes.locator_params(axis="y", nbins=4)
    add_legend_above(axes)


def plot_profile(result: Result, title: str | None = None) -> Figure:
    """Return the temperature and martensite fraction of every cell over time, as two maps.

    Raises:
        InputError: the element of the result is the same all over.
    """
    elements = [one.element for one in result.system.actuators().values()]
    if not result.profiles:
        names = ", ".join(f"`{element.registered_name}`" for element in elements) or "none"
        raise InputError(
            f"There is no profile to draw of the elements of this run ({names}). "
            "A single `axial-wire` or `ribbon` has one."
        )
    with use_style():
        headline = title or f"Profile of a simulated {elements[0].registered_name}"
        figure, (panels,) = make_panels(10.0, 3.6, 1, len(PROFILES), headline, sharex=True, sharey=True)
        for panel, name in zip(panels, PROFILES, strict=True):
            _draw_map(figure, panel, result, name)
        panels[0].set_ylabel(f"{typeset_symbol('y')} [mm]")
        return figure


def _draw_map(figure: Any, panel: Any, result: Result, name: str) -> None:
    unit, long_name, symbol = PROFILES[name]
    display_unit = units.choose_readable_unit(unit)
    factor, offset = units.find_conversion(display_unit, unit)
    values = (np.asarray(result.profiles[name]) - offset) / factor
    low, high = (0.0, 1.0) if unit == "1" else (None, None)
    (actuator,) = result.system.actuators().values()
    places = 1e3 * np.asarray(actuator.element.places())
    look = {"cmap": COLOURS[name], "vmin": low, "vmax": high, "rasterized": True}
    mesh = panel.pcolormesh(np.asarray(result.times), places, values, shading="nearest", **look)
    label = f"{typeset_symbol(symbol)} [{typeset_unit(display_unit, '–')}]"
    add_colour_bar(figure, mesh, panel, label)
    panel.set(title=long_name, xlabel=f"{typeset_symbol('t')} [s]")
    panel.grid(False)
