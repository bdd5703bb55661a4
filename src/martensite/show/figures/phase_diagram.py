"""Phase diagram of a law in the plane of temperature and stress.

A band lies between start and finish line of a transformation. Laws with the parameters A_s … C_M have straight bands,

    M_s + σ/C_M,  M_f + σ/C_M,     A_s + σ/C_A,  A_f + σ/C_A,

with σ_s, σ_f for detwinning under stress and for twinned martensite on cooling. They are drawn if an isobar of the law
confirms them. For all other laws, simulated isobars and the loading of cold twinned martensite give the lines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.physics.laws.base import AbstractLaw
from martensite.show.figures.labels import STRESS, TEMPERATURE, enclose_values, typeset_symbol
from martensite.show.figures.panels import draw_arrow, draw_start
from martensite.show.figures.style import COOLING, HEATING, QUIET
from martensite.simulate.path_layout import TWINNED
from martensite.simulate.point import PointResult
from martensite.simulate.transformation_points import Marks, find_isobar, find_loaded

BEGUN = 1e-5
"""Fraction of a transformation at a simulated start line."""
ISOBARS = 7
LEAST_STRESS = 200e6
"""Smallest upper end of the stress axis [Pa]."""
SHIFTED = ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M")
CRITICAL = ("sigma_s", "sigma_f")
ARROWS = 4
"""Largest number of legs with arrows."""


@dataclass(frozen=True)
class Line:
    """A line of the diagram."""

    name: str
    temperature: tuple[float, ...]
    """Temperatures [K]."""
    stress: tuple[float, ...]
    """Stresses [Pa]."""


@dataclass(frozen=True)
class Band:
    """A transformation between its two lines."""

    process: str
    """`forward`, `reverse`, `loading`, `cooling` or `orientation`."""
    start: Line
    finish: Line

    @property
    def colour(self) -> str:
        """Return vermilion for heating, blue for cooling or stress."""
        return HEATING if self.process == "reverse" else COOLING


def find_bands(law: AbstractLaw, highest: float, coldest: float) -> list[Band]:
    """Return the bands of a law up to a stress [Pa], horizontal ones from a temperature [K] on."""
    values = {leaf.path: leaf.value for leaf in law.leaves()}
    if all(name in values for name in SHIFTED) and confirm_lines(law, values):
        if all(name in values for name in CRITICAL):
            return _find_detwinning(values, highest, coldest)
        return [_shift_band(values, highest, *names) for names in _STRIPS]
    return find_driven_bands(law, np.linspace(0.0, highest, ISOBARS).tolist(), coldest)


_STRIPS = (("forward", "M_s", "M_f", "C_M"), ("reverse", "A_s", "A_f", "C_A"))


def confirm_lines(law: AbstractLaw, values: dict[str, float]) -> bool:
    """Return whether isobars of the law agree with its parameters.

    At 1 % and 99 % a cosine law is 6 % of its interval away from the lines.
    """
    critical = any(name in values for name in CRITICAL)

    def near(found: Marks, stress: float, low: str, high: str, slope: str) -> bool:
        room = 0.08 * (values[high] - values[low]) + 0.1
        shift = stress / values[slope]
        return all(abs(getattr(found, n) - values[n] - shift) < room for n in (low, high))

    stress = 100e6
    at_rest, pulled = find_isobar(law, 0.0), find_isobar(law, stress)
    forward = near(at_rest, 0.0, "M_f", "M_s", "C_M")
    if not critical:
        forward = forward and near(pulled, stress, "M_f", "M_s", "C_M")
    return forward and near(pulled, stress, "A_s", "A_f", "C_A")


def _shift_band(values: dict[str, float], highest: float, process: str, start: str, finish: str, slope: str) -> Band:
    def line(name: str) -> Line:
        first = values[name]
        return Line(name, (first, first + highest / values[slope]), (0.0, highest))

    return Band(process, line(start), line(finish))


def _find_detwinning(values: dict[str, float], highest: float, coldest: float) -> list[Band]:
    M_s, M_f, C_M = values["M_s"], values["M_f"], values["C_M"]
    sigma_s, sigma_f = values["sigma_s"], values["sigma_f"]
    top = max(highest, sigma_f)

    def loading(name: str) -> Line:
        low = values[name]
        return Line(name, (coldest, M_s, M_s + (top - low) / C_M), (low, low, top))

    start, finish = loading("sigma_s"), loading("sigma_f")
    cooling = Line("M_s", (M_s, M_s), (0.0, sigma_s)), Line("M_f", (M_f, M_f), (0.0, sigma_f))
    return [Band("loading", start, finish), Band("cooling", *cooling), _shift_band(values, highest, *_STRIPS[1])]


def find_driven_bands(law: AbstractLaw, stresses: Sequence[float], coldest: float) -> list[Band]:
    """Return bands from isobars [Pa] and from cold loading."""
    table = {stress: find_isobar(law, stress, BEGUN) for stress in stresses}

    def line(name: str) -> Line:
        entries = [(getattr(m, name), s) for s, m in table.items() if math.isfinite(getattr(m, name))]
        return Line(name, tuple(t for t, _ in entries), tuple(s for _, s in entries))

    bands = [Band(process, line(start), line(finish)) for process, start, finish, _ in _STRIPS]
    bands = [band for band in bands if len(band.start.stress) > 1 < len(band.finish.stress)]
    warmest = table[stresses[0]].M_f
    if law.has_twins and math.isfinite(warmest):
        bands += _find_orientation(law, min(coldest, warmest - 1.0), warmest)
    return bands


def _find_orientation(law: AbstractLaw, coldest: float, warmest: float) -> list[Band]:
    temperatures = coldest, warmest
    ends = [[find_loaded(law, round(t, 6), TWINNED, share) for t in temperatures] for share in (BEGUN, 1.0 - BEGUN)]
    lines = [
        Line(name, temperatures, tuple(point.stress for point in points if point is not None))
        for name, points in zip(CRITICAL, ends, strict=True)
    ]
    whole = all(len(line.stress) == len(temperatures) for line in lines)
    return [Band("orientation", *lines)] if whole else []


def draw_phase_diagram(
    axes: Any, law: AbstractLaw, results: Sequence[PointResult], colours: Sequence[Sequence[str]]
) -> None:
    """Draw the bands of a law, and paths with arrows; `colours` has one per leg of each path."""
    highest = max(LEAST_STRESS, 1.12 * max(max(r.stress) for r in results))
    coldest = min(min(r.temperature) for r in results) - 8.0
    hottest = max(max(r.temperature) for r in results) + 8.0
    bands = find_bands(law, highest, min(coldest, find_isobar(law).M_f - 15.0))
    unloaded = [line.temperature[0] for band in bands for line in (band.start, band.finish)]
    cold, hot = min([coldest, *unloaded]), max([hottest, *unloaded])
    ends = TEMPERATURE.values([cold, hot])
    axes.set_xlim(*enclose_values(ends))
    lowest = min(min(r.stress) for r in results)
    low, high = STRESS.values([min(lowest, 0.0), highest])
    axes.set(ylim=(low - 0.03 * (high - low), high), xlabel=TEMPERATURE.label, ylabel=STRESS.label)
    for band in bands:
        draw_band(axes, band)
    for result, colour in zip(results, colours, strict=True):
        draw_way(axes, result, colour)
    _name_lines(axes, bands)


def draw_band(axes: Any, band: Band) -> None:
    """Fill a band and draw its lines: dashed at the start, solid at the finish."""
    sides = [(TEMPERATURE.values(line.temperature), STRESS.values(line.stress)) for line in (band.start, band.finish)]
    (x0, y0), (x1, y1) = sides
    x, y = np.concatenate([x0, x1[::-1]]), np.concatenate([y0, y1[::-1]])
    axes.fill(x, y, color=band.colour, alpha=0.12, linewidth=0.0, zorder=0.6)
    for (x, y), style in zip(sides, ("--", "-"), strict=True):
        axes.plot(x, y, style, color=band.colour, linewidth=0.9, alpha=0.8, zorder=0.9)


def draw_way(axes: Any, result: PointResult, colours: Sequence[str]) -> None:
    """Draw a path in the plane, with arrows on its first legs and a ring at its start."""
    x, y = TEMPERATURE.values(result.temperature), STRESS.values(result.stress)
    draw_start(axes, x, y)
    for leg, (first, last) in enumerate(pairwise(result.ends)):
        a, b = x[first : last + 1], y[first : last + 1]
        axes.plot(a, b, color=colours[leg], linewidth=1.5, zorder=2.4)
        if leg < ARROWS:
            draw_arrow(axes, a, b, colours[leg])


def _name_lines(axes: Any, bands: Sequence[Band]) -> None:
    (left, right), (_, top) = axes.get_xlim(), axes.get_ylim()
    taken: list[tuple[float, float]] = []
    for band in bands:
        for line in (band.start, band.finish):
            x, y = TEMPERATURE.values(line.temperature), STRESS.values(line.stress)
            if line.name in CRITICAL:
                place = left + 0.02 * (right - left), float(np.interp(left, x, y))
            else:
                level = 0.06 * top
                place = float(np.interp(level, y, x)), level
            near = 0.05 * (right - left), 0.05 * top
            if any(abs(place[0] - a) < near[0] and abs(place[1] - b) < near[1] for a, b in taken):
                place = place[0], place[1] + 0.07 * top
            taken.append(place)
            if left <= place[0] <= right and place[1] < top:
                name = typeset_symbol(line.name.replace("sigma", "σ"))
                axes.text(*place, name, color=band.colour, fontsize=8.5, va="bottom", zorder=2.0)
    if not bands:
        axes.text(0.5, 0.95, "no band in view", color=QUIET, transform=axes.transAxes, ha="center")
