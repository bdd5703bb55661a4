"""Peaks of a calorimeter ramp: baseline, tangents and area.

The outer lines are least squares through the rows beside a group of peaks. The baseline below the group is

    sigmoid    from the line before to the line behind in proportion to the area so far
    line       straight from the end of the line before to the start of the line behind

Onset and endset are the intersections of the baseline with the tangents at the steepest rows of both flanks (ASTM
F2004, where lines are drawn by eye). For a Gaussian peak exp(-((T - T_p)/w)²) they lie √2 w from the peak. The
transformation enthalpy is the area over temperature of the apparent heat capacity above the baseline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.characterise.heat_ramps import HeatRamp
from martensite.characterise.loop_paths import estimate_scatter, smooth_rows
from martensite.characterise.straight_lines import fit_line

SIGMOID, LINE = "sigmoid", "line"
BASELINES = (SIGMOID, LINE)
SMALLEST = 0.08
"""Least height of a peak over the height of the largest peak of its ramp."""
CLEAR = 8.0
"""Least height of a peak, in standard deviations of the scatter."""
FOOT = 0.01
"""Height over the largest peak at which a group of peaks ends."""
MARGIN = 0.15
"""Further width at both ends of a group, relative to its width."""
OUTER = 4
"""Least number of rows of an outer line."""
STEEP = 0.9
"""Slope over the largest slope of a flank of the rows of its tangent."""
TURNS = 30
"""Repetitions of the sigmoid baseline."""


@dataclass(frozen=True)
class HeatPeak:
    """One peak of a ramp."""

    low: float
    """Intersection of the tangent of the cold flank with the baseline [K]."""
    peak: float
    """Temperature of the maximum [K]."""
    high: float
    """Intersection of the tangent of the hot flank with the baseline [K]."""
    enthalpy: float
    """Area above the baseline [J/kg]."""

    def to_dict(self) -> dict[str, float]:
        """Return all values by name, for JSON."""
        return {"low": self.low, "peak": self.peak, "high": self.high, "enthalpy": self.enthalpy}


@dataclass(frozen=True)
class RampPeaks:
    """Peaks of a ramp above their baseline."""

    ramp: HeatRamp
    sign: float
    """Factor of the file's heat flow that makes absorbed heat positive."""
    peaks: tuple[HeatPeak, ...]
    """In the order of temperature."""
    baseline: Any
    """(rows,) [J/kg/K]"""
    enthalpy: float
    """Area of all peaks [J/kg]."""
    other_enthalpy: float
    """Area above the other baseline [J/kg]."""
    cold: float
    """Apparent heat capacity at the cold end of the peaks [J/kg/K]."""
    hot: float
    """Apparent heat capacity at the hot end of the peaks [J/kg/K]."""
    span: tuple[float, float]
    """Cold and hot end of the peaks [K]."""

    @property
    def capacity(self) -> Any:
        """Return the apparent heat capacity, (rows,) [J/kg/K], with absorbed heat positive."""
        return self.sign * self.ramp.capacity


def find_sign(ramp: HeatRamp) -> float:
    """Return the factor of the file's heat flow for which the largest peak is positive."""
    smooth = smooth_rows(ramp.capacity)[0]
    over = smooth - _first_baseline(ramp.temperature, smooth)
    return 1.0 if over.max() >= -over.min() else -1.0


def find_peaks(ramp: HeatRamp, sign: float, baseline: str = SIGMOID) -> RampPeaks:
    """Return the peaks of a ramp.

    Raises:
        DataError: there is no peak, or the ramp begins or ends within a peak.
    """
    x, y = ramp.temperature, sign * ramp.capacity
    first, last, tops = _find_group(ramp, x, y)
    lines = [np.polyfit(x[rows], y[rows], 1) for rows in _outer_rows(first, last, len(x))]
    both = {name: _build_baseline(name, x, y, (first, last), lines) for name in BASELINES}
    areas = {name: float(np.trapezoid((y - z)[first : last + 1], x[first : last + 1])) for name, z in both.items()}
    base = both[baseline]
    over = smooth_rows(y - base)[0]
    peaks = tuple(_measure_peaks(x, y - base, over, (first, last), tops))
    other = next(name for name in BASELINES if name != baseline)
    ends = float(base[first]), float(base[last])
    span = float(x[first]), float(x[last])
    return RampPeaks(ramp, sign, peaks, base, areas[baseline], areas[other], *ends, span)


def _first_baseline(x: Any, y: Any) -> Any:
    """Return the line through most rows, without peaks, (rows,)."""
    return fit_line(x, y).value(x)


def _find_group(ramp: HeatRamp, x: Any, y: Any) -> tuple[int, int, list[int]]:
    """Return the first and the last row of the peaks, and the rows of their maxima."""
    from scipy.signal import find_peaks as find_maxima

    smooth = smooth_rows(y)[0]
    over = smooth - _first_baseline(x, smooth)
    top, scatter = float(over.max()), estimate_scatter(y)
    if not top > max(CLEAR * scatter, 1e-12):
        raise DataError(f"No transformation found on {ramp.label} of `{ramp.name}`: no peak stands out of the scatter.")
    least = max(SMALLEST * top, CLEAR * scatter)
    tops = [int(k) for k in find_maxima(over, height=least, prominence=0.5 * least)[0]]
    if not tops:
        raise _incomplete(ramp)
    # the foot is read against lines through the far rows of both sides
    foot = FOOT * top + 2.0 * scatter / math.sqrt(max(len(x) / 200.0, 1.0))
    first, last = tops[0], tops[-1]
    while first > 0 and over[first] > foot and not _rises_again(over, first, -1, top):
        first -= 1
    while last < len(x) - 1 and over[last] > foot and not _rises_again(over, last, 1, top):
        last += 1
    pad = int(MARGIN * (last - first))
    first, last = first - pad, last + pad
    if first < OUTER or last > len(x) - 1 - OUTER:
        raise _incomplete(ramp)
    return first, last, tops


def _rises_again(over: Any, row: int, way: int, top: float) -> bool:
    """Return whether the curve no longer falls towards an end of the ramp, well below the peak."""
    ahead = over[row + way * 8 if 0 <= row + way * 8 < len(over) else row]
    return bool(over[row] < 0.1 * top and ahead >= over[row])


def _outer_rows(first: int, last: int, count: int) -> tuple[slice, slice]:
    """Return the rows of the lines before and behind the peaks, at most as wide as the peaks."""
    wide = last - first
    return slice(max(first - wide, 0), first), slice(last + 1, min(last + 1 + wide, count))


def _build_baseline(name: str, x: Any, y: Any, ends: tuple[int, int], lines: list[Any]) -> Any:
    """Return the baseline of a ramp, (rows,)."""
    first, last = ends
    before, behind = (np.polyval(line, x) for line in lines)
    rows = np.arange(len(x))
    if name == LINE:
        chord = np.interp(x, x[[first, last]], [before[first], behind[last]])
        return np.where(rows < first, before, np.where(rows > last, behind, chord))
    done = np.clip((x - x[first]) / (x[last] - x[first]), 0.0, 1.0)
    for _ in range(TURNS):
        base = before + done * (behind - before)
        part = np.where((rows >= first) & (rows <= last), np.maximum(y - base, 0.0), 0.0)
        area = np.cumsum(part)
        if not area[-1] > 0.0:
            break
        done = area / area[-1]
    return before + done * (behind - before)


def _measure_peaks(x: Any, over: Any, smooth: Any, ends: tuple[int, int], tops: list[int]) -> list[HeatPeak]:
    """Return each peak of a group; areas are divided at the minima between peaks."""
    valleys = [a + int(np.argmin(smooth[a : b + 1])) for a, b in pairwise(tops)]
    edges = [ends[0], *valleys, ends[1]]
    peaks: list[HeatPeak] = []
    for first, last in pairwise(edges):
        top = first + int(np.argmax(smooth[first : last + 1]))
        near = slice(max(top - 2, first), min(top + 3, last + 1))
        bend, slope, _ = np.polyfit(x[near] - x[top], smooth[near], 2)
        peak = float(x[top] - 0.5 * slope / bend) if bend < 0.0 else float(x[top])
        low, high = _find_crossing(x, smooth, first, top), _find_crossing(x, smooth, top, last)
        area = float(np.trapezoid(over[first : last + 1], x[first : last + 1]))
        peaks.append(HeatPeak(low, peak, high, area))
    return peaks


def _find_crossing(x: Any, smooth: Any, first: int, last: int) -> float:
    """Return the temperature at which the tangent of a flank meets the baseline [K]."""
    slopes = np.abs(np.gradient(smooth, x))[first : last + 1]
    steep = int(np.argmax(slopes))
    begin = end = steep
    while begin > 0 and slopes[begin - 1] >= STEEP * slopes[steep]:
        begin -= 1
    while end < len(slopes) - 1 and slopes[end + 1] >= STEEP * slopes[steep]:
        end += 1
    begin, end = (max(begin - 1, 0), min(end + 1, len(slopes) - 1)) if end - begin < 2 else (begin, end)
    rows = slice(first + begin, first + end + 1)
    slope, level = np.polyfit(x[rows] - x[first + steep], smooth[rows], 1)
    return float(x[first + steep] - level / slope) if slope else float(x[first + steep])


def _incomplete(ramp: HeatRamp) -> DataError:
    return DataError(
        f"The {ramp.label} of `{ramp.name}` begins or ends within the peak, so that no baseline can be drawn; record a "
        "wider range."
    )
