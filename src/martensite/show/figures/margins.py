"""Bode and Nyquist plots of a loop on both branches, with margins; python-control computes the responses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.base.lazy import import_extra
from martensite.control.margins.linear_loop import LinearLoop
from martensite.control.margins.loop_case import LoopCase
from martensite.control.margins.loop_points import linearise_case
from martensite.control.margins.margins import compute_margins, list_frequencies
from martensite.identify.chains.linear_system import LinearSystem
from martensite.show.figures.panels import make_panels
from martensite.show.figures.style import COOLING, HEATING, INK, QUIET, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.scenario.scenario import Scenario

MARGINS_WIDTH, MARGINS_HEIGHT = 8.2, 4.8
COLOURS = {"heating": HEATING, "cooling": COOLING, "dead band": QUIET}
LINES = ("-", "--", ":", "-.")
SHOWN, NEAR = 2.5, 0.5
"""Half width of the Nyquist plot, and the distance from -1 where M_s is 2."""


def to_control_system(linear: LinearSystem) -> Any:
    """Return a linear system as a minimal `control.StateSpace`."""
    slim = linear.reduce_states()
    return import_extra("control", "control", "python-control").ss(slim.a, slim.b, slim.c, slim.d, slim.interval)


def plot_scenario_margins(scenario: Scenario) -> Figure:
    """Draw the first loop of a scenario that tracks a reading."""
    members = {} if scenario.bench is None else scenario.bench.controllers.members()
    drive = next((name for name, one in members.items() if one.holds), None)
    if scenario.bench is None or drive is None:
        raise InputError("There is no loop to draw margins of: no controller on the bench holds a reading.")
    case = LoopCase(scenario.bench, drive, members[drive], scenario.duration)
    return plot_margins(linearise_case(case), scenario.title)


def plot_margins(loops: Sequence[LinearLoop], title: str = "") -> Figure:
    """Draw Bode plots on the left, Nyquist plots on the right, with the circle of M_s = 2.

    Args:
        loops: from `linearise_loops`; loops without response are omitted.
        title: headline.

    Raises:
        InputError: no loop has a response.
    """
    moving = [one for one in loops if len(one.loop.active)]
    if not moving:
        raise InputError("None of the loops answers, so that there is nothing to draw.")
    places = {one.branch: [other for other in moving if other.branch == one.branch] for one in moving}
    with use_style():
        figure, panels = make_panels(MARGINS_WIDTH, MARGINS_HEIGHT, 2, 2, title, width_ratios=(1.25, 1.0))
        size, angle, plane = panels[0, 0], panels[1, 0], _merge_column(figure, panels)
        for one in moving:
            k = places[one.branch].index(one)
            look = {"color": COLOURS[one.branch], "linestyle": LINES[k % len(LINES)], "label": _describe_loop(one)}
            omega = list_frequencies(one.loop.interval)
            response = np.squeeze(to_control_system(one.loop)(np.exp(1j * omega * one.loop.interval)))
            size.loglog(omega, np.abs(response), **look)
            angle.semilogx(omega, np.degrees(np.unwrap(np.angle(response))), **look)
            plane.plot(response.real, response.imag, **look)
            _mark_margins(one, size, angle)
        size.axhline(1.0, color=INK, linewidth=0.8)
        angle.axhline(-180.0, color=INK, linewidth=0.8)
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        plane.plot(-1.0 + NEAR * np.cos(turn), NEAR * np.sin(turn), color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
        plane.plot([-1.0], [0.0], "+", color=INK)
        plane.set(xlim=(-SHOWN, 0.5), ylim=(-SHOWN, 0.5), xlabel="real part of L", ylabel="imaginary part of L")
        plane.set_aspect("equal", adjustable="box")
        size.legend(loc="lower left", fontsize=7.0)
        size.set(ylabel="|L|")
        angle.set(ylabel="phase of L [°]", xlabel="frequency [rad/s]")
    return figure


def _merge_column(figure: Figure, panels: Any) -> Any:
    """Return one panel in place of the two on the right."""
    upper, lower = panels[0, 1], panels[1, 1]
    grid = upper.get_subplotspec().get_gridspec()
    upper.remove()
    lower.remove()
    return figure.add_subplot(grid[:, 1])


def _mark_margins(one: LinearLoop, size: Any, angle: Any) -> None:
    margins = compute_margins(one.loop)
    if math.isfinite(margins.crossover):
        colour = COLOURS[one.branch]
        size.plot([margins.crossover], [1.0], "o", color=colour, markersize=3.5)
        left = math.degrees(margins.phase) - 180.0
        angle.plot([margins.crossover] * 2, [-180.0, left], color=colour, linewidth=0.7, marker="o", markersize=2.5)


def _describe_loop(one: LinearLoop) -> str:
    own = compute_margins(one.loop)
    at = write_quantity(one.reading, one.unit, 3)
    if not own.stable:
        return f"{one.branch} {at}: unstable"
    phase = f", {math.degrees(own.phase):.0f}°" if math.isfinite(own.phase) else ""
    return f"{one.branch} {at}: $M_s$ {own.sensitivity:.2f}{phase}"
