"""The standard figure of a machine, with one colour per actuator.

Left, over time: the coordinates, then drives and states of the elements. Right: the loops ξ-T and σ-ε of all elements,
and the path of the mechanism: its first coordinate over the second, or over the temperature of the first element if
there is only one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.labels import QuantityAxis, choose_limits, describe_axis, read_column
from martensite.show.figures.panels import add_colour_key, add_panels, draw_start
from martensite.show.figures.style import INK, make_figure
from martensite.simulate.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, PANEL_HEIGHT = 12.0, 1.3
HEAD, FOOT = 1.0, 0.6
COLOURS = ("#1f5f8b", "#d55e00", "#5a8f7b", "#8a6fa8", "#b0783c", "#6f6f6f")
"""Colours of actuators and coordinates; more lines use a colour map."""
PANELS = ("drive", "temperature", "martensite_fraction", "force")
LOOPS = (("temperature", "martensite_fraction"), ("strain", "stress"))


def draw_machine(result: Result) -> Figure:
    """Return the panels of a machine, with the key of its actuators but no title."""
    ports, own = list(result.system.actuators()), _group_outputs(result)
    rows = len(own) + (len(PANELS) if ports else 0)
    height = HEAD + FOOT + PANEL_HEIGHT * max(rows, 3)
    figure = make_figure(WIDTH, height)
    over_time = add_panels(figure, rows, 1, (0.84, 5.44, HEAD, FOOT), (0.0, 0.38), sharex=True)[:, 0]
    for axes, names in zip(over_time, own, strict=False):
        _draw_lines(axes, result, names, list(names), choose_colours(len(names)))
        if len(names) > 1:
            axes.legend(loc="upper right", ncols=len(names))
    for axes, name in zip(over_time[len(own) :], PANELS, strict=False):
        columns = [result.system.label(port, name) for port in ports]
        _draw_lines(axes, result, columns, ports, choose_colours(len(ports)))
    over_time[-1].set_xlabel(describe_axis(result, "time").label)
    loops = LOOPS if ports else ()
    spots = add_panels(figure, len(loops) + 1, 1, (7.42, 0.18, HEAD, FOOT), (0.0, 0.69))[:, 0]
    for axes, (x, y) in zip(spots, loops, strict=False):
        _draw_loops(axes, result, ports, x, y)
    _draw_path(spots[-1], result)
    figure.align_ylabels(list(over_time))
    figure.align_ylabels(list(spots))
    add_colour_key(figure, dict(zip(ports, choose_colours(len(ports)), strict=True)))
    return figure


def choose_colours(count: int) -> list[Any]:
    """Return one colour for each of `count` lines."""
    if count <= len(COLOURS):
        return list(COLOURS[:count])
    from matplotlib import colormaps

    return [colormaps["turbo"](x) for x in np.linspace(0.05, 0.95, count)]


def choose_width(i: int, count: int) -> float:
    """Return the width of line `i` of `count`: later lines are thinner, so that earlier ones remain visible."""
    return 1.0 + 1.2 * (1.0 - (i + 1) / count)


def _group_outputs(result: Result) -> list[list[str]]:
    table: dict[str, list[str]] = {}
    for name, (unit, _, _) in result.system.of_mechanism().items():
        table.setdefault(unit, []).append(name)
    return list(table.values())


def _draw_lines(axes: Any, result: Result, columns: Sequence[str], labels: Sequence[str], tints: Sequence[Any]) -> None:
    axis = describe_axis(result, columns[0])
    for i, (name, label) in enumerate(zip(columns, labels, strict=True)):
        look = {"color": tints[i], "linewidth": choose_width(i, len(columns))}
        axes.plot(result.times, read_column(result, name), label=label, **look)
    axes.set(title=_write_label(axis, len(columns)), ylabel=axis.label, xlim=(result.times[0], result.times[-1]))
    axes.set(ylim=choose_limits(columns[0], *(read_column(result, name) for name in columns)))
    axes.locator_params(axis="y", nbins=4)


def _write_label(axis: QuantityAxis, count: int) -> str:
    """Return the label of a panel, without the name of the port or of one of several coordinates."""
    words = axis.long_name.partition(", ")[0]
    return words if count == 1 or "." in axis.name else f"{words} and others"


def _draw_loops(axes: Any, result: Result, ports: Sequence[str], x: str, y: str) -> None:
    names = [(result.system.label(p, x), result.system.label(p, y)) for p in ports]
    for i, ((across, up), tint) in enumerate(zip(names, choose_colours(len(ports)), strict=True)):
        look = {"color": tint, "linewidth": choose_width(i, len(ports))}
        axes.plot(read_column(result, across), read_column(result, up), **look)
    for across, up in names:
        draw_start(axes, read_column(result, across), read_column(result, up))
    for k, which in enumerate("xy"):
        limits = choose_limits(names[0][k], *(read_column(result, pair[k]) for pair in names))
        label = describe_axis(result, names[0][k]).label
        axes.set(**{f"{which}lim": limits, f"{which}label": label})


def _draw_path(axes: Any, result: Result) -> None:
    first, *others = result.system.of_mechanism()
    ports = list(result.system.actuators())
    across = others[0] if others or not ports else result.system.label(ports[0], "temperature")
    x, y = read_column(result, across), read_column(result, first)
    axes.plot(x, y, color=INK, linewidth=1.1)
    draw_start(axes, x, y)
    axes.set(xlabel=describe_axis(result, across).label, ylabel=describe_axis(result, first).label)
