"""Three straight lines through one branch of an isobaric cycle, found automatically.

Over temperature the strain of a branch is nearly straight while all is martensite (cold), nearly
straight while all is austenite (hot), and steep in between. The lines:

    cold, hot   least squares through the outer halves of what lies outside the transformation,
                rows beyond 3.5 robust standard deviations left out
    steep       least squares through the steepest 40 % of the way from line to line

The way is the share s = (ε - ε_cold)/(ε_hot - ε_cold), made free of single spikes by a running
median and monotone by isotonic regression. Where the steep line meets the outer ones is the start
and the finish; since what lies outside depends on them, this is repeated until it settles,
`PASSES` times at most. It begins with the three lines that leave the least sum of squares of all
divisions of the branch in three, found among `CELLS` cells of equal width in temperature.

On a transformation that is straight from corner to corner the intersections are the corners. On one with round ends
they lie inside: those of a cosine at 1/2 ± 1/π of its width (`COSINE`), slightly less because the steep line is a chord
of finite length.

Source: the construction of ASTM F2082 and ASTM E3097, where lines are drawn by eye.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.characterise.straight_lines import (
    FEWEST,
    StraightLine,
    average_cells,
    fit_isotonic,
    fit_line,
    fit_three_lines,
    smooth_median,
    sort_by_temperature,
)

CORE = 0.4
"""Share of the way through which the steep line is fitted."""
EDGE = 0.1
"""Share of the way at either end that it keeps clear of."""
FAR = 0.5
"""Share of what lies outside the transformation, from its end on, that an outer line uses."""
CELLS = 100
"""Cells of equal width in temperature in which the first three lines are sought."""
FEWEST_STEEP = 4
"""Rows of the steep line; neighbours are taken in if there are fewer."""
FLATTER = 1.0 / 3.0
"""Slope of an outer line relative to the steep line above which it is rejected."""
CLEAR = 5.0
"""Transformation strain, in standard deviations about the outer lines, that counts as one."""
COSINE = math.pi / 2.0
"""Width of a cosine over the distance between its tangent's intersections."""
BEGINNINGS = 11
"""Places at which the steep line may begin."""
NARROWEST = 0.2
"""Least gap of the outer lines, as a share of that in the middle, in the reckoning of the way."""
LEAST_STRAIN = 1e-6
"""Transformation strain below which there is none."""
PASSES = 30


@dataclass(frozen=True)
class BranchTangents:
    """The three lines of a branch and what they say."""

    cold: StraightLine
    """Martensite."""
    steep: StraightLine
    hot: StraightLine
    """Austenite."""
    half: float
    """Temperature at which the strain is half-way between the outer lines [K]."""
    span: tuple[float, float]
    """Lowest and highest temperature of the branch [K]."""

    @property
    def low(self) -> float:
        """Return the intersection of the steep and the cold line [K]."""
        return self.steep.meets(self.cold)

    @property
    def high(self) -> float:
        """Return the intersection of the steep and the hot line [K]."""
        return self.steep.meets(self.hot)

    @property
    def transformation_strain(self) -> float:
        """Vertical distance of the outer lines at the half-way temperature [-]."""
        return float(self.cold.value(self.half) - self.hot.value(self.half))

    def room(self) -> tuple[float, float]:
        """Return the range beyond the transformation, cold and hot, as a share of its width [-]."""
        low, high = self.low, self.high
        return (low - self.span[0]) / (high - low), (self.span[1] - high) / (high - low)

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers by name, for JSON."""
        return {
            "low": self.low,
            "high": self.high,
            "half": self.half,
            "transformation_strain": self.transformation_strain,
            "cold": self.cold.to_dict(),
            "steep": self.steep.to_dict(),
            "hot": self.hot.to_dict(),
        }


def branch_tangents(temperatures: Any, strains: Any, where: str) -> BranchTangents:
    """Find the three lines of a branch of temperatures [K], in any order, and strains [-].

    Raises:
        DataError: the branch lacks a transformation, or contains only a part of it.
    """
    kelvin, strain = sort_by_temperature(temperatures, strains)
    cells = average_cells(kelvin, smooth_median(strain), CELLS)
    if cells[0].size < 3 * FEWEST or _is_straight(kelvin, strain):
        raise _no_transformation(where)
    cold, steep, hot = fit_three_lines(*cells)
    ends = (math.nan, math.nan)
    for _ in range(PASSES):
        way = _find_way((cold, hot), steep.at, kelvin, strain, where)
        steep = fit_line(kelvin, strain, _find_steepest(kelvin, way))
        before, ends = ends, (steep.meets(cold), steep.meets(hot))
        if not ends[0] < ends[1]:
            raise _no_transformation(where)
        if ends == before:
            break
        cold = fit_line(kelvin, strain, _outer_rows(kelvin, ends[0], "cold", where))
        hot = fit_line(kelvin, strain, _outer_rows(kelvin, ends[1], "hot", where))
    half = _find_half((cold, hot), kelvin, strain)
    found = BranchTangents(cold, steep, hot, half, (float(kelvin[0]), float(kelvin[-1])))
    _check_lines(found, where)
    return found


def _is_straight(kelvin: Any, strain: Any) -> bool:
    """Return whether all rows lie on one line."""
    return bool(abs(strain - fit_line(kelvin, strain).value(kelvin)).max() < LEAST_STRAIN)


def _find_way(outer: tuple[StraightLine, StraightLine], middle: float, kelvin: Any, strain: Any, where: str) -> Any:
    """Return the share of the way from the cold to the hot line, growing from row to row."""
    cold, hot = outer
    gap = hot.value(middle) - cold.value(middle)
    if abs(gap) < LEAST_STRAIN:
        raise _no_transformation(where)
    sign = 1.0 if gap > 0.0 else -1.0
    # lines that converge must not meet within the branch
    gaps = np.maximum(sign * (hot.value(kelvin) - cold.value(kelvin)), NARROWEST * abs(gap))
    return fit_isotonic(smooth_median(sign * (strain - cold.value(kelvin)) / gaps))


def _find_steepest(kelvin: Any, way: Any) -> slice:
    """Return the rows of the narrowest range of temperature in which `CORE` of the way is covered."""
    begins = np.linspace(EDGE, 1.0 - EDGE - CORE, BEGINNINGS)
    low, high = np.interp(begins, way, kelvin), np.interp(begins + CORE, way, kelvin)
    best = int(np.argmin(high - low))
    return _rows_between(kelvin, float(low[best]), float(high[best]))


def _rows_between(kelvin: Any, low: float, high: float) -> slice:
    """Return the rows within a range of temperature, and neighbours if there are fewer than needed."""
    first = int(np.searchsorted(kelvin, low, "left"))
    last = int(np.searchsorted(kelvin, high, "right"))
    while last - first < FEWEST_STEEP:
        first, last = max(first - 1, 0), min(last + 1, kelvin.size)
    return slice(first, last)


def _outer_rows(kelvin: Any, end: float, side: str, where: str) -> slice:
    """Return the rows of an outer line: the outer half of what lies beyond an end of the transformation."""
    from_edge = kelvin - kelvin[0] if side == "cold" else kelvin[-1] - kelvin[::-1]
    beyond = end - float(kelvin[0]) if side == "cold" else float(kelvin[-1]) - end
    count = int(np.searchsorted(from_edge, FAR * beyond, "right"))
    if count < FEWEST:
        if int(np.searchsorted(from_edge, beyond, "right")) < FEWEST:
            raise _incomplete_transformation(side, where)
        count = FEWEST
    return slice(None, count) if side == "cold" else slice(kelvin.size - count, None)


def _find_half(outer: tuple[StraightLine, StraightLine], kelvin: Any, strain: Any) -> float:
    """Return the temperature at which the strain passes the middle of the outer lines."""
    cold, hot = outer
    beyond = strain - 0.5 * (cold.value(kelvin) + hot.value(kelvin))
    sign = 1.0 if beyond[-1] > beyond[0] else -1.0
    return float(np.interp(0.0, fit_isotonic(smooth_median(sign * beyond)), kelvin))


# ---------------------------------------------------------------- what is wrong, in words


def _check_lines(found: BranchTangents, where: str) -> None:
    """Raise `DataError` unless the outer lines are flat beside the steep one, and apart."""
    limit = FLATTER * abs(found.steep.slope)
    sides = (("cold", found.cold), ("hot", found.hot))
    steep = [side for side, line in sides if abs(line.slope) > limit]
    if len(steep) == 1:
        raise _incomplete_transformation(steep[0], where)
    scatter = max(found.cold.scatter, found.hot.scatter)
    if steep or abs(found.transformation_strain) < max(CLEAR * scatter, LEAST_STRAIN):
        raise _no_transformation(where)


def _no_transformation(where: str) -> DataError:
    return DataError(
        f"No transformation found in {where}: the strain nowhere leaves a straight line in a step "
        "that stands out of the scatter; is the column the strain, and did the sample transform?"
    )


def _incomplete_transformation(side: str, where: str) -> DataError:
    phase, do = ("martensite", "cool") if side == "cold" else ("austenite", "heat")
    return DataError(
        f"The transformation in {where} is not complete: there is no straight {side} part "
        f"({phase}) beyond it; {do} further."
    )
