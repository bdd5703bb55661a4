"""Tracks from the record of the accepted steps of runs.

Accepted steps are recorded in pieces: two halves with step size control, or one whole step of given length. A
record row holds

run, part, begin, length,  (after, before, mean, square, low, high, lapse) of each drive,  state at the end

`after` and `before` are the signals at both ends of the piece, without tones. Track rows lie at both ends of every
piece, at both sides of every drive jump, and at the levels of a switching drive. They therefore include pulses
between stored samples. A switching drive is replaced by four levels with its mean, mean square and extremes;
durations are exact but the order is not. A tone is evaluated at Gauss-Lobatto nodes and at its extremes. If one half
has a switching drive or a drive that starts near 0, the other half uses Gauss-Lobatto nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.signals.base import AbstractWaveform
from martensite.simulate.marching import FIRST, SECOND, START, WHOLE
from martensite.simulate.track import LOOKED_AT, TOLERANCE, Flags, InnerRows, Numbers, Places, StepRows, Track

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
NEWTON = 4
"""Newton iterations for the turning point of a tone."""
MOST_PIECES = 50_000
"""Pieces of a record per evaluation of outputs."""
LAST = 1e9
"""Sort key of the row at the end of a piece."""


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
    table = np.zeros((len(rows), max((len(row) for row in rows), default=0), most, 3))
    for run, row in enumerate(rows):
        for drive, wave in enumerate(row):
            for place, tone in enumerate(wave.tones()):
                table[run, drive, place] = tone
    return table


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
        turns, every = np.zeros(len(self.run), np.bool_), np.arange(len(self.run))
        for drive in range(self.drives if self.tones.size else 0):
            first, last = (self.differentiate(every, np.full(len(every), end), drive)[0] for end in (0.0, 1.0))
            turns |= first * last < 0.0
        return turns & ~self.begins

    def refine_turns(self, pieces: Places, share: Numbers, drive: int) -> Numbers:
        """Return turning points of a drive with tones in pieces, by Newton's method from nearby positions."""
        near, turns = 1.0 / (LOOKED_AT - 1), share
        for _ in range(NEWTON if self.tones.size else 0):
            rise, bend = self.differentiate(pieces, turns, drive)
            step = np.divide(-rise, bend, where=bend != 0.0, out=np.zeros_like(rise))
            turns = np.clip(turns + step, share - near, share + near)
        return turns

    def read_signals(self, pieces: Places, share: Numbers) -> Numbers:
        """Return the signals at positions within pieces without jumps, (rows, drives)."""
        own = self.of_drives[pieces]
        level = own[:, :, AFTER] + share[:, None] * (own[:, :, BEFORE] - own[:, :, AFTER])
        times = self.begin[pieces] + share * self.length[pieces]
        added = [self.sum_tones(pieces, times, drive) for drive in range(self.drives)]
        return level + np.stack(added, axis=1) if added else level

    def find_jumps(self) -> Flags:
        """Return for every piece whether a drive jumps at its start."""
        after, before = self.of_drives[:, :, AFTER], _roll(self.of_drives[:, :, BEFORE], 1)
        size = np.maximum(np.abs(after), np.abs(before))
        return (np.abs(after - before) > JUMP * size).any(axis=1) & ~self.begins

    def pair_halves(self, some: Flags) -> Flags:
        """Return pieces with the other half of their step."""
        first = (self.part == FIRST) & (_roll(self.part, -1) == SECOND)
        second = _roll(first, 1)
        return some | first & _roll(some, -1) | second & _roll(some, 1)

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
        states = self.end_states[pieces - at_start]
        inner = np.flatnonzero((share > 0.0) & (share < 1.0))
        if not len(inner):
            return states
        own, share, last = pieces[inner], share[inner], len(self.part) - 1
        first, second = (self.part[own] == part for part in (FIRST, SECOND))
        nodes = [self.end_states[k] for k in (own - 1 - second, own - second, np.minimum(own + first, last))]
        x = (2.0 * np.where(second, 0.5 + 0.5 * share, 0.5 * share) - 1.0)[:, None]
        curve = nodes[1] + 0.5 * x * (nodes[2] - nodes[0]) + 0.5 * x * x * (nodes[2] - 2.0 * nodes[1] + nodes[0])
        curve = np.clip(curve, np.minimum.reduce(nodes), np.maximum.reduce(nodes))
        line = nodes[0] + share[:, None] * (nodes[1] - nodes[0])
        states[inner] = np.where((first | second)[:, None], curve, line)
        return states

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
        rows = [_Rows(piece, share, share, weight, self.read_signals(piece, share))]
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
                rows.append(_Rows(own, at, at, np.zeros(len(own)), self.read_signals(own, at)))
        return rows

    def list_inner(self, piece: Places, share: Numbers) -> InnerRows:
        """Return the rows within steps with halves, from piece and position of all rows."""
        late = self.part == SECOND
        halved = late & (_roll(self.part, 1) == FIRST)
        halved |= _roll(halved, -1)
        row = np.flatnonzero(halved[piece] & (share > 0.0) & (share < 1.0))
        step = np.cumsum(halved & late) - (halved & late)
        return InnerRows(row, step[piece[row]], 0.5 * (share[row] + late[piece[row]]))

    def list_steps(self, ends: Places, starts: Places, jumps: Flags, varied: Flags, toned: Flags) -> StepRows:
        """Return the steps with halves, from the rows at the ends of all pieces."""
        second = np.flatnonzero((self.part == SECOND) & (_roll(self.part, 1) == FIRST))
        first = second - 1
        rows = np.stack([starts[first], ends[first], ends[second]], axis=1)
        joined = ~jumps[first] & (self.part[first - 1] == SECOND) & ~varied[first - 1]
        filled = varied | toned
        return StepRows(rows, joined, ~(filled[first] | filled[second] | jumps[second]))


def _roll(rows: NDArray[Any], by: int) -> NDArray[Any]:
    """Return rows in turn, as `np.roll`, which takes five times as long."""
    return np.concatenate([rows[-by:], rows[:-by]])


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
    joined: dict[str, Any] = {
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
    starts = _roll(ends, 1)
    firsts = np.flatnonzero(order == -1.0)
    starts[piece[firsts]] = firsts
    steps = pieces.list_steps(ends, starts, jumps, varied, toned)
    track = Track(run, times, observe(states, signals, run), weight, steps, swinging, tolerance)
    return track.follow_inner(pieces.list_inner(piece, share)) if len(rows) > 2 else track
