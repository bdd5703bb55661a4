"""The figure of the benchmark: who is how far off on what, over all wires, and how hot faults make it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.control.competition import BenchmarkTable, rank_entries
from benchmarks.control.runs import NO_FAULT
from benchmarks.control.table_summary import HOT
from benchmarks.control.tasks import load_tasks
from martensite.show.figures.style import COOLING, HEATING, INK, QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST, MOST = 0.05, 100.0
"""Errors that are shown, in % of the span."""
HEAD_HEIGHT = 0.9
"""Room for headings and scales [inch]."""


def plot_benchmark(table: BenchmarkTable) -> Figure:
    """Median to 90 % of the rms errors by task, entries in their ranking, and a map of faults if there are any."""
    sound = table.select(fault=NO_FAULT)
    tasks, names = list(dict.fromkeys(one.task for one in sound)), table.entries
    faults = [name for name in dict.fromkeys(one.fault for one in table.rows) if name != NO_FAULT]
    with use_style():
        figure = make_figure(10.0, HEAD_HEIGHT + (HEAD_HEIGHT + 0.26 * len(names)) * (2 if faults else 1))
        grid = figure.add_gridspec(2 if faults else 1, len(tasks), hspace=0.36)
        for k, task in enumerate(tasks):
            panel = figure.add_subplot(grid[0, k])
            _draw_errors(panel, table, task, names)
            panel.set_yticks(range(len(names)), names if k == 0 else [""] * len(names))
        if faults:
            _draw_faults(figure.add_subplot(grid[1, :]), table, names, faults)
        scores = dict(rank_entries(table))
        figure.suptitle(
            f"Rms error on {sound[0].wires} wires that nobody measured, % of the span: median (dot) to 90 % (bar). "
            f"Best: {names[0]}, {100.0 * scores[names[0]]:.1f} %",
            x=0.02,
            ha="left",
            fontsize=10.0,
            color=INK,
        )
        height = figure.get_figheight()
        figure.subplots_adjust(left=0.13, right=0.98, top=1.0 - 0.75 / height, bottom=0.75 / height)
    return figure


def _draw_errors(panel: Any, table: BenchmarkTable, task: str, names: Sequence[str]) -> None:
    for k, name in enumerate(names):
        for one in table.select(entry=name, task=task, fault=NO_FAULT):
            colour = HEATING if one.above > 0.0 else COOLING
            ends = np.clip([100.0 * one.error_median, 100.0 * one.error_90], LEAST, MOST)
            panel.plot(ends, [k, k], color=colour, linewidth=3.0, alpha=0.45, solid_capstyle="butt")
            panel.plot(ends[:1], [k], "o", color=colour, markersize=4.5)
    known = load_tasks()
    panel.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(names) - 0.4, -0.6), title=task)
    panel.set_xlabel("%")
    panel.axvline(5.0, color=QUIET, linewidth=0.7, linestyle=(0, (3, 2)))
    panel.tick_params(axis="y", length=0)
    panel.set_title(task if task not in known else f"{task}\n{known[task].plant}", fontsize=8.5)


def _draw_faults(panel: Any, table: BenchmarkTable, names: Sequence[str], faults: Sequence[str]) -> None:
    heat = np.full((len(names), len(faults)), np.nan)
    for one in table.rows:
        if one.fault != NO_FAULT:
            place = names.index(one.entry), faults.index(one.fault)
            heat[place] = np.nanmax([heat[place], one.hottest - 273.15])
    panel.imshow(heat, aspect="auto", cmap="YlOrRd", vmin=80.0, vmax=2.0 * HOT - 80.0)
    for (row, column), value in np.ndenumerate(heat):
        if np.isfinite(value):
            weight = "bold" if value > HOT else "normal"
            panel.text(
                column, row, f"{value:.0f}", ha="center", va="center", fontsize=7.0, fontweight=weight, color=INK
            )
    panel.grid(visible=False)
    panel.set_xticks(range(len(faults)), faults, rotation=20, ha="right")
    panel.set_yticks(range(len(names)), names)
    panel.set_title(f"Highest temperature with a fault, °C (bold: above the limit of {HOT:.0f} °C)")
