"""Rise time, fall time, time to a fraction of the change, and time of the peak.

The change is measured from the first row to the farthest row. A missing crossing, or a crossing of a change within
rounding, has an infinite time.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.simulate.measures.base import MEASURES, AbstractMeasure
from martensite.simulate.measures.run_table import Numbers, RunTable

Places: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]
LEAST_WAY = 1e-12, 1e-9
"""Smallest relevant change, in SI and as a fraction of the largest sample."""


@MEASURES.register("rise-time")
class RiseTime(AbstractMeasure):
    """Time from 10 % to 90 % of the change; of several outputs the longest."""

    follows_curve = seeks_turn = True

    low: Number = param("1", "share of the way at which it begins", low=0.0, high=1.0, default=0.1)
    high: Number = param("1", "share of the way at which it ends", low=0.0, high=1.0, default=0.9)

    def check(self) -> None:
        """Raise `ParameterError` unless the fractions of the change are valid."""
        if self.low >= self.high:
            raise ParameterError(
                f"Parameter `low` of `{self.registered_name}` must be below `high` "
                f"({self.high:g}), but is {self.low:g}."
            )

    def unit(self, unit: str) -> str:
        """Return the unit second."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """Return t(high) − t(low)."""
        begin, end = (self._crossing(table, share) for share in (self.low, self.high))
        return _measure_lasting(begin, end).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the derivatives of both crossings; 0 without a crossing."""
        begin, end = (self._crossing(table, share) for share in (self.low, self.high))
        lasting = _measure_lasting(begin, end)
        longest = np.arange(len(table.values))[:, None] == lasting.argmax(axis=0)
        counted = longest & np.isfinite(lasting)
        later = np.where(begin.time <= end.time, 1.0, -1.0)
        return (end.slopes() - begin.slopes()) * np.where(counted, later, 0.0)[:, None, :]

    def spread(self, table: RunTable, off: Numbers) -> float:
        """Return the error bound from both crossings."""
        levels = (self.low, self.high)
        return sum(measure_spread(lambda way: self._cross(table, way), table, share, off) for share in levels)

    def _crossing(self, table: RunTable, share: float) -> Crossing:
        """Return the crossing of a fraction of the change."""
        return self._cross(table, ColumnCrossings(table.values, share))

    def _cross(self, table: RunTable, way: ColumnCrossings) -> Crossing:
        """Return the last crossing before the turn."""
        return cross_outwards(table, way)


@MEASURES.register("fall-time")
class FallTime(RiseTime):
    """Time from nine tenths to a tenth of the way, back; infinite if it does not come back."""

    def _cross(self, table: RunTable, way: ColumnCrossings) -> Crossing:
        """Return the first crossing after the turn."""
        crossings: Flags = (way.beyond[:, :-1] > 0.0) & (way.beyond[:, 1:] <= 0.0) & ~way.out
        return Crossing(table.times, way, np.where(crossings.any(axis=1), crossings.argmax(axis=1), -1))


@MEASURES.register("reach-time")
class ReachTime(AbstractMeasure):
    """Time from the start of the run to 90 % of the change; of several outputs the longest."""

    follows_curve = seeks_turn = True

    share: Number = param("1", "share of the way that is reached", above=0.0, high=1.0, default=0.9)

    def unit(self, unit: str) -> str:
        """Return the unit second."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """Return t(share) − t(start)."""
        return (self._crossing(table).time - table.times[0]).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the derivatives of the last crossing; 0 without a crossing."""
        crossing = self._crossing(table)
        longest = np.arange(len(table.values))[:, None] == crossing.time.argmax(axis=0)
        return crossing.slopes() * longest[:, None, :]

    def spread(self, table: RunTable, off: Numbers) -> float:
        """Return the error bound of the crossing."""
        return measure_spread(lambda way: cross_outwards(table, way), table, self.share, off)

    def _crossing(self, table: RunTable) -> Crossing:
        return cross_outwards(table, ColumnCrossings(table.values, self.share))


@MEASURES.register("peak-time")
class PeakTime(AbstractMeasure):
    """Time from the start of the run to the largest change, on the parabola through three rows."""

    follows_curve = seeks_turn = True

    def unit(self, unit: str) -> str:
        """Return the unit second."""
        return "s"

    def value(self, table: RunTable) -> Numbers:
        """Return the time of zero derivative; the longest time for several outputs."""
        return (self._find_peaks(table)[0] - table.times[0]).max(axis=0)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the derivatives by the farthest row and its neighbours; 0 for a peak at a run end."""
        when, place, slopes = self._find_peaks(table)
        longest = np.arange(len(table.values))[:, None] == when.argmax(axis=0)
        derivatives = np.zeros(table.values.shape)
        for k, slope in enumerate(slopes):
            _add_sample(derivatives, place + k - 1, slope * longest)
        return derivatives

    def spread(self, table: RunTable, off: Numbers) -> float:
        """Return the distance of the peak from all times with a possibly larger change.

        Between two candidate rows the change follows a parabola with its turning point at the first.
        """
        change = np.abs(table.values - table.values[:, :1])[:, :, 0]
        level = change.max(axis=1, keepdims=True) - 2.0 * off[:, None]
        when, times, near = self._find_peaks(table)[0][:, 0], table.times[:, 0], change >= level
        farthest = np.where(near, np.abs(times - when[:, None]), 0.0).max(axis=1)
        for inner, outer in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            ends = near[:, inner] & ~near[:, outer]
            fall = np.where(ends, change[:, inner] - change[:, outer], 1.0)
            share = np.sqrt(np.clip((change[:, inner] - level) / fall, 0.0, 1.0))
            reached = times[inner] + share * (times[outer] - times[inner])
            farthest = np.maximum(farthest, np.where(ends, np.abs(reached - when[:, None]), 0.0).max(axis=1))
        return float(farthest.max())

    def _find_peaks(self, table: RunTable) -> tuple[Numbers, Places, list[Numbers]]:
        """Return time, inner row and derivatives by three rows of the peak, by column and run."""
        values, times = table.values, np.broadcast_to(table.times, table.values.shape)
        turn: Places = np.abs(values - values[:, :1]).argmax(axis=1)
        place = np.clip(turn, 1, values.shape[1] - 2)
        before, here, after = (_take_sample(values, place + k) for k in (-1, 0, 1))
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
        vertex = inner & (table.highest is None)  # otherwise a row lies at the peak
        return np.where(vertex, start + length * rise / bend, _take_sample(times, turn)), place, slopes


def cross_outwards(table: RunTable, way: ColumnCrossings) -> Crossing:
    """Return the last crossing before the turn."""
    crossings: Flags = (way.beyond[:, :-1] <= 0.0) & (way.beyond[:, 1:] > 0.0) & way.out
    last: Places = crossings.shape[1] - 1 - crossings[:, ::-1].argmax(axis=1)
    return Crossing(table.times, way, np.where(crossings.any(axis=1), last, -1))


def measure_spread(cross: Callable[[ColumnCrossings], Crossing], table: RunTable, share: float, off: Numbers) -> float:
    """Return the error bound of a crossing of the first run; infinite if the crossing may not exist.

    Args:
        cross: crossing of a change.
        table: table of the run.
        share: fraction of the change.
        off: error bounds of the values, (columns,). The turn may be at any row that is nearly the farthest.
    """
    here = ColumnCrossings(table.values, share)
    meant, ends = cross(here), here.find_turns(2.0 * off)
    crossings = [cross(here.shift(turn, level * off)) for turn in ends for level in (-2.0, 2.0)]
    with np.errstate(invalid="ignore"):
        apart = np.abs(np.stack([one.time[:, 0] for one in crossings]) - meant.time[:, 0])
    return float(np.where(np.isnan(apart), np.inf, apart).max())


class Crossing:
    """Crossing of a fraction of the change, by column and run, in given intervals (−1: never)."""

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
        """Return the derivatives of the time by every sample; 0 without a crossing."""
        way, derivatives = self.way, np.zeros(self.way.beyond.shape)
        level = -(self.by_begin + self.by_end)
        _add_sample(derivatives, self.place, self.by_begin)
        _add_sample(derivatives, self.place + 1, self.by_end)
        _add_sample(derivatives, np.zeros_like(way.turn), level * (1.0 - way.share))
        _add_sample(derivatives, way.turn, level * way.share)
        return derivatives * np.where(self.missing, 0.0, way.sign)[:, None]


class ColumnCrossings:
    """Changes by column and run, and distances of samples from a fraction of the change."""

    def __init__(self, values: Numbers, share: float) -> None:
        change = values - values[:, :1]
        self.share = share
        self.turn: Places = np.abs(change).argmax(axis=1)
        furthest = _take_sample(change, self.turn)
        least: Numbers = LEAST_WAY[0] + LEAST_WAY[1] * np.abs(values).max(axis=1)
        self.none: Flags = np.abs(furthest) <= least
        """True if the path leads nowhere."""
        self.sign = np.where(furthest >= 0.0, 1.0, -1.0)
        self.beyond = (change - share * furthest[:, None]) * self.sign[:, None]
        intervals = np.arange(values.shape[1] - 1, dtype=np.intp)[None, :, None]
        self.out: Flags = intervals < self.turn[:, None, :]
        """True if an interval is before the turn."""

    def find_turns(self, off: Numbers) -> tuple[Places, Places]:
        """Return the first and last row within `off` of the farthest, (columns, runs)."""
        level = _take_sample(self.beyond, self.turn) - off[:, None]
        near = self.beyond >= level[:, None]
        return near.argmax(axis=1), near.shape[1] - 1 - near[:, ::-1].argmax(axis=1)

    def shift(self, turn: Places, off: Numbers) -> ColumnCrossings:
        """Return the change with another turn, to a level that is farther by `off`, (columns,)."""
        intervals = np.arange(self.out.shape[1], dtype=np.intp)[None, :, None]
        twin = copy(self)
        twin.turn, twin.out, twin.beyond = turn, intervals < turn[:, None, :], self.beyond - off[:, None, None]
        return twin


def _take_sample(samples: Numbers, place: Places) -> Numbers:
    return np.take_along_axis(samples, place[:, None], axis=1)[:, 0]


def _add_sample(samples: Numbers, place: Places, more: Numbers) -> None:
    np.put_along_axis(samples, place[:, None], (_take_sample(samples, place) + more)[:, None], axis=1)


def _measure_lasting(begin: Crossing, end: Crossing) -> Numbers:
    """Return the time between two crossings; infinite if one is missing."""
    missing = begin.missing | end.missing
    times = (np.where(missing, 0.0, one.time) for one in (begin, end))
    return np.where(missing, np.inf, np.abs(np.subtract(*times)))
