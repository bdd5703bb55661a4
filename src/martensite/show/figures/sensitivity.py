"""The figure of sensitivities: bars of every index of the varied numbers, with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from martensite.design.sweep.indices import SensitivityIndices
from martensite.design.sweep.table import shorten_names
from martensite.show.figures.panels import make_panels
from martensite.show.figures.style import COOLING, HEATING, INK, MEASURED, QUIET, use_style
from martensite.show.figures.sweep_labels import arrange_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"first": COOLING, "total": HEATING, "delta": MEASURED[2], "rank slope": MEASURED[0]}
"""Indices that are drawn, and how."""
WIDTH, BAR, HEAD = 4.2, 0.19, 1.0
MOST = 10
"""Varied numbers in a panel, the most important."""


def plot_sensitivity(found: Sequence[SensitivityIndices], title: str = "") -> Figure:
    """Draw what measures depend on, one panel for each, the most important number on top.

    Args:
        found: of `sensitivity`.
        title: above the figure.
    """
    rows, columns = arrange_panels(len(found))
    kinds = [kind for kind in COLOURS if any(kind in one.indices for one in found)]
    names = min(max(len(one.names) for one in found), MOST)
    height = names * (BAR * len(kinds) + 0.12) + HEAD
    with use_style():
        width = WIDTH * max(columns, 1.2)
        figure, panels = make_panels(width, rows * height + 0.4, rows, columns, title)
        panels = panels.ravel()
        for panel, one in zip(panels, found, strict=False):
            _draw_bars(panel, one, kinds)
        for panel in panels[len(found) :]:
            panel.set_axis_off()
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=len(kinds))
    return figure


def _draw_bars(axes: Axes, one: SensitivityIndices, kinds: list[str]) -> None:
    """Indices of one measure."""
    order = one.order[:MOST]
    names = shorten_names(list(one.names))
    places = np.arange(len(order))
    for k, kind in enumerate(kinds):
        index = one.indices.get(kind)
        if index is None:
            continue
        at = places + (k - 0.5 * (len(kinds) - 1)) * 0.8 / len(kinds)
        values, wide = index.values[order], index.wide[order]
        axes.barh(at, np.nan_to_num(values), 0.8 / len(kinds), color=COLOURS[kind], label=kind)
        known = np.isfinite(wide) & np.isfinite(values)
        axes.errorbar(values[known], at[known], xerr=wide[known], ls="", ecolor=INK, elinewidth=0.8, capsize=2)
    axes.axvline(0.0, color=QUIET, linewidth=0.7)
    axes.set_yticks(places, [names[one.names[k]] for k in order])
    axes.invert_yaxis()
    axes.set_xlim(*_find_ends(one))
    axes.grid(visible=False, axis="y")
    title = one.measure if one.deviation else f"{one.measure} (always the same)"
    axes.set_title(title, fontweight="bold").set_parse_math(False)


def _find_ends(one: SensitivityIndices) -> tuple[float, float]:
    """Limits of the panel: 0 to 1, more where an interval of something drawn goes further."""
    drawn = [index for kind, index in one.indices.items() if kind in COLOURS]
    halves = [np.nan_to_num(index.wide) for index in drawn]
    values = [np.nan_to_num(index.values) for index in drawn]
    low = min(float(np.min(v - w)) for v, w in zip(values, halves, strict=True))
    high = max(float(np.max(v + w)) for v, w in zip(values, halves, strict=True))
    return 1.05 * min(low, -0.02), max(1.05, 1.02 * high)
