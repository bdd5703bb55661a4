"""The circuit of a wire or a coil: a series resistor with a switch, or a switch with PWM."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from martensite.design.sizing.wire_ratings import WireRatings
from martensite.show.figures.style import HEATING, INK, QUIET, make_figure, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

WIDTH, HEIGHT = 7.0, 3.1
LOOPS = 7
"""Drawn turns of a coil."""


def plot_circuit(ratings: WireRatings) -> Figure:
    """Return both circuits of a wire on its supply, with component values."""
    cycle = ratings.cycle
    current = ratings.holding_current if cycle is None else cycle.current
    series, power = ratings.series_resistor(current)
    ways = (
        ("a resistor sets the current", f"{series:.3g} Ω\n{power:.2g} W" if series > 0.0 else "none", "on for a pulse"),
        (
            "or a PWM duty cycle sets the power",
            "",
            f"PWM {100.0 * min(ratings.duty(current), 1.0):.0f} %\nabove 100 Hz",
        ),
    )
    with use_style():
        figure = make_figure(WIDTH, HEIGHT)
        for k, (title, resistor, gate) in enumerate(ways):
            axes = figure.add_axes((0.02 + 0.5 * k, 0.02, 0.46, 0.92))
            axes.set(xlim=(0, 10), ylim=(0, 10))
            axes.set_axis_off()
            axes.set_title(title, loc="left")
            _draw_loop(axes, ratings, resistor, gate)
    return figure


def _draw_loop(axes: Axes, ratings: WireRatings, resistor: str, gate: str) -> None:
    line = {"color": INK, "linewidth": 1.1, "solid_capstyle": "round"}
    axes.plot([1.5, 1.5], [1.0, 4.4], **line)
    axes.plot([1.5, 1.5, 2.4], [5.0, 8.0, 8.0], **line)
    for y, half, width in ((5.0, 0.7, 1.1), (4.4, 0.35, 2.4)):  # a battery
        axes.plot([1.5 - half, 1.5 + half], [y, y], color=INK, linewidth=width)
    axes.text(0.1, 6.0, f"{ratings.wire.supply:.3g} V", color=INK)
    if resistor:
        axes.add_patch(_make_box(2.4, 7.65, 1.5, 0.7))
        axes.text(3.15, 8.6, resistor, ha="center", va="bottom", color=INK)
        axes.plot([3.9, 4.6], [8.0, 8.0], **line)
    else:
        axes.plot([2.4, 4.6], [8.0, 8.0], **line)
    coil = ratings.describe_coil()
    if coil is None:
        axes.plot([4.6, 7.2], [8.0, 8.0], color=HEATING, linewidth=2.6)
        shape = f"{1e3 * ratings.wire.length:.4g} mm"
    else:
        angles = [2.0 * math.pi * LOOPS * k / 240.0 for k in range(241)]
        along = [4.6 + 2.6 * k / 240.0 - 0.12 * math.sin(a) for k, a in enumerate(angles)]
        axes.plot(along, [8.0 + 0.35 * (1.0 - math.cos(a)) for a in angles], color=HEATING, linewidth=1.8)
        shape = f"{coil['turns']:.3g} × {1e3 * coil['mean_diameter']:.3g} mm"
    name = f"{ratings.size.name}, {shape}\n{ratings.strand.resistance:.3g} Ω"
    axes.text(5.3, 7.55, name, ha="center", va="top", color=HEATING)
    axes.plot([7.2, 8.0, 8.0], [8.0, 8.0, 5.6], **line)
    axes.add_patch(_make_box(7.45, 3.9, 1.1, 1.7))
    axes.text(8.0, 4.75, "MOS\nFET", ha="center", va="center", color=INK, fontsize="small")
    axes.annotate(
        gate, (7.45, 4.4), (4.1, 4.4), va="center", color=QUIET, arrowprops={"arrowstyle": "->", "color": QUIET}
    )
    axes.plot([8.0, 8.0, 1.5], [3.9, 1.0, 1.0], **line)
    axes.plot([4.4, 5.2], [1.0, 1.0], color=INK, linewidth=2.0)
    axes.text(4.8, 0.2, "ground, shared with the controller", ha="center", color=QUIET, fontsize="small")


def _make_box(x: float, y: float, width: float, height: float) -> Patch:
    from matplotlib.patches import Rectangle

    return Rectangle((x, y), width, height, fill=False, edgecolor=INK, linewidth=1.1)
