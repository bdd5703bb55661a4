"""Hysteresis loops, coloured by heating and cooling, with the strips of the law.

The path is cut at the turning points of the temperature: heating leads up to one, cooling
down to one. A ripple of less than 4 % of the range (pulse-width modulation) is ignored. An
arrow shows the way along the longest run of either, a ring where the path begins. The
strips A_s…A_f and M_s…M_f are drawn where they lie at the mean stress,

    A_s + σ̄/C_A … A_f + σ̄/C_A,    M_f + σ̄/C_M … M_s + σ̄/C_M,

for laws that shift both strips in this way, which is for laws that have these parameters
and without critical stresses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np

from martensite.show.figures.labels import choose_limits, describe_axis, read_column, typeset_symbol
from martensite.show.figures.panels import draw_arrow, draw_start, measure_way
from martensite.show.figures.record_overlays import MeasuredRecord, pair_columns
from martensite.show.figures.style import COOLING, HEATING, INK, QUIET
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.result import Result

LOOPS = (("temperature", "martensite_fraction"), ("temperature", "strain"), ("strain", "stress"))
"""Quantities of the loops: (horizontal, vertical)."""
SENSES = ((1, "heating", HEATING, 2.0), (-1, "cooling", COOLING, 1.1), (0, "isothermal", INK, 1.3))
"""Sign of the change of temperature, name, colour, line width; the thin line lies on top."""
RIPPLE = 0.04
"""Fraction of the range of temperature below which a change is ignored."""
STILL = 1e-6
"""Range of temperature of an isothermal path [K]."""
_SHIFTED = ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M")
_CRITICAL = ("sigma_s", "sigma_f", "sigma_crit")
ROWS = (2.0, 13.0, 26.0)
"""Heights above the axes of names, second row of names, and legend [points]."""
SHORTEST = 0.1
"""Share of the axes below which a way is too short for an arrow."""
_CLOSE = 0.07
"""Share of the axis below which two labels would touch."""


@dataclass(frozen=True)
class StripMark:
    """One transformation strip on a temperature axis."""

    low: float
    high: float
    """Limits of the strip at the mean stress [°C]."""
    low_name: str
    high_name: str
    colour: str


def find_senses(temperature: Sequence[float] | Numbers) -> Any:
    """+1 (heating), -1 (cooling) or 0 (isothermal) for every of the n - 1 segments of a path of temperatures [K]."""
    ripple = max(RIPPLE * (max(temperature) - min(temperature)), STILL)
    senses = np.zeros(len(temperature) - 1, dtype=int)
    sense, turn, low, high = 0, 0, 0, 0
    for i, value in enumerate(temperature):
        low = i if value < temperature[low] else low
        high = i if value > temperature[high] else high
        if sense <= 0 and value - temperature[low] > ripple:
            senses[turn:low] = sense
            sense, turn, high = 1, low if sense else 0, i
        elif sense >= 0 and temperature[high] - value > ripple:
            senses[turn:high] = sense
            sense, turn, low = -1, high if sense else 0, i
    senses[turn:] = sense
    return senses


def split_runs(sense: Any) -> list[tuple[int, int, int]]:
    """(sense, first point, last point) of every stretch of one sense."""
    if not len(sense):
        return []
    cuts = [0, *(np.flatnonzero(np.diff(sense)) + 1).tolist(), len(sense)]
    return [(int(sense[a]), a, b) for a, b in pairwise(cuts)]


def find_strips(result: Result) -> list[StripMark]:
    """Return the strips of the law at the mean stress of the run; none if it has no such strips."""
    (actuator,) = result.system.actuators().values()
    law = actuator.element.law
    declarations = law.declarations
    curved = getattr(law, "surfaces", "") == "curved"
    if curved or any(n not in declarations for n in _SHIFTED) or any(n in declarations for n in _CRITICAL):
        return []
    values = {leaf.path: leaf.value for leaf in law.leaves()}
    axis, stress = describe_axis(result, "temperature"), float(np.mean(result["stress"]))

    def mark(low: str, high: str, slope: str, colour: str) -> StripMark:
        ends = axis.values([values[name] + stress / values[slope] for name in (low, high)])
        return StripMark(float(ends[0]), float(ends[1]), low, high, colour)

    return [mark("A_s", "A_f", "C_A", HEATING), mark("M_f", "M_s", "C_M", COOLING)]


def draw_loops(panels: Sequence[Any], result: Result, records: Sequence[MeasuredRecord] = ()) -> None:
    """Draw the three loops ξ–T, ε–T and σ–ε; the first carries legend and strip names."""
    for axes, (x, y) in zip(panels, LOOPS, strict=True):
        draw_loop(axes, result, x, y, records)
        if x == "temperature":
            draw_strips(axes, result, named=axes is panels[0])
    _write_legend(panels[0])


def draw_loop(axes: Any, result: Result, x: str, y: str, records: Sequence[MeasuredRecord] = ()) -> None:
    """Draw one quantity over another, with arrows; measured records lie below."""
    points = read_column(result, x), read_column(result, y)
    overlays = pair_columns(result, records, x, y)
    for *measured, look in overlays:
        axes.plot(*measured, label="_measured", **{**look, "zorder": 1.5})
    stretches = split_runs(find_senses(result.columns["temperature"]))
    axes.set_xlim(*choose_limits(x, points[0], *(m[0] for m in overlays)))
    axes.set_ylim(*choose_limits(y, points[1], *(m[1] for m in overlays)))
    for sense, label, colour, width in SENSES:
        own = [(a, b) for s, a, b in stretches if s == sense]
        if own:
            axes.plot(*_join_points(points, own), label=label, color=colour, linewidth=width, zorder=2.2)
            _mark_longest(axes, points, own, colour)
    draw_start(axes, *points, label="start")
    axes.set(xlabel=describe_axis(result, x).label, ylabel=describe_axis(result, y).label)


def draw_strips(axes: Any, result: Result, *, named: bool = True) -> None:
    """Mark the strips on a temperature axis, as far as they are in view."""
    marks = find_strips(result)
    left, right = axes.get_xlim()
    if marks:
        left = min(left, *(mark.low - 2.0 for mark in marks))
        right = max(right, *(mark.high + 2.0 for mark in marks))
        axes.set_xlim(left, right)
    for mark in marks:
        axes.axvspan(mark.low, mark.high, color=mark.colour, alpha=0.10, linewidth=0.0, zorder=0.5)
    if named and marks:
        _name_strips(axes, marks)
        mean = np.mean(read_column(result, "stress"))
        words = f"strips at the mean stress of {mean:.3g} MPa"
        _write_above(axes, 1.0, ROWS[2], words, color=QUIET, ha="right", fontsize=8.0)


def _join_points(points: tuple[Any, Any], own: Sequence[tuple[int, int]]) -> list[Any]:
    """Return both coordinates of all stretches, with a gap after each."""
    return [np.concatenate([np.append(c[a : b + 1], np.nan) for a, b in own]) for c in points]


def _mark_longest(axes: Any, points: tuple[Any, Any], own: Sequence[tuple[int, int]], colour: str) -> None:
    """An arrowhead on the flank of the longest stretch, as the eye measures length."""
    way = measure_way(axes, *points)
    first, last = max(own, key=lambda ends: way[ends[1]] - way[ends[0]])
    length = way[last] - way[first]
    if length >= SHORTEST:
        x, y = (c[first : last + 1] for c in points)
        spans = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
        flank = first + _find_flank(np.stack([x / spans[0], y / spans[1]]))
        draw_arrow(axes, x, y, colour, (way[flank] - way[first]) / length)


def _find_flank(scaled: Any) -> int:
    """Index of the point after 40 % of the way up or down, or across if it is level."""
    across, up = scaled[:, -1] - scaled[:, 0]
    if max(abs(across), abs(up)) < SHORTEST:
        return scaled.shape[1] // 2
    coordinate = scaled[1] if abs(up) >= SHORTEST else scaled[0]
    done = (coordinate - coordinate[0]) / (coordinate[-1] - coordinate[0])
    return max(int(np.argmax(done >= 0.4)) - 1, 0)


def _name_strips(axes: Any, marks: Sequence[StripMark]) -> None:
    """Write A_s … M_f above the axes; the second row is used where names would touch."""
    left, right = axes.get_xlim()
    width = _CLOSE * (right - left)
    upper, lower = marks
    ends = ((one.low, one.high) for one in (upper, lower))
    clash = min(abs(a - b) for a, b in product(*ends)) < width
    for row, mark in enumerate(marks):
        narrow = mark.high - mark.low < width
        sides = ((mark.low, mark.low_name, "right"), (mark.high, mark.high_name, "left"))
        for place, name, side in sides:
            share, points = (place - left) / (right - left), ROWS[row if clash else 0]
            look = {"color": mark.colour, "ha": side if narrow else "center", "fontsize": 8.5}
            _write_above(axes, share, points, typeset_symbol(name), **look)


def _write_above(axes: Any, x: float, points: float, text: str, **properties: Any) -> None:
    axes.annotate(
        text,
        (x, 1.0),
        (0.0, points),
        xycoords="axes fraction",
        textcoords="offset points",
        va="bottom",
        annotation_clip=False,
        **properties,
    )


def _write_legend(axes: Any) -> None:
    height = axes.get_position().height * axes.figure.get_figheight() * 72.0
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0 + ROWS[2] / height),
        ncols=4,
        borderpad=0.0,
        borderaxespad=0.0,
        columnspacing=1.2,
    )
