r"""Tracks: outputs of runs at every accepted step, for measures and alarms.

Accepted steps are recorded in pieces: two halves with step size control, or one whole step of given length. A
record row holds

run, part, begin, length,  (after, before, mean, square, low, high, lapse) of each drive,  state at the end

`after` and `before` are the signals at both ends of the piece, without tones. Track rows lie at both ends of every
piece, at both sides of every drive jump, and at the levels of a switching drive. They therefore include pulses
between stored samples. A switching drive is replaced by four levels with its mean, mean square and extremes;
durations are exact but the order is not. A tone is evaluated at Gauss-Lobatto nodes and at its extremes.

A column follows the polynomial through the five nearest nodes on one side of a jump. The polynomial is used if its
fourth-order term is small in itself, or compared with the second-order term. It must also not overshoot the step
nodes by more than their second difference. Otherwise the column is linear. Peaks between nodes come from the
polynomial. Integrals use Simpson's rule over halves and the trapezoidal rule over whole steps. If one half has a
switching drive or a drive that starts near 0, the other half uses Gauss-Lobatto nodes.

Source: interpolation and quadrature, textbook (Stoer and Bulirsch, Introduction to Numerical Analysis).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.signals.base import AbstractWaveform
from martensite.simulate.chords import bend_chords
from martensite.simulate.marching import FIRST, SECOND, START, WHOLE

Numbers: TypeAlias = NDArray[np.float64]
Places: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]
Observe: TypeAlias = Callable[[Numbers, Numbers, Places], Numbers]
"""Function for outputs (rows, outputs) from states (rows, size), signals (rows, drives) and run indices."""
HEADER_SIZE = 4
"""Numbers of a record row before the drives."""
AFTER, BEFORE, MEAN, SQUARE, LOW, HIGH, LAPSE = range(7)
PER_DRIVE = 7
WEIGHTS = {WHOLE: (0.5, 0.5), FIRST: (1.0 / 3.0, 2.0 / 3.0), SECOND: (2.0 / 3.0, 1.0 / 3.0)}
"""Weights of both ends of a piece in an integral, as fractions of its length."""
JUMP = 1e-9
"""Relative change of a signal below which it does not jump."""
STEEP = 0.5
"""Relative change of a signal in a piece above which its shape is resolved."""
RESOLVED_ANGLE = 4.0
"""Largest phase [rad] of a tone in a piece for which its shape is resolved."""
FINE_ANGLE, FINE_ANGLE_OF_HALVES = 0.01, 0.02
"""Largest phase [rad] of a tone for which the ends of a whole step, or of its halves, suffice."""
LOBATTO = (0.08488805186071652, 0.2655756032646429, 0.5, 0.7344243967353571, 0.9151119481392835)
"""Inner nodes of the Gauss-Lobatto rule of seven points on [0, 1]."""
LOBATTO_WEIGHTS = (0.1384130236807830, 0.2158726906049313, 0.2438095238095238, 0.2158726906049313, 0.1384130236807830)
LOBATTO_END = 0.0238095238095238
"""Weight of both end points of the Gauss-Lobatto rule."""
LOOKED_AT = 17
"""Points of a piece or a step in the search for extremes."""
NEWTON = 4
"""Newton iterations for the turning point of a tone."""
REFINED = 8
"""Number of candidate steps for a peak, with the highest estimates first."""
QUADRATURE = 0.25
"""Error of Simpson's rule over step length and fourth-order term: 0.14 if smooth, more at kinks."""
MOST_PIECES = 50_000
"""Pieces of a record per evaluation of outputs."""
LAST = 1e9
"""Sort key of the row at the end of a piece."""
SMOOTH = 0.2
"""Largest accepted fourth-order term of a polynomial, in tolerances."""
UNEVEN = 8.0
"""Largest length ratio of two steps with a common polynomial."""
CONVERGING = 0.005
"""Largest fourth-order term that is always accepted, as a fraction of the second difference."""
TOLERANCE = 1e-4
"""Accepted error of runs without tolerance, as a fraction of the column range."""
NOTICED = 0.1
"""Smallest relevant height of a peak above all nodes, in tolerances."""
NOWHERE: tuple[Places, Numbers] = np.empty(0, np.intp), np.empty(0)
BETWEEN = (0.125, 0.25, 0.375, 0.625, 0.75, 0.875)
"""Relative positions in a step of additional curve points."""


def record_width(drives: int, size: int) -> int:
    """Return the length of a record row."""
    return HEADER_SIZE + PER_DRIVE * drives + size


def observe_on_floats(function: Callable[..., tuple[float, ...]], outputs: Sequence[int]) -> Observe:
    """Return the function that computes outputs of one run on plain floats."""
    places = list(outputs)

    def observe(states: Numbers, signals: Numbers, run: Places) -> Numbers:
        rows = np.concatenate([states, signals], axis=1).tolist()
        return np.array([function(*row) for row in rows], float)[:, places]

    return observe


def tabulate_tones(rows: Sequence[Sequence[AbstractWaveform]]) -> Numbers:
    """Return amplitude, angular frequency and phase of all tones, (runs or 1, drives, tones, 3), padded with 0."""
    most = max((len(wave.tones()) for row in rows for wave in row), default=0)
    found = np.zeros((len(rows), max((len(row) for row in rows), default=0), most, 3))
    for run, row in enumerate(rows):
        for drive, wave in enumerate(row):
            for place, tone in enumerate(wave.tones()):
                found[run, drive, place] = tone
    return found


@dataclass(frozen=True, eq=False)
class StepRows:
    """Rows of a track at the start, middle and end of every step with halves."""

    rows: Places
    """(steps, 3)"""
    joined: Flags
    """True if no jump separates the step from the previous step, (steps,)."""
    plain: Flags
    """True if no drive switches or oscillates within the step, (steps,)."""


class InnerRows(NamedTuple):
    """Rows between the nodes of steps with a switching or oscillating drive, (rows,) each."""

    row: Places
    step: Places
    share: Numbers
    """Position in the step, from 0 to 1."""


class Peaks(NamedTuple):
    """Peaks of columns within steps, (peaks,) each."""

    run: Places
    column: Places
    step: Places
    share: Numbers
    """Position in the step, from 0 to 1."""
    value: Numbers


@dataclass(frozen=True, eq=False)
class Track:
    """Outputs at every accepted step of one or more runs, grouped by run and in time order."""

    run: Places
    """(rows,)"""
    times: Numbers
    """[s], (rows,); the same time on both sides of a jump."""
    values: Numbers
    """SI, (rows, outputs)"""
    weights: Numbers
    """Weight of every row in an integral over time [s], (rows,)."""
    steps: StepRows
    swinging: Flags
    """True if an output depends on the signals, (outputs,)."""
    tolerance: float = TOLERANCE
    """Accepted error of the run, as a fraction of the column range."""
    bent: bool = False
    """True if columns without a polynomial deviate from straight lines by their bound (`bend_chords`)."""
    inner: InnerRows | None = None
    """Inner rows; None if unknown."""

    def cut(self, end: Flags) -> Track:
        """Return the track without some rows and their steps."""
        places = np.cumsum(end) - 1
        kept = end[self.steps.rows].all(axis=1)
        rows = places[self.steps.rows[kept]]
        steps = StepRows(rows, self.steps.joined[kept], self.steps.plain[kept])
        kept = self.run[end], self.times[end], self.values[end], self.weights[end]
        return Track(*kept, steps, self.swinging, self.tolerance, self.bent)

    def choose(self, columns: Sequence[int]) -> Track:
        """Return the track with selected outputs."""
        places = list(columns)
        return replace(self, values=self.values[:, places], swinging=self.swinging[places])

    def bend(self) -> Track:
        """Return the track with the largest possible curvature between nodes."""
        bent = replace(self, bent=True)
        return bent if self.inner is None else bent.follow_inner(self.inner)

    def follow_inner(self, inner: InnerRows) -> Track:
        """Return the track with columns without signals interpolated at inner rows."""
        values, quiet = self.values.copy(), np.flatnonzero(~self.swinging)
        at = inner.row[:, None], quiet[None, :]
        values[at] = self._interpolate(inner.step, inner.share[:, None], quiet.tolist(), values[at][:, None])[:, 0]
        return replace(self, values=values, inner=inner)

    def draw_curve(self, followed: Sequence[int] | None = None) -> Track:
        """Return the track with more rows within its steps.

        The `followed` columns (all if None) are interpolated by polynomials, others linearly. For a single run,
        rows are also added at extremes of these columns.
        """
        rows = self.steps.rows
        columns = list(range(self.values.shape[1]) if followed is None else followed)
        alone = len(self.run) > 0 and self.run[0] == self.run[-1]
        peaks = self.choose(columns)._place_peaks() if alone else NOWHERE
        inner = np.flatnonzero(self.steps.plain)
        step = np.concatenate([peaks[0], np.repeat(inner, len(BETWEEN))])
        share = np.concatenate([peaks[1], np.tile(BETWEEN, len(inner))])
        if not len(step):
            return self
        late = share > 0.5
        first, last = (self.values[np.where(late, rows[step, k + 1], rows[step, k])] for k in (0, 1))
        values = first + (2.0 * share - late)[:, None] * (last - first)
        values[:, columns] = self._interpolate(step, share[:, None], columns)[:, 0]
        start, end = self.times[rows[step, 0]], self.times[rows[step, 2]]
        times = start + share * (end - start)
        before = rows[step, 0] + np.where(share < 0.5, 0.0, rows[step, 1] - rows[step, 0]) + share
        for k in np.flatnonzero(~self.steps.plain[step]).tolist():  # existing rows between the nodes
            first, last = rows[step[k], 0].item(), rows[step[k], 2].item()
            before[k] = first + bisect_right(self.times[first:last].tolist(), times[k].item()) - 0.5
        at = np.argsort(np.concatenate([np.arange(len(self.times)), before]), kind="stable")
        nothing = StepRows(np.empty((0, 3), np.intp), np.empty(0, np.bool_), np.empty(0, np.bool_))
        return Track(
            np.concatenate([self.run, self.run[rows[step, 0]]])[at],
            np.concatenate([self.times, times])[at],
            np.concatenate([self.values, values])[at],
            np.concatenate([self.weights, np.zeros(len(step))])[at],
            nothing,
            self.swinging,
            self.tolerance,
        )

    def _place_peaks(self) -> tuple[Places, Numbers]:
        """Return step and position of the extremes of every column within steps."""
        both = [self.find_peaks(sign, 0.0) for sign in (1.0, -1.0)]
        return np.concatenate([one.step for one in both]), np.concatenate([one.share for one in both])

    def find_peaks(self, sign: float, noticed: float = NOTICED) -> Peaks:
        """Return the peaks within steps that exceed all rows of their run.

        Args:
            sign: 1 for maxima, -1 for minima.
            noticed: smallest height above all rows, in tolerances.
        """
        rows = self.steps.rows
        if not len(rows):
            places, numbers = NOWHERE
            return Peaks(places, places, places, numbers, numbers)
        starts = np.flatnonzero(np.append(True, self.run[1:] != self.run[:-1]))
        own = np.searchsorted(self.run[starts], self.run[rows[:, 0]])
        least = np.maximum.reduceat(sign * self.values, starts, axis=0)
        least = least + noticed * self.tolerance * np.ptp(self.values, axis=0)
        a, b, c = (sign * self.values[rows[:, k]] for k in range(3))
        bend, rise = a - 2.0 * b + c, c - a
        turns = (bend < 0.0) & (np.abs(rise) < 2.0 * np.abs(bend))
        top = b - np.divide(rise * rise, 8.0 * bend, where=turns, out=np.zeros_like(b))
        most = np.maximum(np.maximum(a, b), c)
        hope = most + np.abs(bend) if self.bent else np.where(turns, 2.0 * top - most, -np.inf)
        found = [self._refine_peaks(k, sign, hope[:, k], own, least[:, k]) for k in range(hope.shape[1])]
        return Peaks(*(np.concatenate(column) for column in zip(*found, strict=True)))

    def _refine_peaks(self, column: int, sign: float, hope: Numbers, own: Places, least: Numbers) -> Peaks:
        """Return the highest peak of a column above `least` in every run, from step estimates."""
        steps = np.flatnonzero(hope > least[own])
        steps = steps[np.lexsort((-hope[steps], own[steps]))]
        first = np.searchsorted(own[steps], own[steps])
        steps = steps[np.arange(len(steps)) - first < REFINED]
        points = np.linspace(0.0, 1.0, LOOKED_AT)
        values = sign * self._interpolate(steps, np.broadcast_to(points, (len(steps), LOOKED_AT)), [column])[:, :, 0]
        place = np.clip(values.argmax(axis=1), 1, LOOKED_AT - 2) if len(steps) else np.empty(0, np.intp)
        before, here, after = (values[np.arange(len(steps)), place + k] for k in (-1, 0, 1))
        bend, rise = after - 2.0 * here + before, after - before
        inner = (bend < 0.0) & (np.abs(rise) < 2.0 * np.abs(bend))
        safe = np.where(inner, bend, -1.0)
        tops = np.where(inner, here - rise * rise / (8.0 * safe), -np.inf)
        order = np.lexsort((-tops, own[steps]))
        best = order[np.append(True, np.diff(own[steps[order]]) > 0)[: len(order)]]
        best = best[tops[best] > least[own[steps[best]]]]
        share = points[place[best]] - 0.5 * rise[best] / safe[best] * points[1]
        runs, columns = self.run[self.steps.rows[steps[best], 0]], np.full(len(best), column, np.intp)
        return Peaks(runs, columns, steps[best], share, sign * tops[best])

    def _interpolate(
        self, some: Places, shares: Numbers, columns: Sequence[int] | None = None, otherwise: Numbers | None = None
    ) -> Numbers:
        """Return columns, all if None, at positions within steps, (steps, places, columns).

        Without an accepted polynomial, the value is `otherwise`, or linear if None.
        """
        table = self.values if columns is None else self.values[:, columns]
        swinging = self.swinging if columns is None else self.swinging[columns]
        rows, plain = self.steps.rows[some], self.steps.plain[some]
        times, values = self.times[rows], table[rows]
        at = times[:, :1] + shares * (times[:, 2:] - times[:, :1])
        late = (shares > 0.5)[:, :, None]
        share = (2.0 * shares - (shares > 0.5))[:, :, None]
        ends, begins = (np.where(late, values[:, None, k + 1], values[:, None, k]) for k in (1, 0))
        found = begins + share * (ends - begins) if otherwise is None else otherwise
        if self.bent:
            found = found + (plain[:, None] | ~swinging)[:, None] * self._bend(some, shares, table)
        extent = SMOOTH * self.tolerance * np.ptp(table, axis=0)
        for ahead in (False, True):
            stencil, known = self._find_stencil(some, ahead)
            if known.any():
                curve, fourth = interpolate_nodes(self.times[stencil], table[stencil], at, times)
                bend = np.abs(values[:, 0] - 2.0 * values[:, 1] + values[:, 2])
                good = known[:, None] & (fourth <= np.maximum(extent, CONVERGING * bend)) & (plain[:, None] | ~swinging)
                low, high = (values.min(axis=1) - bend)[:, None], (values.max(axis=1) + bend)[:, None]
                found = np.where(good[:, None, :] & (low <= curve) & (curve <= high), curve, found)
        return found

    def _bend(self, some: Places, shares: Numbers, table: Numbers) -> Numbers:
        """Return the largest distance of columns from straight lines, (steps, places, columns)."""
        last = len(self.steps.rows) - 1
        before, after = np.maximum(some - 1, 0), np.minimum(some + 1, last)
        joined = np.stack(
            [self.steps.joined[some] & (before < some), self.steps.joined[after] & (after > some)], axis=1
        )
        rows = self.steps.rows
        nodes = np.concatenate([rows[before, 1:2], rows[some], rows[after, 1:2]], axis=1)
        return bend_chords(self.times[nodes], table[nodes], joined, shares)

    def bound_quadrature(self) -> Numbers:
        """Return the error bounds of column integrals due to step length, (outputs,).

        They follow from the fourth-order terms of the node polynomials.
        """
        if not len(self.steps.rows):
            return np.zeros(len(self.swinging))
        some = np.arange(len(self.steps.rows))
        times = self.times[self.steps.rows]
        worst = np.zeros((len(some), len(self.swinging)))
        for ahead in (False, True):
            stencil, known = self._find_stencil(some, ahead)
            nodes = self.times[stencil], self.values[stencil]
            fourth = interpolate_nodes(*nodes, times[:, :1], times)[1]
            worst = np.maximum(worst, np.where(known[:, None] & np.isfinite(fourth), fourth, 0.0))
        worst[:, self.swinging] *= self.steps.plain[:, None]
        lengths = times[:, 2] - times[:, 0]
        return np.einsum("s,sc->c", QUADRATURE * lengths, worst)

    def _find_stencil(self, some: Places, ahead: bool) -> tuple[Places, Flags]:
        """Return five nodes about steps, with the previous or next step, and flags for complete sets."""
        last = len(self.steps.rows) - 1
        other = np.clip(some + 1 if ahead else some - 1, 0, last)
        rows, more = self.steps.rows[some], self.steps.rows[other]
        ratio = np.log(np.divide(*(self.times[one[:, 2]] - self.times[one[:, 0]] for one in (rows, more))))
        known = self.steps.joined[other if ahead else some] & (other != some) & (np.abs(ratio) < math.log(UNEVEN))
        stencil = np.concatenate([rows, more[:, 1:]] if ahead else [more[:, :2], rows], axis=1)
        return np.where(known[:, None], stencil, rows[:, [0, 0, 0, 1, 2]]), known


def interpolate_nodes(nodes: Numbers, values: Numbers, at: Numbers, step: Numbers) -> tuple[Numbers, Numbers]:
    """Interpolate columns by the polynomial through five nodes.

    Args:
        nodes: times [s], (steps, 5).
        values: (steps, 5, columns).
        at: evaluation times [s], (steps, places).
        step: start, middle and end of the step [s], (steps, 3).

    Returns:
        The columns, (steps, places, columns), and the largest fourth-order term in the step, (steps, columns).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        table = [values[:, k] for k in range(5)]
        terms = [table[0]]
        for order in range(1, 5):
            spans = (nodes[:, order:] - nodes[:, : 5 - order])[:, :, None]
            table = [(table[k + 1] - table[k]) / spans[:, k] for k in range(5 - order)]
            terms.append(table[0])
        found = terms[4][:, None, :]
        for order in (3, 2, 1, 0):
            found = terms[order][:, None, :] + (at - nodes[:, order : order + 1])[:, :, None] * found
        quarters = step[:, :1] + np.array([0.25, 0.75]) * (step[:, 2:] - step[:, :1])
        reached = np.abs(np.prod(quarters[:, :, None] - nodes[:, None, :4], axis=2)).max(axis=1)
        fourth = np.abs(terms[4]) * reached[:, None]
    return found, np.where(np.isfinite(fourth), fourth, np.inf)


def track_rows(times: Sequence[float], rows: Sequence[Sequence[float]], outputs: int) -> Track:
    """Return the track of one run from outputs at step ends, linear in between."""
    time = np.asarray(times, float)
    values = np.asarray(rows, float).reshape(len(time), -1)[:, :outputs]
    steps = StepRows(np.empty((0, 3), np.intp), np.empty(0, np.bool_), np.empty(0, np.bool_))
    return Track(np.zeros(len(time), np.intp), time, values, weigh_trapezoids(time), steps, np.ones(outputs, np.bool_))


def weigh_trapezoids(times: Numbers) -> Numbers:
    """Return the trapezoidal weights of all rows [s], of the same shape; rows are along axis 0."""
    widths = np.diff(times, axis=0)
    none = np.zeros_like(times[:1])
    return 0.5 * (np.concatenate([widths, none]) + np.concatenate([none, widths]))


# ---------------------------------------------------------------- rows from a record


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows within pieces: piece, order, position, weight and signals."""

    piece: Places
    order: Numbers
    share: Numbers
    weight: Numbers
    signals: Numbers
    """(rows, drives)"""


class _Pieces:
    """Pieces of a record."""

    def __init__(self, record: Numbers, drives: int, tones: Numbers) -> None:
        self.record, self.drives, self.tones = record, drives, tones
        self.run = record[:, 0].astype(np.intp)
        self.part, self.begin, self.length = record[:, 1].astype(np.intp), record[:, 2], record[:, 3]
        self.of_drives = record[:, HEADER_SIZE : HEADER_SIZE + PER_DRIVE * drives].reshape(-1, drives, PER_DRIVE)
        self.end_states = record[:, HEADER_SIZE + PER_DRIVE * drives :]
        self.begins = self.part == START
        self.angle = self._measure_angles()

    def _measure_angles(self) -> Numbers:
        """Return the largest phase of the tones of every drive in every piece [rad], (pieces, drives)."""
        if not self.tones.size:
            return np.zeros((len(self.run), self.drives))
        fastest = np.where(self.tones[..., 0] != 0.0, self.tones[..., 1], 0.0).max(axis=2)
        return fastest[self.run if len(fastest) > 1 else 0] * self.length[:, None]

    def sum_tones(self, pieces: Places, times: Numbers, drive: int) -> Numbers:
        """Return the sum of the tones of a drive at times [s] in pieces, of the same shape."""
        if not self.tones.size:
            return np.zeros(times.shape)
        own = self.tones[self.run[pieces] if len(self.tones) > 1 else np.zeros_like(pieces), drive]
        angles = own[..., 1] * times[..., None] + own[..., 2]
        return (own[..., 0] * np.cos(angles)).sum(axis=-1)

    def differentiate(self, pieces: Places, share: Numbers, drive: int) -> tuple[Numbers, Numbers]:
        """Return first and second derivative of a drive by relative position, within pieces."""
        own = self.tones[self.run[pieces] if len(self.tones) > 1 else np.zeros_like(pieces), drive]
        angles = own[..., 1] * (self.begin[pieces] + share * self.length[pieces])[:, None] + own[..., 2]
        swing, rate = own[..., 0], own[..., 1] * self.length[pieces][:, None]
        of_drive = self.of_drives[pieces, drive]
        rise = of_drive[:, BEFORE] - of_drive[:, AFTER] - (swing * rate * np.sin(angles)).sum(axis=1)
        return rise, -(swing * rate * rate * np.cos(angles)).sum(axis=1)

    def find_turns(self) -> Flags:
        """Return for every piece whether a drive with tones has a turning point in it."""
        found, every = np.zeros(len(self.run), np.bool_), np.arange(len(self.run))
        for drive in range(self.drives if self.tones.size else 0):
            first, last = (self.differentiate(every, np.full(len(every), end), drive)[0] for end in (0.0, 1.0))
            found |= first * last < 0.0
        return found & ~self.begins

    def refine_turns(self, pieces: Places, share: Numbers, drive: int) -> Numbers:
        """Return turning points of a drive with tones in pieces, by Newton's method from nearby positions."""
        near, found = 1.0 / (LOOKED_AT - 1), share
        for _ in range(NEWTON if self.tones.size else 0):
            rise, bend = self.differentiate(pieces, found, drive)
            step = np.divide(-rise, bend, where=bend != 0.0, out=np.zeros_like(rise))
            found = np.clip(found + step, share - near, share + near)
        return found

    def read_signals(self, pieces: Places, share: Numbers) -> Numbers:
        """Return the signals at positions within pieces without jumps, (rows, drives)."""
        own = self.of_drives[pieces]
        level = own[:, :, AFTER] + share[:, None] * (own[:, :, BEFORE] - own[:, :, AFTER])
        times = self.begin[pieces] + share * self.length[pieces]
        added = [self.sum_tones(pieces, times, drive) for drive in range(self.drives)]
        return level + np.stack(added, axis=1) if added else level

    def find_jumps(self) -> Flags:
        """Return for every piece whether a drive jumps at its start."""
        after, before = self.of_drives[:, :, AFTER], np.roll(self.of_drives[:, :, BEFORE], 1, axis=0)
        size = np.maximum(np.abs(after), np.abs(before))
        return (np.abs(after - before) > JUMP * size).any(axis=1) & ~self.begins

    def pair_halves(self, some: Flags) -> Flags:
        """Return pieces with the other half of their step."""
        first = (self.part == FIRST) & (np.roll(self.part, -1) == SECOND)
        second = np.roll(first, 1)
        return some | first & np.roll(some, -1) | second & np.roll(some, 1)

    def find_steep(self) -> Flags:
        """Return for every piece whether the relative change of a drive is large, as from 0."""
        after, before = self.of_drives[:, :, AFTER], self.of_drives[:, :, BEFORE]
        size = np.maximum(np.abs(after), np.abs(before))
        return (np.abs(after - before) > STEEP * size).any(axis=1) & ~self.begins

    def list_ends(self, first: Flags, varied: Flags, toned: Flags) -> list[_Rows]:
        """Return the rows at the ends of all pieces, and at the starts of the `first` ones.

        `varied` pieces have their weights in other rows, and `toned` pieces in part.
        """
        table = np.array([WEIGHTS[part] for part in (WHOLE, FIRST, SECOND, WHOLE)])  # the last is START
        weights = table[self.part] * np.where(varied | self.begins, 0.0, self.length)[:, None]
        weights[toned] = LOBATTO_END * self.length[toned, None]
        carried = ~first & ~self.begins  # end row of the previous piece
        at_end = weights[:, 1] + np.append(np.where(carried, weights[:, 0], 0.0)[1:], 0.0)
        places, ends = np.flatnonzero(first), np.arange(len(self.part))
        zeros, ones = np.zeros(len(places)), np.ones(len(ends))
        shares = np.where(self.begins, 0.0, ones)
        return [
            _Rows(places, zeros - 1.0, zeros, weights[places, 0], self.read_signals(places, zeros)),
            _Rows(ends, LAST * ones, ones, at_end, self.read_signals(ends, shares)),
        ]

    def place_states(self, pieces: Places, share: Numbers) -> Numbers:
        """Return the states at positions within pieces, by a parabola through the nodes of a step with halves."""
        at_start = (share == 0.0) & ~self.begins[pieces]
        found = self.end_states[pieces - at_start]
        inner = np.flatnonzero((share > 0.0) & (share < 1.0))
        if not len(inner):
            return found
        own, share, last = pieces[inner], share[inner], len(self.part) - 1
        first, second = (self.part[own] == part for part in (FIRST, SECOND))
        nodes = [self.end_states[k] for k in (own - 1 - second, own - second, np.minimum(own + first, last))]
        x = (2.0 * np.where(second, 0.5 + 0.5 * share, 0.5 * share) - 1.0)[:, None]
        curve = nodes[1] + 0.5 * x * (nodes[2] - nodes[0]) + 0.5 * x * x * (nodes[2] - 2.0 * nodes[1] + nodes[0])
        curve = np.clip(curve, np.minimum.reduce(nodes), np.maximum.reduce(nodes))
        line = nodes[0] + share[:, None] * (nodes[1] - nodes[0])
        found[inner] = np.where((first | second)[:, None], curve, line)
        return found

    def list_levels(self, places: Places) -> _Rows:
        """Return rows at the levels of switching drives within pieces."""
        own = self.of_drives[places]
        count, drives = len(places), self.drives
        levels, shares = spread_levels(own)
        cuts = np.cumsum(shares, axis=2)[:, :, :-1].reshape(count, -1)
        owner = np.repeat(np.arange(drives), 3)
        order = np.argsort(cuts, axis=1, kind="stable")
        passed = np.stack([np.cumsum(owner[order] == drive, axis=1) for drive in range(drives)], axis=1)
        passed = np.concatenate([np.zeros((count, drives, 1), np.intp), passed], axis=2)
        edges = np.concatenate([np.zeros((count, 1)), np.take_along_axis(cuts, order, 1), np.ones((count, 1))], axis=1)
        signals = np.moveaxis(np.take_along_axis(levels, passed, axis=2), 1, 2)  # (count, intervals, drives)
        intervals = signals.shape[1]
        share = np.stack([edges[:, :-1], edges[:, 1:]], axis=2)
        width = 0.5 * np.diff(edges, axis=1) * self.length[places, None]
        both = np.repeat(signals[:, :, None, :], 2, axis=2)
        plain = (own[:, :, LAPSE] <= 0.0)[:, None, None, :]
        line = (
            own[:, None, None, :, AFTER] + share[..., None] * (own[:, :, BEFORE] - own[:, :, AFTER])[:, None, None, :]
        )
        both = np.where(plain, line, both)
        return _Rows(
            np.repeat(places, 2 * intervals),
            np.tile(np.arange(2 * intervals, dtype=float), count),
            share.ravel(),
            np.repeat(width.ravel(), 2),
            both.reshape(-1, drives),
        )

    def list_tones(self, places: Places) -> list[_Rows]:
        """Return rows in pieces with resolved tones, at quadrature nodes and at extremes."""
        count, nodes = len(places), len(LOBATTO)
        piece, share = np.repeat(places, nodes), np.tile(LOBATTO, count)
        weight = np.tile(LOBATTO_WEIGHTS, count) * self.length[piece]
        found = [_Rows(piece, share, share, weight, self.read_signals(piece, share))]
        looked = np.linspace(0.0, 1.0, LOOKED_AT)
        wide = np.repeat(places, LOOKED_AT)
        signals = self.read_signals(wide, np.tile(looked, count)).reshape(count, LOOKED_AT, self.drives)
        for drive in range(self.drives):
            for sign in (1.0, -1.0):
                column = sign * signals[:, :, drive]
                top = column.argmax(axis=1)
                inner = (top > 0) & (top < LOOKED_AT - 1)
                a, b, c = (column[inner, top[inner] + k] for k in (-1, 0, 1))
                bend = np.minimum((c - b) - (b - a), -1e-300)
                at = looked[top[inner]] - 0.5 * (c - a) / bend * looked[1]
                own = places[inner]
                at = self.refine_turns(own, at, drive)
                found.append(_Rows(own, at, at, np.zeros(len(own)), self.read_signals(own, at)))
        return found

    def list_inner(self, piece: Places, share: Numbers) -> InnerRows:
        """Return the rows within steps with halves, from piece and position of all rows."""
        late = self.part == SECOND
        halved = late & (np.roll(self.part, 1) == FIRST)
        halved |= np.roll(halved, -1)
        row = np.flatnonzero(halved[piece] & (share > 0.0) & (share < 1.0))
        step = np.cumsum(halved & late) - (halved & late)
        return InnerRows(row, step[piece[row]], 0.5 * (share[row] + late[piece[row]]))

    def list_steps(self, ends: Places, starts: Places, jumps: Flags, varied: Flags, toned: Flags) -> StepRows:
        """Return the steps with halves, from the rows at the ends of all pieces."""
        second = np.flatnonzero((self.part == SECOND) & (np.roll(self.part, 1) == FIRST))
        first = second - 1
        rows = np.stack([starts[first], ends[first], ends[second]], axis=1)
        joined = ~jumps[first] & (self.part[first - 1] == SECOND) & ~varied[first - 1]
        filled = varied | toned
        return StepRows(rows, joined, ~(filled[first] | filled[second] | jumps[second]))


def spread_levels(moments: Numbers) -> tuple[Numbers, Numbers]:
    """Return four levels of drives and their durations, with given mean, mean square and extremes.

    Args:
        moments: moments of pieces and drives, (pieces, drives, PER_DRIVE).

    Returns:
        Ascending levels, and durations as fractions of the piece, both (pieces, drives, 4).
    """
    mean, square, low, high = (moments[:, :, k] for k in (MEAN, SQUARE, LOW, HIGH))
    centre, reach = 0.5 * (low + high), 0.5 * (high - low)
    safe = np.where(reach > 0.0, reach, 1.0)
    first = np.clip((mean - centre) / safe, -1.0, 1.0)
    second = np.clip((square - 2.0 * centre * mean + centre * centre) / (safe * safe), first * first, 1.0)
    outer = second >= np.abs(first)
    spread = np.sqrt(np.maximum(square - mean * mean, 0.0))
    inner = [np.where(outer, centre, np.clip(mean + k * spread, low, high)) for k in (-1.0, 1.0)]
    ends = [np.where(outer, 0.5 * (second + k * first), 0.0) for k in (-1.0, 1.0)]
    rest = 0.5 * (1.0 - ends[0] - ends[1])
    return np.stack([low, *inner, high], axis=2), np.stack([ends[0], rest, rest, ends[1]], axis=2)


def build_long_track(record: Numbers, build: Callable[[Numbers], Track]) -> Track:
    """Compute the track of one run in sections of its record to limit memory."""
    if len(record) <= MOST_PIECES:
        return build(record)
    cuts, tracks, first = [0], list[Track](), 0
    while cuts[-1] + MOST_PIECES < len(record):
        last = cuts[-1] + MOST_PIECES
        cuts.append(last + int(record[last - 1, 1] == FIRST))
    for begin, end in pairwise([*cuts, len(record)]):
        some = record[max(begin - 1, 0) : end].copy()
        if begin:
            some[0, 1], some[0, 2], some[0, 3] = START, some[0, 2] + some[0, 3], 0.0
        track = build(some)
        rows = StepRows(track.steps.rows + first, track.steps.joined, track.steps.plain)
        tracks.append(replace(track, steps=rows))
        first += len(track.times)
    joined = {
        name: np.concatenate([getattr(one, name) for one in tracks]) for name in ("run", "times", "values", "weights")
    }
    steps = StepRows(*(np.concatenate([getattr(one.steps, n) for one in tracks]) for n in ("rows", "joined", "plain")))
    return replace(tracks[0], steps=steps, inner=None, **joined)


def build_track(
    record: Numbers, drives: int, tones: Numbers, swinging: Flags, observe: Observe, tolerance: float = TOLERANCE
) -> Track:
    """Compute the outputs of runs at their accepted steps.

    Args:
        record: rows of all runs, grouped by run and in time order.
        drives: number of drives.
        tones: result of `tabulate_tones`.
        swinging: True for outputs that depend on signals, (outputs,).
        observe: function for outputs from states and signals.
        tolerance: accepted error of the runs, as a fraction of the column range.

    Returns:
        The track, with all outputs in SI.
    """
    pieces = _Pieces(record, drives, tones)
    asks, jumps = bool(swinging.any()), pieces.find_jumps()
    lapsed = (pieces.of_drives[:, :, LAPSE] > 0.0).any(axis=1) & ~pieces.begins
    fine = np.where(pieces.part == WHOLE, FINE_ANGLE, FINE_ANGLE_OF_HALVES)[:, None]
    turning = (pieces.angle > fine).any(axis=1) & ~pieces.begins
    followed = turning & (pieces.angle <= RESOLVED_ANGLE).all(axis=1)
    halved = pieces.pair_halves(pieces.find_steep() | pieces.find_turns() | lapsed)
    toned = (followed | halved & ~lapsed & ~turning) & asks
    varied = lapsed & ~followed & asks
    rows = pieces.list_ends(jumps & asks, varied, toned)
    if varied.any():
        rows.append(pieces.list_levels(np.flatnonzero(varied)))
    if toned.any():
        rows += pieces.list_tones(np.flatnonzero(toned))
    piece, order, share, weight = (
        np.concatenate([getattr(one, name) for one in rows]) for name in ("piece", "order", "share", "weight")
    )
    signals = np.concatenate([one.signals for one in rows])
    at = np.lexsort((order, piece))
    piece, order, share, weight, signals = piece[at], order[at], share[at], weight[at], signals[at]
    run, states = pieces.run[piece], pieces.place_states(piece, share)
    times = pieces.begin[piece] + share * pieces.length[piece]
    ends = np.flatnonzero(order == LAST)
    starts = np.roll(ends, 1)
    firsts = np.flatnonzero(order == -1.0)
    starts[piece[firsts]] = firsts
    steps = pieces.list_steps(ends, starts, jumps, varied, toned)
    track = Track(run, times, observe(states, signals, run), weight, steps, swinging, tolerance)
    return track.follow_inner(pieces.list_inner(piece, share)) if len(rows) > 2 else track
