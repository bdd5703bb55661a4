"""Hysteresis loops, coloured by heating and cooling, with the strips of the law.

A segment of the path counts as heating where the temperature rises and as cooling where it
falls; where it rests, the sense before holds on. An arrow shows the way along the longest
run of either. The strips A_s…A_f and M_s…M_f are drawn where they lie at the mean stress,

    A_s + σ̄/C_A … A_f + σ̄/C_A,    M_f + σ̄/C_M … M_s + σ̄/C_M,

for laws that shift both strips in this way, which is for laws that have these parameters
and no critical stresses of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.plot.labels import axis, column, limits, mathematical
from martensite.plot.measured import Record, look, pairs
from martensite.plot.style import COOLING, HEATING, INK, QUIET
from martensite.simulate.result import Result

LOOPS = (
    ("temperature", "martensite_fraction"),
    ("temperature", "strain"),
    ("strain", "stress"),
)
"""What is drawn over what: (horizontal, vertical)."""
SENSES = ((1, "heating", HEATING), (-1, "cooling", COOLING), (0, "isothermal", INK))
_SHIFTED = ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M")
_CRITICAL = ("sigma_s", "sigma_f")
_CLOSE = 0.07
"""Share of the axis below which two labels would touch."""


@dataclass(frozen=True)
class StripMark:
    """One transformation strip on a temperature axis."""

    low: float
    high: float
    """Its limits at the mean stress [°C]."""
    low_name: str
    high_name: str
    colour: str


def senses(temperature: Sequence[float]) -> Any:
    """+1, -1 or 0 for every segment of a path: heating, cooling, no change so far."""
    signs = np.sign(np.diff(np.asarray(temperature, np.float64)))
    moved = np.flatnonzero(signs)
    if not moved.size:
        return signs
    last = np.searchsorted(moved, np.arange(signs.size), side="right") - 1
    return signs[moved[np.maximum(last, 0)]]


def runs(sense: Any) -> list[tuple[int, int, int]]:
    """(sense, first point, last point) of every stretch of one sense."""
    if not len(sense):
        return []
    cuts = [0, *(np.flatnonzero(np.diff(sense)) + 1).tolist(), len(sense)]
    return [(int(sense[a]), a, b) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]


def strips(result: Result) -> list[StripMark]:
    """The strips of the law at the mean stress of the run; none if it has no such strips."""
    law = result.system.element.law
    known = law.declarations
    if any(n not in known for n in _SHIFTED) or any(n in known for n in _CRITICAL):
        return []
    values = {leaf.path: leaf.value for leaf in law.leaves()}
    shown, stress = axis(result, "temperature"), float(np.mean(result["stress"]))

    def mark(low: str, high: str, slope: str, colour: str) -> StripMark:
        ends = [values[low] + stress / values[slope], values[high] + stress / values[slope]]
        return StripMark(*shown.values(ends).tolist(), low, high, colour)

    return [mark("A_s", "A_f", "C_A", HEATING), mark("M_f", "M_s", "C_M", COOLING)]


def draw_loops(
    panels: Sequence[Any], result: Result, records: Sequence[Record] = ()
) -> None:
    """Draw the three loops ξ–T, ε–T and σ–ε; the first carries legend and strip names."""
    for axes, (x, y) in zip(panels, LOOPS, strict=True):
        draw_loop(axes, result, x, y, records)
        if x == "temperature":
            draw_strips(axes, result, named=axes is panels[0])
    _legend(panels[0])


def draw_loop(
    axes: Any, result: Result, x: str, y: str, records: Sequence[Record] = ()
) -> None:
    """Draw one quantity over another, with arrows; measured records lie below."""
    points = column(result, x), column(result, y)
    found = pairs(result, records, x, y)
    for i, (_, *measured) in enumerate(found):
        label = "measured" if i == 0 else "_nolegend_"
        axes.plot(*measured, label=label, **{**look(len(measured[0]), i), "zorder": 1.5})
    stretches = runs(senses(result["temperature"]))
    axes.set_xlim(*limits(points[0], *(m[1] for m in found)))
    axes.set_ylim(*limits(points[1], *(m[2] for m in found)))
    for sense, label, colour in SENSES:
        own = [(a, b) for s, a, b in stretches if s == sense]
        if own:
            axes.plot(*_joined(points, own), color=colour, label=label, zorder=2.2)
            _arrow(axes, points, own, colour)
    axes.set_xlabel(axis(result, x).label)
    axes.set_ylabel(axis(result, y).label)


def draw_strips(axes: Any, result: Result, *, named: bool = True) -> None:
    """Mark the strips on a temperature axis, as far as they are in view."""
    marks = strips(result)
    left, right = axes.get_xlim()
    if marks:
        left = min(left, *(mark.low - 2.0 for mark in marks))
        right = max(right, *(mark.high + 2.0 for mark in marks))
        axes.set_xlim(left, right)
    for mark in marks:
        axes.axvspan(mark.low, mark.high, color=mark.colour, alpha=0.10, linewidth=0.0, zorder=0.5)
    if named and marks:
        _name_strips(axes, marks)
        axes.set_title(
            f"strips at the mean stress of {np.mean(column(result, 'stress')):.3g} MPa",
            loc="right", color=QUIET, fontsize=8.0, pad=18.0,
        )  # fmt: skip


def _joined(points: tuple[Any, Any], own: Sequence[tuple[int, int]]) -> list[Any]:
    """Both coordinates of all stretches, with a gap after each."""
    return [
        np.concatenate([np.append(c[a : b + 1], np.nan) for a, b in own]) for c in points
    ]


def _arrow(axes: Any, points: tuple[Any, Any], own: Sequence[tuple[int, int]], colour: str) -> None:
    """An arrowhead halfway along the longest stretch, as the eye measures length."""
    spans = np.diff(axes.get_xlim())[0], np.diff(axes.get_ylim())[0]
    scaled = np.stack([c / span for c, span in zip(points, spans, strict=True)])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(scaled, axis=1)))])
    first, last = max(own, key=lambda ends: way[ends[1]] - way[ends[0]])
    length = way[last] - way[first]
    if length < 0.1:
        return
    marks = way[first] + length * np.array([0.49, 0.52])
    tail, head = (tuple(float(np.interp(m, way, c)) for c in points) for m in marks)
    style = {"arrowstyle": "-|>,head_width=0.26,head_length=0.5", "color": colour, "lw": 0.0}
    axes.annotate("", head, tail, arrowprops={**style, "shrinkA": 0.0, "shrinkB": 0.0}, zorder=3.0)


def _name_strips(axes: Any, marks: Sequence[StripMark]) -> None:
    """Write A_s … M_f above the axes; the second row is used where names would touch."""
    left, right = axes.get_xlim()
    width = _CLOSE * (right - left)
    upper, lower = marks
    clash = min(abs(a - b) for a in _ends(upper) for b in _ends(lower)) < width
    for row, mark in enumerate(marks):
        narrow = mark.high - mark.low < width
        height = 1.02 + (0.075 if clash and row else 0.0)
        for place, name, side in (
            (mark.low, mark.low_name, "right"), (mark.high, mark.high_name, "left"),
        ):  # fmt: skip
            axes.text(
                place, height, mathematical(name), color=mark.colour, fontsize=8.5,
                ha=side if narrow else "center", va="bottom",
                transform=axes.get_xaxis_transform(),
            )  # fmt: skip


def _ends(mark: StripMark) -> tuple[float, float]:
    return mark.low, mark.high


def _legend(axes: Any) -> None:
    """Heating and cooling, above the axes on the left."""
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.1), ncols=4, borderpad=0.0, borderaxespad=0.0,
        columnspacing=1.2,
    )  # fmt: skip
