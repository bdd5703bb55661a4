"""Figures of a design and of a tuning: how the search went, and what is done before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base import units
from martensite.design.optimise.optimised_design import OptimisedDesign
from martensite.design.tuning.bench_tuning import TunedBench
from martensite.design.tuning.loop_runs import find_judged_output
from martensite.show.figures.panels import make_panels
from martensite.show.figures.style import HEATING, INK, QUIET, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.5, 3.2
TUNING_WIDTH, TUNING_HEIGHT = 7.0, 5.2
BEFORE: dict[str, Any] = {"color": QUIET, "linewidth": 1.1, "label": "before"}
AFTER: dict[str, Any] = {"color": HEATING, "linewidth": 1.4, "label": "after"}
WANTED: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 2)), "label": "reference"}


def plot_design(found: OptimisedDesign, title: str = "") -> Figure:
    """The best design over the runs of the search, and the first coordinate over time."""
    with use_style():
        figure, ((left, right),) = make_panels(WIDTH, HEIGHT, 1, 2, title)
        _draw_history(found, left)
        _draw_motion(found, right)
    return figure


def _draw_history(found: OptimisedDesign, axes: Axes) -> None:
    """Goal of the best design so far; hollow while it does not keep all constraints."""
    goal = found.question.goal
    shown = units.choose_readable_unit(goal.unit)
    runs = np.array([mark.runs for mark in found.history])
    values = np.array([units.from_si(mark.goal, shown, goal.unit) for mark in found.history])
    kept = np.array([mark.violation <= 1e-4 for mark in found.history])
    axes.step(runs, values, where="post", color=QUIET, linewidth=0.9)
    axes.plot(runs[~kept], values[~kept], "o", mfc="none", color=QUIET, label="misses constraints")
    axes.plot(runs[kept], values[kept], "o", color=HEATING, label="keeps all")
    axes.set(xlabel="runs", ylabel=f"{goal.words}{'' if shown == '1' else f' [{shown}]'}")
    axes.legend(loc="best")


def _draw_motion(found: OptimisedDesign, axes: Axes) -> None:
    designs = found.designs
    name = next(iter(designs.system.mechanism.outputs()), "")
    output = designs.system.outputs()[name]
    shown = units.choose_readable_unit(output.unit)
    looks = ((found.start, QUIET, "scenario"), (found.numbers, HEATING, "found"))
    for numbers, colour, label in looks:
        column = designs.course(np.array(numbers), name)
        values = [units.from_si(float(v), shown, output.unit) for v in column]
        axes.plot(designs.times, values, color=colour, label=label)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.set(xlabel="time [s]", ylabel=f"{output.long_name} [{shown}]")
    axes.legend(loc="best")


def plot_tuning(found: TunedBench, drive: str, title: str = "") -> Figure:
    """Reference and output, error and signal of the loop of a drive, before and after."""
    bench = found.bench
    output = bench.outputs()[find_judged_output(bench, drive)]
    shown = units.choose_readable_unit(output.unit)
    factor, _ = units.find_conversion(shown, output.unit)
    label = {"1": "", "degC": " [K]"}.get(shown, f" [{shown}]")
    runs = ((found.seen_before, BEFORE), (found.seen, AFTER))
    with use_style():
        ratios = (2.0, 1.0, 1.2)
        figure, panels = make_panels(TUNING_WIDTH, TUNING_HEIGHT, 3, 1, title, sharex=True, height_ratios=ratios)
        panels = panels[:, 0]
        for seen, look in runs:
            values = [units.from_si(v, shown, output.unit) for v in seen.output.tolist()]
            panels[0].plot(found.times, values, **look)
            panels[1].plot(found.times, (seen.reference - seen.output) / factor, **look)
            panels[2].plot(found.times, seen.signal, drawstyle="steps-post", **look)
        wanted = [units.from_si(v, shown, output.unit) for v in found.seen.reference.tolist()]
        panels[0].plot(found.times, wanted, drawstyle="steps-post", **WANTED)
        panels[0].legend(loc="best")
        panels[0].set(ylabel=f"{output.long_name}{label.replace('[K]', '[°C]')}")
        panels[1].set(ylabel=f"error{label}")
        panels[2].set(ylabel=f"signal of {drive}", xlabel="time [s]")
    return figure
