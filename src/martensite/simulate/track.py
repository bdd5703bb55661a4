"""Tracks: outputs of runs at every accepted step, for measures and alarms.

A column follows the polynomial through the five nearest nodes on one side of a jump. The polynomial is used if its
fourth-order term is small in itself, or compared with the second-order term. It must also not overshoot the step
nodes by more than their second difference. Otherwise the column is linear. Peaks between nodes come from the
polynomial. Integrals use Simpson's rule over halves and the trapezoidal rule over whole steps. `recorded_track`
computes tracks.

Source: interpolation and quadrature, textbook (Stoer and Bulirsch, Introduction to Numerical Analysis).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.simulate.chords import bend_chords

Numbers: TypeAlias = NDArray[np.float64]
Places: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]
LOOKED_AT = 17
"""Number of points of a piece or a step in the search for extremes."""
POINTS = np.linspace(0.0, 1.0, LOOKED_AT)
"""Positions of these points."""
REFINED = 8
"""Number of candidate steps for a peak, with the highest estimates first."""
QUADRATURE = 0.25
"""Error of Simpson's rule over step length and fourth-order term: 0.14 if smooth, more at kinks."""
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
        selection = end[self.steps.rows].all(axis=1)
        rows = places[self.steps.rows[selection]]
        steps = StepRows(rows, self.steps.joined[selection], self.steps.plain[selection])
        selection = self.run[end], self.times[end], self.values[end], self.weights[end]
        return Track(*selection, steps, self.swinging, self.tolerance, self.bent)

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
        places: list[Places] = [np.where(late, rows[step, k + 1], rows[step, k]) for k in (0, 1)]
        first, last = (self.values[place] for place in places)
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
        both = self.find_peaks(0.0)
        return np.concatenate([one.step for one in both]), np.concatenate([one.share for one in both])

    def find_peaks(self, noticed: float = NOTICED) -> tuple[Peaks, Peaks]:
        """Return the maxima and the minima within steps that exceed all rows of their run.

        Args:
            noticed: smallest height above all rows, in tolerances.
        """
        values, count = np.concatenate([self.values, -self.values], axis=1), self.values.shape[1]
        peaks = replace(self, values=values, swinging=np.tile(self.swinging, 2))._find_maxima(noticed)
        high = peaks.column < count
        highest, lowest = (Peaks._make(column[some] for column in peaks) for some in (high, ~high))
        return highest, lowest._replace(column=lowest.column - count, value=-lowest.value)

    def _find_maxima(self, noticed: float) -> Peaks:
        """Return the maxima within steps that exceed all rows of their run by `noticed` tolerances."""
        rows, (places, numbers) = self.steps.rows, NOWHERE
        nothing = Peaks(places, places, places, numbers, numbers)
        if not len(rows):
            return nothing
        starts = np.flatnonzero(np.append(True, self.run[1:] != self.run[:-1]))
        own = np.searchsorted(self.run[starts], self.run[rows[:, 0]])
        least = np.maximum.reduceat(self.values, starts, axis=0)
        least = least + noticed * self.tolerance * np.ptp(self.values, axis=0)
        a, b, c = (self.values[rows[:, k]] for k in range(3))
        bend, rise = a - 2.0 * b + c, c - a
        turns = (bend < 0.0) & (np.abs(rise) < 2.0 * np.abs(bend))
        top = b - np.divide(rise * rise, 8.0 * bend, where=turns, out=np.zeros_like(b))
        most = np.maximum(np.maximum(a, b), c)
        hope = most + np.abs(bend) if self.bent else np.where(turns, 2.0 * top - most, -np.inf)
        step, column = np.nonzero(hope > least[own])
        return self._refine_peaks(step, column, hope, own, least) if len(step) else nothing

    def _refine_peaks(self, step: Places, column: Places, hope: Numbers, own: Places, least: Numbers) -> Peaks:
        """Return the highest peak above `least` in every run and column, from estimates at steps and columns."""
        key = column * len(least) + own[step]
        order = np.lexsort((-hope[step, column], key))
        order = order[np.arange(len(order)) - np.searchsorted(key[order], key[order]) < REFINED]
        step, column, key = step[order], column[order], key[order]
        shares, ranks = np.broadcast_to(POINTS, (len(step), LOOKED_AT)), np.arange(len(step))
        values = self._interpolate(step, shares, column[:, None])[:, :, 0]
        place = np.minimum(np.maximum(values.argmax(axis=1), 1), LOOKED_AT - 2)
        before, here, after = (values[ranks, place + k] for k in (-1, 0, 1))
        bend, rise = after - 2.0 * here + before, after - before
        inner = (bend < 0.0) & (np.abs(rise) < 2.0 * np.abs(bend))
        safe = np.where(inner, bend, -1.0)
        tops = np.where(inner, here - rise * rise / (8.0 * safe), -np.inf)
        order = np.lexsort((-tops, key))
        best = order[np.append(True, np.diff(key[order]) > 0)]
        best = best[tops[best] > least[own[step[best]], column[best]]]
        share = POINTS[place[best]] - 0.5 * rise[best] / safe[best] * POINTS[1]
        return Peaks(self.run[self.steps.rows[step[best], 0]], column[best], step[best], share, tops[best])

    def _interpolate(
        self, some: Places, shares: Numbers, columns: Sequence[int] | Places, otherwise: Numbers | None = None
    ) -> Numbers:
        """Return columns at positions within steps, (steps, places, columns).

        The columns are the same at all steps, or one at each step, (steps, 1). Without an accepted polynomial, the
        value is `otherwise`, or linear if None.
        """
        table = self.values[:, columns] if np.ndim(columns) == 1 else None

        def pick(rows: Places) -> Numbers:
            """Return the columns at rows, (steps, nodes) -> (steps, nodes, columns)."""
            return self.values[rows, columns][:, :, None] if table is None else table[rows]

        swinging, extent = self.swinging[columns], SMOOTH * self.tolerance * np.ptp(self.values, axis=0)[columns]
        rows, plain = self.steps.rows[some], self.steps.plain[some]
        times, values = self.times[rows], pick(rows)
        at = times[:, :1] + shares * (times[:, 2:] - times[:, :1])
        late = (shares > 0.5)[:, :, None]
        share = (2.0 * shares - (shares > 0.5))[:, :, None]
        ends, begins = (np.where(late, values[:, None, k + 1], values[:, None, k]) for k in (1, 0))
        samples = begins + share * (ends - begins) if otherwise is None else otherwise
        if self.bent:
            samples = samples + (plain[:, None] | ~swinging)[:, None] * self._bend(some, shares, pick)
        for ahead in (False, True):
            stencil, full = self._find_stencil(some, ahead)
            if full.any():
                curve, fourth = interpolate_nodes(self.times[stencil], pick(stencil), at, times)
                bend = np.abs(values[:, 0] - 2.0 * values[:, 1] + values[:, 2])
                good = full[:, None] & (fourth <= np.maximum(extent, CONVERGING * bend)) & (plain[:, None] | ~swinging)
                low, high = (values.min(axis=1) - bend)[:, None], (values.max(axis=1) + bend)[:, None]
                samples = np.where(good[:, None, :] & (low <= curve) & (curve <= high), curve, samples)
        return samples

    def _bend(self, some: Places, shares: Numbers, pick: Callable[[Places], Numbers]) -> Numbers:
        """Return the largest distance of columns from straight lines, (steps, places, columns)."""
        last = len(self.steps.rows) - 1
        before, after = np.maximum(some - 1, 0), np.minimum(some + 1, last)
        joined = np.stack(
            [self.steps.joined[some] & (before < some), self.steps.joined[after] & (after > some)], axis=1
        )
        rows = self.steps.rows
        nodes = np.concatenate([rows[before, 1:2], rows[some], rows[after, 1:2]], axis=1)
        return bend_chords(self.times[nodes], pick(nodes), joined, shares)

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
            stencil, full = self._find_stencil(some, ahead)
            nodes = self.times[stencil], self.values[stencil]
            fourth = interpolate_nodes(*nodes, times[:, :1], times)[1]
            worst = np.maximum(worst, np.where(full[:, None] & np.isfinite(fourth), fourth, 0.0))
        worst[:, self.swinging] *= self.steps.plain[:, None]
        lengths = times[:, 2] - times[:, 0]
        return np.einsum("s,sc->c", QUADRATURE * lengths, worst)

    def _find_stencil(self, some: Places, ahead: bool) -> tuple[Places, Flags]:
        """Return five nodes about steps, with the previous or next step, and flags for complete sets."""
        last = len(self.steps.rows) - 1
        other = np.minimum(some + 1, last) if ahead else np.maximum(some - 1, 0)
        rows, more = self.steps.rows[some], self.steps.rows[other]
        ratio = np.log(np.divide(*(self.times[one[:, 2]] - self.times[one[:, 0]] for one in (rows, more))))
        full = self.steps.joined[other if ahead else some] & (other != some) & (np.abs(ratio) < math.log(UNEVEN))
        stencil = np.concatenate([rows, more[:, 1:]] if ahead else [more[:, :2], rows], axis=1)
        return np.where(full[:, None], stencil, rows[:, [0, 0, 0, 1, 2]]), full


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
        curve = terms[4][:, None, :]
        for order in (3, 2, 1, 0):
            curve = terms[order][:, None, :] + (at - nodes[:, order : order + 1])[:, :, None] * curve
        quarters = step[:, :1] + np.array([0.25, 0.75]) * (step[:, 2:] - step[:, :1])
        reached = np.abs(np.prod(quarters[:, :, None] - nodes[:, None, :4], axis=2)).max(axis=1)
        fourth = np.abs(terms[4]) * reached[:, None]
    return curve, np.where(np.isfinite(fourth), fourth, np.inf)


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
