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


def plot_design(optimum: OptimisedDesign, title: str = "") -> Figure:
    """Return the best goal over the runs of the search, and the first coordinate over time."""
    with use_style():
        figure, ((left, right),) = make_panels(WIDTH, HEIGHT, 1, 2, title)
        _draw_history(optimum, left)
        _draw_motion(optimum, right)
    return figure


def _draw_history(optimum: OptimisedDesign, axes: Axes) -> None:
    """Draw the best goal so far; hollow if constraints are violated."""
    goal = optimum.question.goal
    display_unit = units.choose_readable_unit(goal.unit)
    runs = np.array([mark.runs for mark in optimum.history])
    values = np.array([units.from_si(mark.goal, display_unit, goal.unit) for mark in optimum.history])
    feasible = np.array([mark.violation <= 1e-4 for mark in optimum.history])
    axes.step(runs, values, where="post", color=QUIET, linewidth=0.9)
    axes.plot(runs[~feasible], values[~feasible], "o", mfc="none", color=QUIET, label="misses constraints")
    axes.plot(runs[feasible], values[feasible], "o", color=HEATING, label="keeps all")
    axes.set(xlabel="runs", ylabel=f"{goal.words}{'' if display_unit == '1' else f' [{display_unit}]'}")
    axes.legend(loc="best")


def _draw_motion(optimum: OptimisedDesign, axes: Axes) -> None:
    designs = optimum.designs
    name = next(iter(designs.system.mechanism.outputs()), "")
    output = designs.system.outputs()[name]
    display_unit = units.choose_readable_unit(output.unit)
    looks = ((optimum.start, QUIET, "scenario"), (optimum.numbers, HEATING, "found"))
    for numbers, colour, label in looks:
        column = designs.course(np.array(numbers), name)
        values = [units.from_si(float(v), display_unit, output.unit) for v in column]
        axes.plot(designs.times, values, color=colour, label=label)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.set(xlabel="time [s]", ylabel=f"{output.long_name} [{display_unit}]")
    axes.legend(loc="best")
