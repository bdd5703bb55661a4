"""The figure of a sweep: measures over one varied parameter, maps over two, or a scatter matrix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.formats import typeset_unit
from martensite.base.status import Status
from martensite.design.sweep.given_data_indices import is_spread
from martensite.design.sweep.table import SweepColumn, SweepTable, shorten_names
from martensite.show.figures.panels import add_colour_bar, write_suptitle
from martensite.show.figures.style import FAINT, HEATING, QUIET, SIMULATED, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_MEASURES = 6
"""Largest number of measures in a figure."""
PANEL = 3.4, 2.7
"""Width and height of a panel [inch]."""
MAP = "viridis"
NARROW = 30.0
"""Ratio of the ends of a logarithmic axis below which intermediate values are labelled."""
MOST_AXES = 6
MOST_POINTS = 4000
"""Largest number of drawn runs, chosen at random."""
CELL = 1.7
"""Size of a panel [inch]."""


def plot_sweep(table: SweepTable, measures: Sequence[str] | None = None, title: str = "") -> Figure:
    """Draw the results of a sweep.

    One varied parameter: measures over it. Two: a map of each measure. More: a scatter matrix of all varied parameters,
    coloured by the first measure, which is also drawn over each.

    Args:
        table: the runs.
        measures: names of measures; by default the first six.
        title: headline; by default the title of the sweep.

    Raises:
        UnknownNameError: the measure does not exist.
        DataError: the sweep stored only traces.
    """
    chosen = table.choose_measures(None if measures is None else list(measures))[:MOST_MEASURES]
    many = len(table.varied) > 2
    with use_style():
        size = measure_matrix(table) if many else _choose_size(len(chosen))
        figure = make_figure(*size)
        figure.set_layout_engine("constrained")
        if many:
            draw_matrix(figure, table, chosen[0])
        else:
            _draw_panels(figure, table, chosen)
        write_suptitle(figure, title or write_sweep_title(table))
    return figure


def _choose_size(count: int) -> tuple[float, float]:
    rows, columns = arrange_panels(count)
    return PANEL[0] * max(columns, 1.3), PANEL[1] * rows + 0.3


def _draw_panels(figure: Figure, table: SweepTable, chosen: list[SweepColumn]) -> None:
    panels = figure.subplots(*arrange_panels(len(chosen)), squeeze=False).ravel()
    draw = _draw_over_one if len(table.varied) == 1 else _draw_over_two
    for panel, one in zip(panels, chosen, strict=False):
        draw(panel, table, one)
    for panel in panels[len(chosen) :]:
        panel.set_axis_off()


def _draw_over_one(axes: Axes, table: SweepTable, one: SweepColumn) -> None:
    (varied,) = table.varied.values()
    x, y = varied.readable(), one.readable()
    usable = table.good & np.isfinite(y)
    order = np.argsort(x[usable], kind="stable")
    line = "-" if table.shape is not None else ""
    axes.plot(x[usable][order], y[usable][order], line, color=SIMULATED, marker="o", ms=3.0)
    _mark_failures(axes, x, None, table, one)
    axes.set(xlabel=label_varied(table)[0], ylabel=label_column(one))
    set_scales(axes, varied)
    if not np.any(usable):
        axes.set_yticks([])


def _draw_over_two(axes: Axes, table: SweepTable, one: SweepColumn) -> None:
    first, second = table.varied.values()
    usable = table.good & np.isfinite(one.values)
    values = np.where(usable, one.readable(), np.nan)
    if table.shape is None:
        x, y = first.readable(), second.readable()
        mappable = axes.scatter(x[usable], y[usable], c=values[usable], s=9.0, cmap=MAP, lw=0.0)
    else:
        levels = [c.readable(n) for c, n in zip((first, second), table.levels or (), strict=True)]
        mappable = _draw_map(axes, levels, values.reshape(table.shape))
        x, y = (grid.ravel() for grid in np.meshgrid(*levels, indexing="ij"))
    _mark_failures(axes, x, y, table, one)
    names = label_varied(table)
    axes.set(xlabel=names[0], ylabel=names[1])
    set_scales(axes, first, second)
    axes.grid(False)
    add_colour_bar(axes.figure, mappable, axes, label_column(one))


def _draw_map(axes: Axes, levels: list[Any], values: Any) -> Any:
    """Return the cells around the levels, with contour lines for enough cells."""
    axes.set_facecolor(FAINT)
    mesh = axes.pcolormesh(*levels, np.ma.masked_invalid(values.T), shading="nearest", cmap=MAP, rasterized=True)
    if min(values.shape) > 3 and np.isfinite(values).all() and is_spread(values):
        lines = axes.contour(*levels, values.T, levels=6, colors="white", linewidths=0.6)
        axes.clabel(lines, fontsize=7.0, fmt="%.4g")
    return mesh


def _mark_failures(axes: Axes, x: Any, y: Any, table: SweepTable, one: SweepColumn) -> None:
    """Mark failed runs, and runs whose measured event never happened."""
    never = table.good & np.isinf(one.values)
    looks: tuple[tuple[Any, str, Any], ...] = (
        (table.status >= Status.UNSOLVED, "failed", {"marker": "x", "color": HEATING}),
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


def label_column(one: SweepColumn, short: str = "") -> str:
    """Return the name and unit of a column, for an axis."""
    return f"{short or one.name} [{typeset_unit(one.display_unit, '–')}]"


def label_varied(table: SweepTable) -> list[str]:
    """Return the labels of all varied parameters."""
    names = shorten_names(table.varied)
    return [label_column(one, names[path]) for path, one in table.varied.items()]


def set_scales(axes: Axes, x: SweepColumn, y: SweepColumn | None = None) -> None:
    """Set the scales of a panel by its columns, with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for one, axis, name in ((x, axes.xaxis, "xscale"), (y, axes.yaxis, "yscale")):
        if one is not None and one.is_logarithmic:
            axes.set(**{name: "log"})
            values = one.values[np.isfinite(one.values)]
            narrow = not values.size or values.max() < NARROW * values.min()
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if narrow else (1.0,)))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def write_sweep_title(table: SweepTable) -> str:
    """Return the title of a sweep with its number of runs."""
    failed = f", {table.failed:,} failed" if table.failed else ""
    missing = f", {table.missing:,} not made yet" if table.missing else ""
    return f"{table.title}: {len(table.status):,} runs{failed}{missing}"


def arrange_panels(count: int) -> tuple[int, int]:
    """Return the rows and columns of panels."""
    columns = 2 if count == 4 else min(count, 3)
    return -(-count // columns), columns


def measure_matrix(table: SweepTable) -> tuple[float, float]:
    """Return the size of the figure [inch]."""
    count = min(len(table.varied), MOST_AXES)
    return CELL * count + 1.4, CELL * count + 0.6


def draw_matrix(figure: Figure, table: SweepTable, one: SweepColumn) -> None:
    """Draw the lower triangle of all pairs, and the measure over each parameter in the last row.

    Of more than six parameters, those with the strongest rank correlation with the measure are drawn.
    """
    columns, names = list(table.varied.values()), label_varied(table)
    usable = table.good & np.isfinite(one.values)
    strongest = _find_leading(columns, one, usable)
    rows, failed = _pick_runs(usable), _pick_runs(table.status >= Status.UNSOLVED)
    colours = one.readable()
    count = len(strongest)
    panels: Any = figure.subplots(count, count, squeeze=False)
    mappable: Any = None
    for i, j in np.ndindex(count, count):
        panel, below = panels[i, j], i == count - 1
        if j > i:
            panel.set_axis_off()
            continue
        x = columns[strongest[j]]
        y = one if below else columns[strongest[i + 1]]
        across, up = x.readable(), y.readable()
        mappable = panel.scatter(across[rows], up[rows], c=colours[rows], s=4.0, lw=0.0, cmap=MAP, rasterized=True)
        if not below:
            panel.plot(across[failed], up[failed], "x", color=HEATING, ms=3.5)
        set_scales(panel, x, y)
        name = label_column(one) if below else names[strongest[i + 1]]
        panel.set(xlabel=names[strongest[j]], ylabel=name)
        panel.label_outer()
    add_colour_bar(figure, mappable, panels.ravel().tolist(), label_column(one), aspect=35)


def _find_leading(columns: list[SweepColumn], one: SweepColumn, usable: NDArray[np.bool_]) -> list[int]:
    if len(columns) <= MOST_AXES:
        return list(range(len(columns)))
    from martensite.design.sweep.given_data_indices import rank_columns

    y = rank_columns(one.values[usable])
    strengths = [abs(np.corrcoef(rank_columns(c.values[usable]), y)[0, 1]) for c in columns]
    return sorted(np.argsort(strengths)[::-1][:MOST_AXES].tolist())


def _pick_runs(rows: NDArray[np.bool_]) -> NDArray[np.int64]:
    places = np.flatnonzero(rows)
    if len(places) <= MOST_POINTS:
        return places
    return np.sort(np.random.default_rng(0).choice(places, MOST_POINTS, replace=False))
