"""Scatter of samples: every pair of varied numbers coloured by a measure, and the measure below."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.status import Status
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.show.figures.panels import add_colour_bar
from martensite.show.figures.style import HEATING
from martensite.show.figures.sweep_labels import label_column, label_varied, set_scales

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_AXES = 6
MOST_POINTS = 4000
"""Runs that are drawn at most, chosen at random."""
CELL = 1.7
"""Size of a panel [inch]."""
MAP = "viridis"


def measure_matrix(found: SweepTable) -> tuple[float, float]:
    """Width and height of the figure [inch]."""
    count = min(len(found.varied), MOST_AXES)
    return CELL * count + 1.4, CELL * count + 0.6


def draw_matrix(figure: Figure, found: SweepTable, one: SweepColumn) -> None:
    """Draw the lower triangle of all pairs, and the measure over each number in the last row.

    Of more than six varied numbers, those are drawn whose ranks go most with the measure.
    """
    columns, names = list(found.varied.values()), label_varied(found)
    usable = found.good & np.isfinite(one.values)
    shown = _find_leading(columns, one, usable)
    rows, failed = _pick_runs(usable), _pick_runs(found.status >= Status.UNSOLVED)
    colours = one.readable()
    count = len(shown)
    panels: Any = figure.subplots(count, count, squeeze=False)
    drawn: Any = None
    for i, j in np.ndindex(count, count):
        panel, below = panels[i, j], i == count - 1
        if j > i:
            panel.set_axis_off()
            continue
        x = columns[shown[j]]
        y = one if below else columns[shown[i + 1]]
        across, up = x.readable(), y.readable()
        look = {"s": 4.0, "lw": 0.0, "cmap": MAP, "rasterized": True}
        drawn = panel.scatter(across[rows], up[rows], c=colours[rows], **look)
        if not below:
            panel.plot(across[failed], up[failed], "x", color=HEATING, ms=3.5)
        set_scales(panel, x, y)
        name = label_column(one) if below else names[shown[i + 1]]
        panel.set(xlabel=names[shown[j]], ylabel=name)
        panel.label_outer()
    add_colour_bar(figure, drawn, panels.ravel().tolist(), label_column(one), aspect=35)


def _find_leading(columns: list[SweepColumn], one: SweepColumn, usable: NDArray[np.bool_]) -> list[int]:
    """Places of the varied numbers that are drawn, in their order."""
    if len(columns) <= MOST_AXES:
        return list(range(len(columns)))
    from martensite.search.given_data_indices import rank_columns

    y = rank_columns(one.values[usable])
    strengths = [abs(np.corrcoef(rank_columns(c.values[usable]), y)[0, 1]) for c in columns]
    return sorted(np.argsort(strengths)[::-1][:MOST_AXES].tolist())


def _pick_runs(rows: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Places of runs, at most as many as can be seen."""
    places = np.flatnonzero(rows)
    if len(places) <= MOST_POINTS:
        return places
    return np.sort(np.random.default_rng(0).choice(places, MOST_POINTS, replace=False))
