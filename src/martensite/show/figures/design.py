"""The figure of a design: progress of the search, and motion before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from martensite.base import units
from martensite.design.optimise.optimised_design import OptimisedDesign
from martensite.show.figures.panels import make_panels
from martensite.show.figures.style import HEATING, INK, QUIET, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.5, 3.2


def plot_design(found: OptimisedDesign, title: str = "") -> Figure:
    """Return the best goal over the runs of the search, and the first coordinate over time."""
    with use_style():
        figure, ((left, right),) = make_panels(WIDTH, HEIGHT, 1, 2, title)
        _draw_history(found, left)
        _draw_motion(found, right)
    return figure


def _draw_history(found: OptimisedDesign, axes: Axes) -> None:
    """Draw the best goal so far; hollow if constraints are violated."""
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
