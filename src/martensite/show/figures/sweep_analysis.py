"""Figures of a sweep's Pareto front with some of its designs, and of sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.design.sweep.indices import SensitivityIndices
from martensite.design.sweep.pareto import ParetoFront
from martensite.design.sweep.table import SweepTable, shorten_names
from martensite.show.figures.panels import make_panels, write_suptitle
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, MEASURED, QUIET, make_figure, use_style
from martensite.show.figures.sweep import arrange_panels, label_column, write_sweep_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMED = 6
"""Number of designs in the table."""
MOST_POINTS = 20_000
PANEL, CELL, TABLE = 3.6, 1.15, 1.9
"""Width of a panel, width of a table column, and height of the table [inch]."""
MOST_PAIRS = 6
COLOURS = {"first": COOLING, "total": HEATING, "delta": MEASURED[2], "rank slope": MEASURED[0]}
"""Colours of the drawn indices."""
WIDTH, BAR, HEAD = 4.2, 0.19, 1.0
MOST_BARS = 10
"""Largest number of parameters in a panel."""


def plot_pareto(table: SweepTable, front: ParetoFront, title: str = "") -> Figure:
    """Draw a front in each pair of its goals.

    Args:
        table: the runs.
        front: from `find_pareto_front`.
        title: headline; by default the title of the sweep.
    """
    pairs = list(combinations(range(len(front.goals)), 2))[:MOST_PAIRS] or [(0, 0)]
    rows, columns = arrange_panels(len(pairs))
    width = max(PANEL * columns, CELL * (len(table.varied) + len(front.goals) + 1), 5.5)
    with use_style():
        figure = make_figure(width, 2.9 * rows + TABLE)
        figure.set_layout_engine("constrained")
        parts: Any = figure.subfigures(2, 1, height_ratios=(2.9 * rows, TABLE))
        upper, lower = parts
        panels = upper.subplots(rows, columns, squeeze=False).ravel()
        named = _choose_named(front)
        for panel, pair in zip(panels, pairs, strict=False):
            _draw_pair(panel, table, front, pair, named)
        for panel in panels[len(pairs) :]:
            panel.set_axis_off()
        panels[0].legend(loc="best")
        write_suptitle(upper, title or write_sweep_title(table))
        _tabulate_designs(lower, table, front, named)
    return figure


def _choose_named(front: ParetoFront) -> list[int]:
    """Return distant runs of the front for the table, including both ends."""
    goals = np.stack([one.values[front.runs] for one in front.goals], axis=1)
    goals = (goals - goals.min(axis=0)) / np.maximum(np.ptp(goals, axis=0), 1e-300)
    chosen = [0]
    apart = np.linalg.norm(goals - goals[0], axis=1)
    while len(chosen) < min(NAMED, len(goals)) and apart.max() > 0.0:
        chosen.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.linalg.norm(goals - goals[chosen[-1]], axis=1))
    return [int(front.runs[k]) for k in sorted(chosen)]


def _draw_pair(axes: Axes, table: SweepTable, front: ParetoFront, pair: tuple[int, int], named: list[int]) -> None:
    from matplotlib.patheffects import withStroke

    a, b = (front.goals[k] for k in pair)
    x, y = a.readable(), b.readable()
    usable = np.flatnonzero(table.good & np.isfinite(x) & np.isfinite(y))
    if len(usable) > MOST_POINTS:
        usable = np.random.default_rng(0).choice(usable, MOST_POINTS, replace=False)
    axes.plot(x[usable], y[usable], ".", label="runs", color=QUIET, alpha=0.45, ms=3.0, mew=0.0, rasterized=True)
    line = {"color": HEATING, "lw": 0.8, "marker": "o", "ms": 3.5}
    line["ls"] = "-" if len(front.goals) == 2 else "none"
    axes.plot(x[front.runs], y[front.runs], label=f"front ({len(front.runs):,})", **line)
    halo = withStroke(linewidth=2.0, foreground="white")
    axes.plot(x[named], y[named], "o", color=INK, ms=4.0, zorder=3.0)
    for letter, run in zip(ascii_uppercase, named, strict=False):
        look = {"color": INK, "fontweight": "bold", "fontsize": 8.0, "path_effects": [halo]}
        axes.annotate(letter, (x[run], y[run]), (4.0, 4.0), textcoords="offset points", **look)
    aims = ["max" if front.most[k] else "min" for k in pair]
    axes.set(xlabel=f"{label_column(a)}, {aims[0]}", ylabel=f"{label_column(b)}, {aims[1]}")


def _tabulate_designs(figure: Any, sweep_table: SweepTable, front: ParetoFront, named: list[int]) -> None:
    columns = front.columns(sweep_table)
    short = shorten_names(list(sweep_table.varied))
    axes = figure.subplots()
    axes.set_axis_off()
    heads = ["run", *(label_column(one, short.get(name, name)) for name, one in columns.items())]
    cells = [
        [f"{letter}   {run}", *(f"{float(c.readable(c.values[run])):.4g}" for c in columns.values())]
        for letter, run in zip(ascii_uppercase, named, strict=False)
    ]
    table = axes.table(cells, colLabels=heads, loc="upper center", edges="horizontal")
    table.auto_set_font_size(False)
    table.set_fontsize(7.5)
    table.auto_set_column_width(list(range(len(heads))))
    for cell in table.get_celld().values():
        cell.set(edgecolor=FAINT)
        cell.get_text().set_parse_math(False)


def plot_sensitivity(indices: Sequence[SensitivityIndices], title: str = "") -> Figure:
    """Draw the sensitivities of measures, one panel each, the most important parameter on top."""
    rows, columns = arrange_panels(len(indices))
    kinds = [kind for kind in COLOURS if any(kind in one.indices for one in indices)]
    names = min(max(len(one.names) for one in indices), MOST_BARS)
    height = names * (BAR * len(kinds) + 0.12) + HEAD
    with use_style():
        width = WIDTH * max(columns, 1.2)
        figure, panels = make_panels(width, rows * height + 0.4, rows, columns, title)
        panels = panels.ravel()
        for panel, one in zip(panels, indices, strict=False):
            _draw_bars(panel, one, kinds)
        for panel in panels[len(indices) :]:
            panel.set_axis_off()
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=len(kinds))
    return figure


def _draw_bars(axes: Axes, one: SensitivityIndices, kinds: list[str]) -> None:
    order = one.order[:MOST_BARS]
    names = shorten_names(list(one.names))
    places = np.arange(len(order))
    for k, kind in enumerate(kinds):
        index = one.indices.get(kind)
        if index is None:
            continue
        at = places + (k - 0.5 * (len(kinds) - 1)) * 0.8 / len(kinds)
        values, wide = index.values[order], index.wide[order]
        axes.barh(at, np.nan_to_num(values), 0.8 / len(kinds), color=COLOURS[kind], label=kind)
        finite = np.isfinite(wide) & np.isfinite(values)
        axes.errorbar(values[finite], at[finite], xerr=wide[finite], ls="", ecolor=INK, elinewidth=0.8, capsize=2)
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.set_yticks(places, [names[one.names[k]] for k in order])
    axes.invert_yaxis()
    axes.set_xlim(*_find_ends(one))
    axes.grid(visible=False, axis="y")
    title = one.measure if one.deviation else f"{one.measure} (always the same)"
    axes.set_title(title, fontweight="bold").set_parse_math(False)


def _find_ends(one: SensitivityIndices) -> tuple[float, float]:
    indices = [index for kind, index in one.indices.items() if kind in COLOURS]
    halves = [np.nan_to_num(index.wide) for index in indices]
    values = [np.nan_to_num(index.values) for index in indices]
    low = min(float(np.min(v - w)) for v, w in zip(values, halves, strict=True))
    high = max(float(np.max(v + w)) for v, w in zip(values, halves, strict=True))
    return 1.05 * min(low, -0.02), max(1.05, 1.02 * high)
