"""Automatic construction of three straight lines through a branch of an isobaric cycle.

The strain of a branch is nearly straight over temperature in cold martensite and in hot austenite, and steep between:

    cold, hot   least squares through the outer halves of the rows outside the transformation,
                without rows beyond 3.5 robust standard deviations
    steep       least squares through the steepest 40 % of the distance from line to line

The relative distance s = (ε - ε_cold)/(ε_hot - ε_cold) is smoothed by a running median and made monotone by isotonic
regression. The steep line meets the outer lines at start and finish. Rows outside depend on these, so the steps are
repeated until they settle, at most `PASSES` times. The first lines are the three-part division of the branch with the
least squares, among `CELLS` cells of equal width in temperature.

For a transformation with sharp corners the intersections are the corners. With round ends they lie inside: for a
cosine at 1/2 ± 1/π of its width (`COSINE`), slightly less because the steep line is a chord of finite length.

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
"""Fraction of the distance covered by the steep line."""
EDGE = 0.1
"""Excluded fraction of the distance at both ends of the steep line."""
FAR = 0.5
"""Fraction of the rows outside the transformation, counted from its end, that an outer line uses."""
CELLS = 100
"""Number of cells of equal temperature width in the search for the first three lines."""
FEWEST_STEEP = 4
"""Least number of rows of the steep line; neighbours are added if there are fewer."""
FLATTER = 1.0 / 3.0
"""Slope of an outer line relative to the steep line above which it is rejected."""
CLEAR = 5.0
"""Least transformation strain, in standard deviations about the outer lines."""
COSINE = math.pi / 2.0
"""Width of a cosine divided by the distance between the intersections of its tangent."""
BEGINNINGS = 11
"""Number of candidate starts of the steep line."""
NARROWEST = 0.2
"""Least gap of the outer lines, as a fraction of the gap in the middle."""
LEAST_STRAIN = 1e-6
"""Least transformation strain."""
PASSES = 30


@dataclass(frozen=True)
class BranchTangents:
    """Three lines of a branch with their intersections."""

    cold: StraightLine
    """Line of martensite."""
    steep: StraightLine
    hot: StraightLine
    """Line of austenite."""
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
        """Return the vertical distance of the outer lines at the half-way temperature [-]."""
        return float(self.cold.value(self.half) - self.hot.value(self.half))

    def room(self) -> tuple[float, float]:
        """Return the range beyond the transformation, cold and hot, as a fraction of its width [-]."""
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
    tangents = BranchTangents(cold, steep, hot, half, (float(kelvin[0]), float(kelvin[-1])))
    _check_lines(tangents, where)
    return tangents


def _is_straight(kelvin: Any, strain: Any) -> bool:
    """Return whether all rows lie on one line."""
    return bool(abs(strain - fit_line(kelvin, strain).value(kelvin)).max() < LEAST_STRAIN)


def _find_way(outer: tuple[StraightLine, StraightLine], middle: float, kelvin: Any, strain: Any, where: str) -> Any:
    """Return the distance from the cold to the hot line as a fraction, monotone over the rows."""
    cold, hot = outer
    gap = hot.value(middle) - cold.value(middle)
    if abs(gap) < LEAST_STRAIN:
        raise _no_transformation(where)
    sign = 1.0 if gap > 0.0 else -1.0
    # converging lines must not meet within the branch
    gaps = np.maximum(sign * (hot.value(kelvin) - cold.value(kelvin)), NARROWEST * abs(gap))
    return fit_isotonic(smooth_median(sign * (strain - cold.value(kelvin)) / gaps))


def _find_steepest(kelvin: Any, way: Any) -> slice:
    """Return the rows of the narrowest temperature range that covers `CORE` of the distance."""
    begins = np.linspace(EDGE, 1.0 - EDGE - CORE, BEGINNINGS)
    low, high = np.interp(begins, way, kelvin), np.interp(begins + CORE, way, kelvin)
    best = int(np.argmin(high - low))
    return _rows_between(kelvin, float(low[best]), float(high[best]))


def _rows_between(kelvin: Any, low: float, high: float) -> slice:
    """Return the rows within a temperature range, and neighbours if there are too few."""
    first = int(np.searchsorted(kelvin, low, "left"))
    last = int(np.searchsorted(kelvin, high, "right"))
    while last - first < FEWEST_STEEP:
        first, last = max(first - 1, 0), min(last + 1, kelvin.size)
    return slice(first, last)


def _outer_rows(kelvin: Any, end: float, side: str, where: str) -> slice:
    """Return the rows of an outer line: the outer half beyond an end of the transformation."""
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


# ---------------------------------------------------------------- error texts


def _check_lines(tangents: BranchTangents, where: str) -> None:
    """Raise `DataError` unless the outer lines are separate and flat compared with the steep line."""
    limit = FLATTER * abs(tangents.steep.slope)
    sides = (("cold", tangents.cold), ("hot", tangents.hot))
    steep = [side for side, line in sides if abs(line.slope) > limit]
    if len(steep) == 1:
        raise _incomplete_transformation(steep[0], where)
    scatter = max(tangents.cold.scatter, tangents.hot.scatter)
    if steep or abs(tangents.transformation_strain) < max(CLEAR * scatter, LEAST_STRAIN):
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
