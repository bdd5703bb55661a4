"""The standard figure of a result: time series on the left, hysteresis loops on the right.

Figures are made with matplotlib's objects alone, without pyplot: nothing global is touched,
and no window or figure manager has to be closed.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly import System
from martensite.base import units
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.show.figures.bench import plot_bench
from martensite.show.figures.files import check_format, write_figure
from martensite.show.figures.hysteresis import LOOPS, draw_loops
from martensite.show.figures.labels import describe_axis
from martensite.show.figures.machine import draw_machine
from martensite.show.figures.record_overlays import MeasuredRecord, check_records, draw_key
from martensite.show.figures.style import HEATING, QUIET, make_figure, use_style
from martensite.show.figures.timeseries import draw_timeseries, list_panels
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, PANEL_HEIGHT = 12.0, 1.22
"""Width of the figure and height of one panel over time [inch]."""
HEAD, KEY, FOOT, LINE = 0.9, 0.22, 0.55, 0.18
"""Room for title, key of records, time axis, and each line of warnings [inch]."""
LEFT = 0.07
"""Left edge of the panels as a share of the width."""


def plot_result(
    result: Result,
    records: Iterable[MeasuredRecord] | None = None,
    title: str | None = None,
    outside: Mapping[str, AbstractController] | None = None,
) -> Figure:
    """The standard figure: all quantities over time, and the loops ξ–T, ε–T, σ–ε.

    Of a run on a bench it is that of `plot_bench`.

    Args:
        result: the run to show.
        records: measured records, drawn over the simulation wherever they have the same
            quantity, with the RMS difference in the legend.
        title: first line of the figure; by default what was simulated.
        outside: controllers that ran outside of a bench, by drive.

    Raises:
        DataError: a record holds nothing that can be compared with the result.
    """
    if result.variants is not None:
        with use_style():
            return _draw_batch(result, title)
    if isinstance(result.system, Bench):
        return plot_bench(result, records, title, outside)
    measured = check_records(result, records)
    with use_style():
        if not isinstance(result.system, System):
            return _draw_machine(result, title)
        return _make_figure(result, measured, title)


def save_figure(
    result: Result,
    path: str | os.PathLike[str],
    records: Iterable[MeasuredRecord] | None = None,
    title: str | None = None,
    outside: Mapping[str, AbstractController] | None = None,
) -> None:
    """Write the standard figure as png, svg or pdf; the file is replaced whole or not at all.

    Raises:
        DataError: the suffix is another one, the file cannot be written, or a record holds
            nothing that can be compared.
    """
    path = Path(path)
    check_format(path)
    write_figure(plot_result(result, records, title, outside), path)


def _make_figure(result: Result, records: Sequence[MeasuredRecord], title: str | None) -> Figure:
    names = list_panels(result, records)
    warnings = [line for text in result.warnings for line in textwrap.wrap(text, 165)]
    head = HEAD + (KEY if records else 0.0)
    foot = FOOT + LINE * len(warnings)
    height = head + foot + PANEL_HEIGHT * len(names)
    figure = make_figure(WIDTH, height)
    left, right = figure.add_gridspec(
        1,
        2,
        left=LEFT,
        right=0.985,
        top=1.0 - head / height,
        bottom=foot / height,
        width_ratios=(1.15, 1.0),
        wspace=0.17,
    )
    stack = left.subgridspec(len(names), 1, hspace=0.42)
    over_time = list(stack.subplots(sharex=True, squeeze=False)[:, 0])
    stack = right.subgridspec(len(LOOPS), 1, hspace=0.3)
    loops = list(stack.subplots(squeeze=False)[:, 0])
    draw_timeseries(over_time, result, names, records)
    draw_loops(loops, result, records)
    figure.align_ylabels(over_time)
    figure.align_ylabels(loops)
    if records:
        draw_key(figure, 0.02, 1.0 - (HEAD - 0.22) / height, records)
    _write_text(figure, result, title, warnings)
    return figure


def _draw_batch(result: Result, title: str | None) -> Figure:
    """Every column over time, with a line per variant."""
    import matplotlib

    names = list(result.columns)
    height = HEAD + FOOT + 2.0 * PANEL_HEIGHT * len(names)
    figure = make_figure(0.75 * WIDTH, height)
    grid = figure.add_gridspec(
        len(names),
        1,
        left=0.1,
        right=0.97,
        top=1.0 - HEAD / height,
        bottom=FOOT / height,
        hspace=0.3,
    )
    panels = list(grid.subplots(sharex=True, squeeze=False)[:, 0])
    colours: Any = matplotlib.colormaps["viridis"]
    for axes, name in zip(panels, names, strict=True):
        shown = describe_axis(result, name)
        lines = axes.plot(result.times, shown.values(result[name]).T, linewidth=1.0)
        for k, line in enumerate(lines):
            line.set_color(colours(k / max(len(lines) - 1, 1)))
        axes.set_title(shown.long_name)
        axes.set_ylabel(shown.label)
        axes.set_xlim(result.times[0], result.times[-1])
    panels[-1].set_xlabel(describe_axis(result, "time").label)
    _write_text(figure, result, title, [])
    return figure


def _draw_machine(result: Result, title: str | None) -> Figure:
    """Records of machines are compared in numbers only."""
    figure = draw_machine(result)
    _write_text(figure, result, title, [])
    return figure


def _write_text(figure: Any, result: Result, title: str | None, warnings: Sequence[str]) -> None:
    height = figure.get_figheight()
    top = title if title is not None else _make_title(result)
    plain = {"va": "center", "parse_math": False}
    figure.text(0.02, 1.0 - 0.26 / height, top, fontsize=12.5, fontweight="bold", **plain)
    figure.text(0.02, 1.0 - 0.49 / height, _write_lead(result), color=QUIET, **plain)
    for i, line in enumerate(reversed(warnings)):
        place = (0.16 + LINE * i) / height
        figure.text(0.02, place, line, color=HEATING, fontsize=8.0, **plain)


def _make_title(result: Result) -> str:
    text = result.system.description()
    return text[:1].upper() + text[1:]


def _write_lead(result: Result) -> str:
    if result.variants is not None:
        return f"{len(result.variants)} variants: {result.variants.count_endings()}"
    stroke = describe_axis(result, result.coordinate)
    factor, _ = units.find_conversion(stroke.shown, stroke.unit)
    parts = [
        f"stroke {result.stroke / factor:.3g} {stroke.difference_unit}",
        f"{result.steps:,} steps",
    ]
    if result.accuracy is not None:
        parts.append(f"accuracy {result.accuracy:.1e} of range")
    if result.status:
        when = "" if result.status_time is None else f" at t = {result.status_time:.4g} s"
        parts.append(f"status {result.status.name.lower().replace('_', ' ')}{when}")
    return "  ·  ".join(parts)
