"""Rise time, fall time, time to a fraction of the change, and time of the peak.

The change is that from the first row to the row farthest from it. A crossing that does not happen
is at an infinite time, and so is every crossing of a change that is rounding.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.simulate.measures.base import MEASURES, AbstractMeasure
from martensite.simulate.measures.run_table import Numbers, RunTable

Places: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]
LEAST = 1e-12, 1e-9
"""Least way, in SI and as a share of the largest sample."""


@MEASURES.register("rise-time")
class RiseTime(AbstractMeasure):
    """Time from 10 % to 90 % of the change; of several outputs the longest."""

    follows_curve = True

    low: Number = param("1", "share of the way at which it begins", low=0.0, high=1.0, default=0.1)
    high: Number = param("1", "share of the way at which it ends", low=0.0, high=1.0, default=0.9)

    def check(self) -> None:
        """Raise `ParameterError` unless the way goes somewhere."""
        if self.low >= self.high:
            raise ParameterError(
                f"Parameter `low` of `{self.registered_name}` must be below `high` "
                f"({self.high:g}), but is {self.low:g}."
            )

    def unit(self, unit: str) -> str:
        """Seconds."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """t(high) − t(low)."""
        begin, end = (self._crossing(table, share) for share in (self.low, self.high))
        return _measure_lasting(begin, end).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Derivatives of both crossings; 0 where one never happens."""
        begin, end = (self._crossing(table, share) for share in (self.low, self.high))
        lasting = _measure_lasting(begin, end)
        longest = np.arange(len(table.values))[:, None] == lasting.argmax(axis=0)
        counted = longest & np.isfinite(lasting)
        later = np.where(begin.time <= end.time, 1.0, -1.0)
        return (end.slopes() - begin.slopes()) * np.where(counted, later, 0.0)[:, None, :]

    def _crossing(self, table: RunTable, share: float) -> Crossing:
        """The last crossing of a share of the way before the turn."""
        return cross_outwards(table, share)


@MEASURES.register("fall-time")
class FallTime(RiseTime):
    """Time from nine tenths to a tenth of the way, back; infinite if it does not come back."""

    def _crossing(self, table: RunTable, share: float) -> Crossing:
        """The first crossing of a share of the way after the turn."""
        way = ColumnCrossings(table.values, share)
        found: Flags = (way.beyond[:, :-1] > 0.0) & (way.beyond[:, 1:] <= 0.0) & ~way.out
        return Crossing(table.times, way, np.where(found.any(axis=1), found.argmax(axis=1), -1))


@MEASURES.register("reach-time")
class ReachTime(AbstractMeasure):
    """Time from the start of the run to 90 % of the change; of several outputs the longest."""

    follows_curve = True

    share: Number = param("1", "share of the way that is reached", above=0.0, high=1.0, default=0.9)

    def unit(self, unit: str) -> str:
        """Seconds."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """t(share) − t(start)."""
        return (cross_outwards(table, self.share).time - table.times[0]).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Derivatives of the crossing that is last; 0 where it never happens."""
        found = cross_outwards(table, self.share)
        longest = np.arange(len(table.values))[:, None] == found.time.argmax(axis=0)
        return found.slopes() * longest[:, None, :]


@MEASURES.register("peak-time")
class PeakTime(AbstractMeasure):
    """Time from the start of the run to the largest change, on the parabola through three rows."""

    follows_curve = True

    def unit(self, unit: str) -> str:
        """Seconds."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """Where the slope is zero; of several outputs the longest time."""
        return (self._find_peaks(table)[0] - table.times[0]).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the derivatives by the farthest row and its neighbours; 0 for a peak at an end of the run."""
        when, place, slopes = self._find_peaks(table)
        longest = np.arange(len(table.values))[:, None] == when.argmax(axis=0)
        found = np.zeros(table.values.shape)
        for k, slope in enumerate(slopes):
            _add_sample(found, place + k - 1, slope * longest)
        return found

    def _find_peaks(self, table: RunTable) -> tuple[Numbers, Places, list[Numbers]]:
        """Return time, inner row next to it, and derivatives by three rows, of every column and run."""
        seen, times = table.values, np.broadcast_to(table.times, table.values.shape)
        turn: Places = np.abs(seen - seen[:, :1]).argmax(axis=1)
        place = np.clip(turn, 1, seen.shape[1] - 2)
        before, here, after = (_take_sample(seen, place + k) for k in (-1, 0, 1))
        begin, middle, end = (_take_sample(times, place + k) for k in (-1, 0, 1))
        first, second = middle - begin, end - middle
        smooth = (first > 0.0) & (second > 0.0)
        first, second = np.where(smooth, first, 1.0), np.where(smooth, second, 1.0)
        rise, fall = (here - before) / first, (after - here) / second
        bend = np.where(rise == fall, 1.0, rise - fall)
        inner = (turn == place) & (rise != fall) & smooth
        start, length = middle - 0.5 * first, 0.5 * (first + second)
        by_rise, by_fall = (np.where(inner, length * one / bend**2, 0.0) for one in (-fall, rise))
        slopes = [-by_rise / first, by_rise / first - by_fall / second, by_fall / second]
        return np.where(inner, start + length * rise / bend, _take_sample(times, turn)), place, slopes


def cross_outwards(table: RunTable, share: float) -> Crossing:
    """The last crossing of a share of the way before the turn."""
    way = ColumnCrossings(table.values, share)
    found: Flags = (way.beyond[:, :-1] <= 0.0) & (way.beyond[:, 1:] > 0.0) & way.out
    last: Places = found.shape[1] - 1 - found[:, ::-1].argmax(axis=1)
    return Crossing(table.times, way, np.where(found.any(axis=1), last, -1))


class Crossing:
    """When a share of the way is crossed, by column and run, in given intervals (−1: never)."""

    def __init__(self, times: Numbers, way: ColumnCrossings, place: Places) -> None:
        self.way, self.place, self.missing = way, np.maximum(place, 0), (place < 0) | way.none
        begin, end = (_take_sample(way.beyond, self.place + k) for k in (0, 1))
        apart = np.where(self.missing, 1.0, begin - end)
        runs = np.arange(times.shape[1], dtype=np.intp)
        length = np.diff(times, axis=0)[self.place, runs]
        when = times[self.place, runs] + begin / apart * length
        self.time = np.where(self.missing, np.inf, when)
        self.by_begin = -end / apart**2 * length
        self.by_end = begin / apart**2 * length

    def slopes(self) -> Numbers:
        """Derivatives of the time by every sample; 0 where it never is."""
        way, found = self.way, np.zeros(self.way.beyond.shape)
        level = -(self.by_begin + self.by_end)
        _add_sample(found, self.place, self.by_begin)
        _add_sample(found, self.place + 1, self.by_end)
        _add_sample(found, np.zeros_like(way.turn), level * (1.0 - way.share))
        _add_sample(found, way.turn, level * way.share)
        return found * np.where(self.missing, 0.0, way.sign)[:, None]


class ColumnCrossings:
    """The way of every column and run, and how far samples are beyond a share of it."""

    def __init__(self, seen: Numbers, share: float) -> None:
        gone = seen - seen[:, :1]
        self.share = share
        self.turn: Places = np.abs(gone).argmax(axis=1)
        furthest = _take_sample(gone, self.turn)
        least: Numbers = LEAST[0] + LEAST[1] * np.abs(seen).max(axis=1)
        self.none: Flags = np.abs(furthest) <= least
        """Whether it leads nowhere."""
        self.sign = np.where(furthest >= 0.0, 1.0, -1.0)
        self.beyond = (gone - share * furthest[:, None]) * self.sign[:, None]
        intervals = np.arange(seen.shape[1] - 1, dtype=np.intp)[None, :, None]
        self.out: Flags = intervals < self.turn[:, None, :]
        """Whether an interval is before the turn."""


def _take_sample(samples: Numbers, place: Places) -> Numbers:
    return np.take_along_axis(samples, place[:, None], axis=1)[:, 0]


def _add_sample(samples: Numbers, place: Places, more: Numbers) -> None:
    np.put_along_axis(samples, place[:, None], (_take_sample(samples, place) + more)[:, None], axis=1)


def _measure_lasting(begin: Crossing, end: Crossing) -> Numbers:
    """Time between two crossings; infinite if one is missing."""
    missing = begin.missing | end.missing
    times = (np.where(missing, 0.0, one.time) for one in (begin, end))
    return np.where(missing, np.inf, np.abs(np.subtract(*times)))
