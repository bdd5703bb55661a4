"""The figure of a sweep: measures over one varied number, maps over two, or a matrix of scatter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.status import Status
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.search.given_data_indices import is_spread
from martensite.show.figures.panels import add_colour_bar, write_suptitle
from martensite.show.figures.style import FAINT, HEATING, QUIET, SIMULATED, make_figure, use_style
from martensite.show.figures.sweep_labels import (
    arrange_panels,
    label_column,
    label_varied,
    set_scales,
    write_sweep_title,
)
from martensite.show.figures.sweep_scatter import draw_matrix, measure_matrix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 6
"""Measures in a figure."""
PANEL = 3.4, 2.7
"""Width and height of a panel [inch]."""
MAP = "viridis"


def plot_sweep(found: SweepTable, measures: Sequence[str] | None = None, title: str = "") -> Figure:
    """Draw what a sweep found.

    One varied number: measures over it. Two: a map of each measure. More: a matrix of scatter of
    all varied numbers, coloured by the first measure, which is also drawn over each.

    Args:
        found: the runs.
        measures: some of them, by their words; by default the first six.
        title: headline; by default that of the sweep.

    Raises:
        UnknownNameError: there is no such measure.
        DataError: only traces were kept.
    """
    chosen = found.chosen(None if measures is None else list(measures))[:MOST]
    many = len(found.varied) > 2
    with use_style():
        size = measure_matrix(found) if many else _choose_size(len(chosen))
        figure = make_figure(*size)
        figure.set_layout_engine("constrained")
        if many:
            draw_matrix(figure, found, chosen[0])
        else:
            _draw_panels(figure, found, chosen)
        write_suptitle(figure, title or write_sweep_title(found))
    return figure


def _choose_size(count: int) -> tuple[float, float]:
    rows, columns = arrange_panels(count)
    return PANEL[0] * max(columns, 1.3), PANEL[1] * rows + 0.3


def _draw_panels(figure: Figure, found: SweepTable, chosen: list[SweepColumn]) -> None:
    panels = figure.subplots(*arrange_panels(len(chosen)), squeeze=False).ravel()
    draw = _draw_over_one if len(found.varied) == 1 else _draw_over_two
    for panel, one in zip(panels, chosen, strict=False):
        draw(panel, found, one)
    for panel in panels[len(chosen) :]:
        panel.set_axis_off()


def _draw_over_one(axes: Axes, found: SweepTable, one: SweepColumn) -> None:
    """A measure over the varied number; crosses on the axis where runs failed."""
    (varied,) = found.varied.values()
    x, y = varied.readable(), one.readable()
    usable = found.good & np.isfinite(y)
    order = np.argsort(x[usable], kind="stable")
    line = "-" if found.shape is not None else ""
    axes.plot(x[usable][order], y[usable][order], line, color=SIMULATED, marker="o", ms=3.0)
    _mark_failures(axes, x, None, found, one)
    axes.set(xlabel=label_varied(found)[0], ylabel=label_column(one))
    set_scales(axes, varied)
    if not np.any(usable):
        axes.set_yticks([])


def _draw_over_two(axes: Axes, found: SweepTable, one: SweepColumn) -> None:
    """A map of a measure over both varied numbers; points for samples."""
    first, second = found.varied.values()
    usable = found.good & np.isfinite(one.values)
    values = np.where(usable, one.readable(), np.nan)
    if found.shape is None:
        x, y = first.readable(), second.readable()
        drawn = axes.scatter(x[usable], y[usable], c=values[usable], s=9.0, cmap=MAP, lw=0.0)
    else:
        levels = [c.readable(n) for c, n in zip((first, second), found.levels or (), strict=True)]
        drawn = _draw_map(axes, levels, values.reshape(found.shape))
        x, y = (grid.ravel() for grid in np.meshgrid(*levels, indexing="ij"))
    _mark_failures(axes, x, y, found, one)
    names = label_varied(found)
    axes.set(xlabel=names[0], ylabel=names[1])
    set_scales(axes, first, second)
    axes.grid(False)
    add_colour_bar(axes.figure, drawn, axes, label_column(one))


def _draw_map(axes: Axes, levels: list[Any], values: Any) -> Any:
    """Cells around the levels, and lines of equal values where there are enough of them."""
    axes.set_facecolor(FAINT)
    drawn = axes.pcolormesh(*levels, np.ma.masked_invalid(values.T), shading="nearest", cmap=MAP, rasterized=True)
    if min(values.shape) > 3 and np.isfinite(values).all() and is_spread(values):
        lines = axes.contour(*levels, values.T, levels=6, colors="white", linewidths=0.6)
        axes.clabel(lines, fontsize=7.0, fmt="%.4g")
    return drawn


def _mark_failures(axes: Axes, x: Any, y: Any, found: SweepTable, one: SweepColumn) -> None:
    """Runs that failed, and those in which what is measured never happened."""
    never = found.good & np.isinf(one.values)
    looks: tuple[tuple[Any, str, Any], ...] = (
        (found.status >= Status.UNSOLVED, "failed", {"marker": "x", "color": HEATING}),
        (never, "never", {"marker": "o", "mfc": "none", "color": QUIET}),
    )
    for rows, word, look in looks:
        if not rows.any():
            continue
        on_axis: dict[str, Any] = {"transform": axes.get_xaxis_transform()} if y is None else {}
        height = np.full(int(rows.sum()), 0.03) if y is None else y[rows]
        axes.plot(x[rows], height, ls="", ms=4.5, label=word, clip_on=False, **look, **on_axis)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="upper left", bbox_to_anchor=(0.0, 1.12), ncols=2, borderpad=0.0)
