"""Response curves: solid if stable, dotted if unstable, folds marked, sweeps as dots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.show.figures.panels import add_panels, write_headline
from martensite.show.figures.style import COOLING, HEATING, QUIET, make_figure, use_style
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.curves import FoldCurve
from martensite.simulate.steady.cycles import PeriodicOrbit
from martensite.simulate.steady.readable import choose_output, convert_speed, list_readable
from martensite.simulate.steady.rotations import ResponseCurve, ResponseSweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 10.0, 3.6
MARGINS = (0.7, 0.2, 0.71, 0.51)
WIDE_RATIO = 30.0
"""Smallest ratio of the ends of a logarithmic parameter axis."""


def plot_response(
    curve: ResponseCurve,
    sweeps: Sequence[ResponseSweep] = (),
    boundaries: Sequence[FoldCurve] = (),
    *,
    speed: str = "rpm",
    title: str = "",
) -> Figure:
    """Draw amplitude and speed of a rotor along a parameter, and the boundaries of its folds.

    Args:
        curve: the curve.
        sweeps: simulated sweeps, up first, then down.
        boundaries: curves of the folds over a second parameter.
        speed: unit of the rotor speed: rpm, rad/s or Hz.
        title: headline.
    """
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        (row,) = add_panels(figure, 1, 3 if boundaries else 2, MARGINS)
        write_headline(figure, title or f"Steady rotation over {curve.varied.name}")
        name = choose_output(curve)
        amplitude, unit = list_readable(curve.amplitude[name], curve.units[name])
        _draw_curve(row[0], curve, amplitude)
        row[0].set_title(f"amplitude of {name.replace('_', ' ')} [{unit}]")
        _draw_curve(row[1], curve, convert_speed(curve.speed, speed))
        row[1].set_title(f"speed of the rotor [{speed}]")
        row[1].set_yscale("log" if curve.speed.max() > 8.0 * curve.speed.min() else "linear")
        for sweep, tint, word, mark in zip(sweeps, (HEATING, COOLING), ("up", "down"), ("^", "v"), strict=False):
            across, _ = list_readable(sweep.parameter, curve.varied.unit)
            swung, _ = list_readable(sweep.amplitude[name], curve.units[name])
            turned = convert_speed(sweep.speed, speed)
            for axes, values in ((row[0], swung), (row[1], turned)):
                axes.plot(across, values, mark, color=tint, markersize=3.0, label=f"run {word}")
        if boundaries:
            _draw_boundaries(row[2], boundaries)
        row[0].legend(loc="best")
        return figure


def _draw_curve(axes: Any, curve: ResponseCurve, values: Numbers) -> None:
    across, unit = list_readable(curve.parameter, curve.varied.unit)
    for begin, end, stable in split_pieces(curve):
        dash, tint = ("-", "black") if stable else (":", QUIET)
        axes.plot(across[begin:end], values[begin:end], dash, color=tint, linewidth=1.3)
    axes.plot(
        across[curve.fold],
        values[curve.fold],
        "o",
        color="black",
        markersize=5.0,
        markerfacecolor="white",
        label="fold",
    )
    axes.set_xlabel(f"{curve.varied.name} [{unit}]")
    if across.min() > 0.0 and across.max() / across.min() > WIDE_RATIO:
        axes.set_xscale("log")


def split_pieces(curve: ResponseCurve) -> list[tuple[int, int, bool]]:
    """Return the pieces of the curve between folds and stability changes: begin, end, and stability."""
    stable, pieces, begin = curve.multiplier < 1.0, list[tuple[int, int, bool]](), 0
    for k in range(1, len(stable)):
        if curve.fold[k] or (stable[k] != stable[k - 1] and not curve.fold[k - 1]):
            middle = (begin + k) // 2
            pieces.append((begin, k + 1, bool(stable[middle])))
            begin = k
    pieces.append((begin, len(stable), bool(stable[(begin + len(stable)) // 2])))
    return pieces


def _draw_boundaries(axes: Any, boundaries: Sequence[FoldCurve]) -> None:
    for one in boundaries:
        (across, first), (up, second) = (
            list_readable(v, u) for v, u in zip((one.second, one.first), one.units[::-1], strict=True)
        )
        axes.plot(across, up, color="black", linewidth=1.3)
        axes.plot(across[one.cusp], up[one.cusp], "d", color="black")
        axes.set(xlabel=f"{one.names[1]} [{first}]", title=f"folds of {one.names[0]} [{second}]", yscale="log")


def plot_cycle(cycle: PeriodicOrbit, title: str = "") -> Figure:
    """Draw the main outputs of a limit cycle over time."""
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        units_of = {name: one.unit for name, one in cycle.system.outputs().items()}
        names = [name for name in cycle.system.convergence_scales() if np.ptp(cycle.outputs[name]) > 0.0][:3]
        (row,) = add_panels(figure, 1, max(len(names), 1), MARGINS)
        write_headline(figure, title or "Limit cycle")
        for axes, name in zip(row, names, strict=False):
            values, unit = list_readable(cycle.outputs[name], units_of[name])
            axes.plot(cycle.times, values, color=HEATING)
            axes.set(title=f"{name.replace('_', ' ')} [{unit}]", xlabel="$t$ [s]", xlim=(0.0, cycle.period))
        return figure
