"""Files of several instruments in one experiment, merged on the clock of the first.

Clocks with dates, or times of day, are compared. Without a clock, the offset maximises |correlation| of some quantity
of both files, which must reach 0.8 and exceed all distant lags. Values between samples are interpolated; outside its
own times a file has no values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError, InputError
from martensite.logs.cells import DAY, Numbers
from martensite.logs.lab_files import LabFile
from martensite.signals.records import Record

LEAST_CORRELATION = 0.8
"""Smallest |correlation| of two quantities that aligns two clocks."""
LAGS = 600
"""Number of coarse lags."""
OVERLAP = 0.4
"""Smallest overlap, relative to the shorter file."""


def merge_by_clock(files: Sequence[LabFile], offsets: Sequence[float] | None = None) -> LabFile:
    """Return files of one experiment merged on the times of the first.

    Args:
        files: results of `read_lab_file`.
        offsets: start of each further file on the first clock [s], if known.

    Raises:
        DataError: a file has no times, they do not overlap, or the offset is unknown.
    """
    _check_files(files, offsets)
    first, notes = files[0], list(files[0].notes)
    columns, si_units = dict(first.record.columns), dict(first.record.units)
    times = first.record.times
    listed, dropped = list(first.columns), list(first.dropped)
    for number, other in enumerate(files[1:], start=2):
        offset, reason = (offsets[number - 2], "as given") if offsets else find_offset(first, other)
        own = other.record.times + offset
        if np.count_nonzero((times >= own[0]) & (times <= own[-1])) < 2:
            raise DataError(
                f"`{other.path.name}` lasts from {own[0]:.6g} s to {own[-1]:.6g} s by the clock of "
                f"`{first.path.name}`, which ends at {times[-1]:.6g} s: they do not overlap."
            )
        notes.append(f"Zero of `{other.path.name}` is at {offset:.6g} s of `{first.path.name}`, {reason}.")
        notes += [f"`{other.path.name}`: {note}" for note in other.notes]
        for name in [name for name in other.record.columns if name != "time"]:
            new = name if name not in columns else f"{name}_{number}"
            columns[new] = _interpolate(times, own, other.record[name])
            si_units[new] = other.record.units[name]
        listed += [one for one in other.columns if one.name not in ("time", "-")]
        dropped += other.dropped
    name = "+".join(one.record.name for one in files)
    record = Record(name, columns, si_units, first.path, sum(one.record.dropped for one in files))
    form = "joined: " + "; ".join(f"{one.path.name}: {one.format}" for one in files)
    return replace(first, format=form, record=record, columns=tuple(listed), dropped=tuple(dropped), notes=tuple(notes))


def _check_files(files: Sequence[LabFile], offsets: Sequence[float] | None) -> None:
    if not files:
        raise InputError("No file is given; a merge needs at least one.")
    if offsets is not None and len(offsets) != len(files) - 1:
        raise InputError(f"There are {len(files) - 1} further files, but {len(offsets)} offsets.")
    untimed = next((one for one in files if not one.has_time), None)
    if untimed is not None and len(files) > 1:
        raise DataError(f"`{untimed.path.name}` has no times; only files with times are joined.")


def find_offset(first: LabFile, other: LabFile) -> tuple[float, str]:
    """Return the zero of the other file on the first clock [s], and the evidence.

    Raises:
        DataError: neither clocks nor quantities give the offset.
    """
    if first.start is not None and other.start is not None:
        if first.start >= DAY and other.start >= DAY:
            return other.start - first.start, "by the dates of both"
        apart = (other.start - first.start) % DAY
        return apart - DAY * (apart > DAY / 2), "by the times of day of both"
    best = max(_list_matches(first.record, other.record), default=(0.0, 0.0, "", ""))
    if best[0] < LEAST_CORRELATION:
        raise DataError(
            f"The offset between the clocks of `{first.path.name}` and `{other.path.name}` is unknown: one has no "
            'absolute time, and the files have no common quantity. Give the offset (`--offset "2.5 s"`).'
        )
    return best[1], f"estimated: `{best[2]}` and `{best[3]}` go together best there (correlation {best[0]:.2f})"


def _list_matches(one: Record, other: Record) -> list[tuple[float, float, str, str]]:
    """Return |correlation|, offset [s] and names of pairs of columns; shared names only, if there are any."""
    names = [n for n in one.columns if n != "time"], [n for n in other.columns if n != "time"]
    shared = [(n, n) for n in names[0] if n in names[1]]
    pairs = shared or [(a, b) for a in names[0] for b in names[1]]
    return [(*estimate_lag((one.times, one[a]), (other.times, other[b]), a == b), a, b) for a, b in pairs]


def estimate_lag(one: tuple[Numbers, Numbers], other: tuple[Numbers, Numbers], alike: bool) -> tuple[float, float]:
    """Return the largest correlation of two curves over time, and the lag of the second [s].

    It may be negative for curves of different quantities (not `alike`). It is zero if a distant lag fits equally well.
    """
    (times, values), (own, answer) = one, other
    short = min(np.ptp(times), np.ptp(own)) * OVERLAP
    low, high = times[0] - own[-1] + short, times[-1] - own[0] - short
    if not high > low or np.ptp(answer[np.isfinite(answer)]) == 0.0:
        return 0.0, 0.0
    lags = np.linspace(low, high, LAGS)
    strengths = np.array([_correlate_at(times, values, own, answer, lag) for lag in lags])
    strengths = strengths if alike else np.abs(strengths)
    peak = int(np.argmax(strengths))
    left = right = peak
    while left > 0 and strengths[left - 1] <= strengths[left]:
        left -= 1
    while right < LAGS - 1 and strengths[right + 1] <= strengths[right]:
        right += 1
    rivals = np.concatenate([strengths[:left], strengths[right + 1 :]])
    if rivals.size and 1.0 - rivals.max() ** 2 < 1.5 * (1.0 - strengths[peak] ** 2) + 0.005:
        return 0.0, 0.0
    step = float(lags[1] - lags[0])
    near = np.linspace(lags[peak] - step, lags[peak] + step, 101)
    finer = np.array([_correlate_at(times, values, own, answer, lag) for lag in near])
    finer = finer if alike else np.abs(finer)
    return float(finer.max()), float(near[int(np.argmax(finer))])


def _correlate_at(times: Numbers, values: Numbers, own: Numbers, answer: Numbers, lag: float) -> float:
    begin, end = max(times[0], own[0] + lag), min(times[-1], own[-1] + lag)
    grid = np.linspace(begin, end, 400)
    a, b = _interpolate(grid, times, values), _interpolate(grid, own + lag, answer)
    both = np.isfinite(a) & np.isfinite(b)
    if both.sum() < 50 or np.ptp(a[both]) == 0.0 or np.ptp(b[both]) == 0.0:
        return 0.0
    return float(np.corrcoef(a[both], b[both])[0, 1])


def _interpolate(grid: Numbers, times: Numbers, values: Numbers) -> Numbers:
    finite = np.isfinite(values)
    if not finite.any():
        return np.full(grid.size, math.nan)
    return np.interp(grid, times[finite], values[finite], left=math.nan, right=math.nan)
