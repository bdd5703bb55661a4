"""The figure of the study."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanics.platform_kinematics import compute_lengths
from martensite.kernels.arrays import ArrayNamespace
from martensite.show.figures.style import COOLING, FAINT, HEATING, INK, MEASURED, QUIET, SIMULATED
from martensite.simulate.result import Result
from martensite.studies.figures import draw_page
from martensite.studies.platform import bench, geometry_numbers, loop
from martensite.studies.platform.bench import CASES, FINE, LATE, LIMITED, step_of
from martensite.studies.platform.loop import CYCLES, DELAY, LAGGING, QUICK, Sampling
from martensite.studies.platform.workspace import Workspace
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"as-printed": INK, "A": SIMULATED, "A'": MEASURED[2], "C": MEASURED[1]}
LIMIT_COLOUR = MEASURED[3]
DASHES = (0, (4, 1.6))
"""Line style of the low voltage."""
SPAN = 24.0
"""Time after which the springs as printed are hot also at 3 V [s]."""
SHOWN = Sampling(20.0, 0.005)
"""Sampling of the run as printed, over some cycles."""
FINER = 5
"""Points of the drawn outline per grid step of the reach."""
DELAYS = (0.0, 0.15, DELAY, 0.45)
"""Measurement delays of the overshoot panel [s]."""


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure."""
    with draw_page(
        11.5,
        7.4,
        "Parallel platform on three shape-memory springs, one of them hot",
        "Simulated for this project; circles are the paper's two response times. The sets A, "
        "A' and C are calibrated to them.",
    ) as figure:
        grid = figure.add_gridspec(
            2, 3, left=0.055, right=0.985, top=0.885, bottom=0.075, wspace=0.24, hspace=0.34, height_ratios=(1.15, 1.0)
        )
        _draw_responses(figure.add_subplot(grid[0, :2]), printed)
        _draw_reach(figure.add_subplot(grid[0, 2]), printed)
        _draw_control(figure.add_subplot(grid[1, 0]), printed)
        _draw_overshoot(figure.add_subplot(grid[1, 1]), printed)
        _draw_hysteresis(figure.add_subplot(grid[1, 2]), printed)
        return figure


def _draw_responses(axes: Any, printed: Printed) -> None:
    for key, case in CASES.items():
        for volts, line in ((printed.high, "-"), (printed.low, DASHES)):
            times, turned = _draw_response(key, printed, volts)
            label = case.title if line == "-" else None
            axes.plot(times, turned, color=COLOURS[key], linestyle=line, label=label)
    stalled = bench.run_heated(LIMITED, printed, printed.high, 400.0, 0.05)
    axes.plot(stalled.times, bench.angle_degrees(stalled), color=LIMIT_COLOUR, label=LIMITED.title)
    axes.plot(
        (printed.fast, printed.slow),
        (printed.angle, printed.angle),
        "o",
        color=HEATING,
        markersize=7.5,
        markerfacecolor="none",
        markeredgewidth=1.8,
        zorder=5,
        label="paper: 18 s at 5 V, around 30 s at 3 V",
    )
    axes.plot([], [], color=QUIET, label="solid: 5 V")
    axes.plot([], [], color=QUIET, linestyle=DASHES, label="dashed: 3 V")
    axes.set(xlim=(0.0, LATE), ylim=(0.0, 36.0), xlabel="time [s]", ylabel="$α$ [°]")
    axes.set_title("rotation about X: 5 V and 3 V on one spring")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.02), labelspacing=0.3)


def _draw_response(key: str, printed: Printed, volts: float) -> tuple[list[float], list[float]]:
    """Return the times [s] and angles [°], extended for springs at their final state."""
    case = CASES[key]
    if key == "as-printed":
        result = bench.run_heated(case, printed, volts, SPAN, FINE)
        turned = bench.angle_degrees(result)
        return [*result.times, LATE], [*turned, turned[-1]]
    result = bench.run_heated(case, printed, volts, LATE, step_of(case))
    return result.times.tolist(), bench.angle_degrees(result)


def _draw_reach(axes: Any, printed: Printed) -> None:
    workspace = geometry_numbers.find_workspace(printed)
    x, y, room = _distance_grid(workspace)
    axes.contourf(x, y, room.T, [0.0, np.inf], colors=["#e9eff3"], zorder=0.5)
    axes.contour(x, y, room.T, [0.0], colors=[QUIET], linewidths=0.9, zorder=1.0)
    for leg, ray in enumerate(workspace.rays):
        points = np.degrees(np.asarray(ray))
        axes.plot(*points.T, color=HEATING, linewidth=1.6)
        axes.plot(*points[-1:].T, "o", color=HEATING, markersize=4.0)
        axes.annotate(
            f"spring {leg}",
            points[-1],
            xytext=(-6 if leg == 0 else 6, 6 if leg == 0 else 0),
            textcoords="offset points",
            ha="right" if leg == 0 else "left",
            va="center",
            color=HEATING,
            fontsize=8.0,
        )
    axes.plot([0.0], [0.0], "o", color=INK, markersize=4.0)
    axes.set_aspect("equal")
    axes.set(xlim=(-36.0, 42.0), ylim=(-42.0, 42.0))
    axes.set(xlabel="$α$, about X [°]", ylabel="$β$, about Y [°]")
    axes.set_title("reach, and the ways of single springs")


def _distance_grid(workspace: Workspace) -> tuple[Any, Any, Any]:
    """Return the angles [°] of a fine grid, and the margins of the springs from their limits [m].

    Outside the reachable set the margin is NaN, also for allowed but disconnected postures.
    """
    alphas, betas = (
        np.linspace(grid[0], grid[-1], FINER * (len(grid) - 1) + 1) for grid in (workspace.alphas, workspace.betas)
    )
    near = np.pad(np.asarray(workspace.reached), 1)
    near = near[:-2] | near[1:-1] | near[2:]
    near = near[:, :-2] | near[:, 1:-1] | near[:, 2:]
    rows, columns = (np.rint(np.arange(len(x)) / FINER).astype(int) for x in (alphas, betas))
    turned: Any = np.meshgrid(alphas, betas, indexing="ij")
    length = np.array(compute_lengths(ArrayNamespace(np), workspace.legs.plates, *turned))
    room = np.minimum(length.min(axis=0) - workspace.legs.shortest, workspace.legs.longest - length.max(axis=0))
    return (np.degrees(alphas), np.degrees(betas), np.where(near[np.ix_(rows, columns)], room, np.nan))


def _draw_control(axes: Any, printed: Printed) -> None:
    rows = (
        ("A", CYCLES, 0.0, "set A, no delay"),
        ("C", LAGGING, 0.0, "set C, no delay"),
        ("as-printed", SHOWN, DELAY, f"as printed, {DELAY:g} s delay"),
    )
    for key, sampling, delay, label in rows:
        result = loop.run_controlled(CASES[key], printed, sampling, delay)
        axes.plot(result.times, bench.angle_degrees(result), color=COLOURS[key], label=label)
    axes.axhline(printed.target, color=QUIET, linewidth=0.8, linestyle=(0, (1, 1.5)))
    axes.axhspan(printed.target - loop.BAND, printed.target, color=FAINT, linewidth=0.0)
    axes.set(xlim=(0.0, CYCLES.duration), ylim=(0.0, 36.0), xlabel="time [s]", ylabel="$α$ [°]")
    axes.set_title(f"ON/OFF control to {printed.target:.0f}°, {loop.BAND:g}° dead band")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.03))


def _draw_overshoot(axes: Any, printed: Printed) -> None:
    for key, sampling in (("as-printed", QUICK), ("C", LAGGING), ("A", CYCLES)):
        delays = {"as-printed": DELAYS, "A": (0.0, DELAY)}.get(key, (0.0,))
        overshoots = [
            loop.angle_overshoot(loop.run_controlled(CASES[key], printed, sampling, delay), printed) for delay in delays
        ]
        axes.plot(delays, overshoots, "o-", color=COLOURS[key], markersize=4.0)
        axes.annotate(
            "as printed" if key == "as-printed" else f"set {key}",
            (delays[-1], overshoots[-1]),
            xytext=(5, 6),
            textcoords="offset points",
            color=COLOURS[key],
        )
    axes.set(xlim=(-0.01, 0.58), ylim=(-0.1, 3.6), xlabel="delay of the measurement [s]")
    axes.set_ylabel("overshoot [°]")
    axes.set_title(f"overshoot over {printed.target:.0f}°")


def _draw_hysteresis(axes: Any, printed: Printed) -> None:
    whole = bench.run_heated(CASES["A"], printed, printed.high, 160.0, 0.02, until=80.0)
    axes.plot(*_hysteresis_path(whole), color=QUIET, linewidth=0.9, label="heated for 80 s, cooled")
    result = loop.run_controlled(CASES["A"], printed, CYCLES)
    temperature, fraction = _hysteresis_path(result)
    edges = [0, *(round(t / CYCLES.period) for t in loop.switching_times(result)), len(fraction) - 1]
    for k, (first, last) in enumerate(pairwise(edges)):
        on = k % 2 == 0
        axes.plot(
            temperature[first : last + 1],
            fraction[first : last + 1],
            linewidth=1.6,
            color=HEATING if on else COOLING,
            label=_describe_case(on) if k < 2 else None,
        )
    axes.set(ylim=(-0.03, 1.03), xlabel="temperature of the hot spring [°C]", ylabel="$ξ$")
    axes.set_title("martensite fraction, set A")
    axes.legend(loc="upper right")


def _hysteresis_path(result: Result) -> tuple[list[float], list[float]]:
    """Return the temperature [°C] and martensite fraction of the hot spring."""
    temperatures = [t - bench.ZERO for t in result["first.temperature"]]
    return temperatures, result.columns["first.martensite_fraction"].tolist()


def _describe_case(on: bool) -> str:
    return "ON/OFF: on" if on else "ON/OFF: off"
