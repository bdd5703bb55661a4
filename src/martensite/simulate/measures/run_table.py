"""Input of measures: the rows of many runs in one table, from tracks or stored samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.simulate.track import Track, weigh_trapezoids

Numbers: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RunTable:
    """Rows of runs in time order; shorter runs repeat their last row with zero weight."""

    times: Numbers
    """[s], (rows, runs); the same time on both sides of a jump."""
    values: Numbers
    """SI, (columns, rows, runs)"""
    weights: Numbers
    """Weight of every row in an integral over time [s], (rows, runs)."""
    highest: Numbers | None = None
    """Maximum of every column with peaks between rows, (columns, runs); None if only rows exist."""
    lowest: Numbers | None = None

    @property
    def durations(self) -> Numbers:
        """Return the length of every run [s], (runs,)."""
        return self.times[-1] - self.times[0]

    def thin(self, first: int) -> RunTable:
        """Return the first run without every second row, except at jumps and extremes.

        Args:
            first: 0 to omit the rows 0, 2, 4, …, 1 to omit the rows 1, 3, 5, ….
        """
        times, mask = self.times[:, 0], np.arange(len(self.times)) % 2 != first
        jumps = np.diff(times) == 0.0
        mask[0] = mask[-1] = True
        mask[:-1] |= jumps
        mask[1:] |= jumps
        mask[self.values[:, :, 0].argmax(axis=1)] = mask[self.values[:, :, 0].argmin(axis=1)] = True
        ends = (None if one is None else one[:, :1] for one in (self.highest, self.lowest))
        return RunTable(self.times[mask, :1], self.values[:, mask, :1], self.weights[mask, :1], *ends)

    def find_highest(self) -> Numbers:
        """Return the maximum of every column, (columns, runs)."""
        return self.values.max(axis=1) if self.highest is None else self.highest

    def find_lowest(self) -> Numbers:
        """Return the minimum of every column, (columns, runs)."""
        return self.values.min(axis=1) if self.lowest is None else self.lowest


def tabulate_samples(times: Numbers, values: Numbers) -> RunTable:
    """Return the table of stored samples, from times (samples,) and values (columns, samples, runs)."""
    wide = np.broadcast_to(np.asarray(times, float)[:, None], values.shape[1:])
    weights = np.broadcast_to(weigh_trapezoids(np.asarray(times, float))[:, None], values.shape[1:])
    return RunTable(wide, values, weights)


def tabulate_track(track: Track, columns: Sequence[int], runs: int, curve: bool) -> RunTable:
    """Return the table of a track.

    Args:
        track: track of `runs` runs; a run without rows has NaN values.
        columns: indices of the outputs.
        runs: number of runs.
        curve: True to include points between steps.
    """
    some = track.choose(columns)
    some = some.draw_curve() if curve and runs == 1 else some  # extremes have their own rows
    highest, lowest = find_extremes(some, runs)
    some = some.draw_curve() if curve and runs > 1 else some
    counts = np.bincount(some.run, minlength=runs)
    ends = np.cumsum(counts)
    number = np.arange(max(int(counts.max(initial=0)), 1))[:, None]
    place, inside = np.minimum(number, np.maximum(counts - 1, 0)) + (ends - counts), number < counts
    if not len(some.times):
        nothing = np.full((len(columns), 1, runs), np.nan)
        return RunTable(np.zeros((1, runs)), nothing, np.zeros((1, runs)), nothing[:, 0], nothing[:, 0])
    place = np.minimum(place, len(some.times) - 1)
    values = np.where(counts > 0, np.moveaxis(some.values[place], 2, 0), np.nan)
    return RunTable(some.times[place], values, np.where(inside, some.weights[place], 0.0), highest, lowest)


def find_extremes(track: Track, runs: int) -> tuple[Numbers, Numbers]:
    """Return the maximum and minimum of every output in every run, (outputs, runs); NaN without rows."""
    extremes = list[Numbers]()
    for sign, peaks in zip((1.0, -1.0), track.find_peaks(), strict=True):
        most = np.full((runs, track.values.shape[1]), -np.inf)
        if len(track.run):
            starts = np.flatnonzero(np.append(True, track.run[1:] != track.run[:-1]))
            most[track.run[starts]] = np.maximum.reduceat(sign * track.values, starts, axis=0)
        np.maximum.at(most, (peaks.run, peaks.column), sign * peaks.value)
        extremes.append(np.where(np.isinf(most), np.nan, sign * most).T)
    return extremes[0], extremes[1]
