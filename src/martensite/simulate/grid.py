"""Time grid of samples and steps, with steps that end at edges of the input.

Heating drives are integrated over every step and stored as moments. Drives that prescribe a state are read at the
end of the step.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import Any, NamedTuple

from martensite.base.errors import InputError, UnitError
from martensite.signals.base import AbstractWaveform
from martensite.signals.reader import Reader

MOST_STEPS = 20_000_000
JUMP = 1e-6
"""Relative change of a signal below which it does not jump."""
MOST_ROWS = 20_000
"""Largest number of steps with outputs stored at the end of each."""
MOST_PERIODS = 400_000
"""Largest number of periods of a run in discrete time."""
THINNED = 0.02
"""Sample interval of longer runs, as a fraction of the time since the last jump."""
JUST_AFTER = 1e-9
"""Relative position in a sample at which a system in discrete time reads signals: just after a jump at the start."""
Signals = tuple[float, ...]
"""One value per drive of a system, or the drive inputs of a step."""


class _Thinning:
    """Rule that skips samples at step ends, but none at an edge of a drive."""

    def __init__(self, edges: Sequence[float], begin: float) -> None:
        self._edges, self._place = edges, 0
        self._event = begin

    def skips(self, time: float, length: float, stored: float) -> bool:
        """Return whether no sample is needed at the end of a step; `stored` is the time of the last sample [s]."""
        if self._place < len(self._edges) and self._edges[self._place] < time + JUST_AFTER * length:
            self._place, self._event = self._place + 1, time
            return False
        return time - stored + 0.5 * length < THINNED * (time - self._event)


@dataclass(frozen=True)
class TimeGrid:
    """Sample times and the steps between them."""

    times: list[float]
    sampled: Any
    """Signals at the sample times: a list of tuples, or an array (samples, drives)."""
    counts: list[int]
    """Steps in each interval between samples."""
    lengths: list[float]
    """Length of every step [s]."""
    drives: Any
    """Drive inputs of `CompiledMarch` in every step: a list of tuples, or an array (steps, inputs)."""
    stored: Any = ...
    """True for requested samples, False for additional step ends."""

    def _plan_thinning(self, waveforms: Sequence[AbstractWaveform]) -> _Thinning | None:
        """Return the rule for more than `MOST_ROWS` steps; None for fewer."""
        if len(self.lengths) <= MOST_ROWS:
            return None
        return _Thinning(sorted({edge for wave in waveforms for edge in wave.edges(self.times[-1])}), self.times[0])

    def keep_steps(self, waveforms: Sequence[AbstractWaveform]) -> TimeGrid:
        """Return the grid with a sample at the end of every step and on each side of a jump.

        Above `MOST_ROWS` steps, the sample interval grows to `THINNED` of the time since the last jump or stored
        sample.
        """
        readers, thinning = [Reader(waveform) for waveform in waveforms], self._plan_thinning(waveforms)
        times, sampled, counts, stored = self.times[:1], self.sampled[:1], list[int](), [0]
        lengths, skipped = iter(self.lengths), 0
        for interval, count in enumerate(self.counts, 1):
            time = self.times[interval - 1]
            for left in range(count - 1, -1, -1):
                length = next(lengths)
                time, hair = (time + length if left else self.times[interval]), JUST_AFTER * length
                if thinning and thinning.skips(time, length, times[-1]) and left:
                    skipped += 1
                    continue
                after = tuple(reader.value(time + hair) for reader in readers) if left else self.sampled[interval]
                before = tuple(reader.value(time - hair) for reader in readers)
                jumps = is_jump(before, after)
                times += [time] * (1 + jumps)
                sampled += [before, after] if jumps else [after]
                counts += [1 + skipped, 0] if jumps else [1 + skipped]
                skipped = 0
                for reader in readers:
                    reader.forget(time - length)
            stored.append(len(times) - 1)
        return TimeGrid(times, sampled, counts, self.lengths, self.drives, stored)

    @cached_property
    def arrays(self) -> tuple[Any, Any, Any, Any, Any]:
        """Return signals at the first and at the other samples, counts, drives and lengths, for C."""
        import numpy as np

        sampled = np.asarray(self.sampled, float).reshape(len(self.times), -1)
        return (
            sampled[:1].copy(),
            sampled[1:].copy(),
            np.asarray(self.counts, np.int_),
            np.asarray(self.drives, float),
            np.asarray(self.lengths, float),
        )

    def list_inputs(self) -> tuple[list[Signals], list[Signals]]:
        """Return `sampled` and `drives` as lists of Python numbers."""
        return _list_rows(self.sampled), _list_rows(self.drives)

    @property
    def longest(self) -> float:
        """Return the longest step [s]."""
        return max(self.lengths)

    def cut(self, begin: float, end: float) -> TimeGrid:
        """Return the part between two samples.

        Raises:
            InputError: no sample lies at one of these times [s]; the message names the nearest.
        """
        near = [bisect_left(self.times, time) for time in (begin, end)]
        places = [
            min(range(max(k - 1, 0), min(k + 1, len(self.times))), key=lambda k: abs(self.times[k] - time))
            for k, time in zip(near, (begin, end), strict=True)
        ]
        for place, time in zip(places, (begin, end), strict=True):
            if abs(self.times[place] - time) > 1e-9 * self.times[-1]:
                raise InputError(f"{time:.6g} s is no sample of this run; the nearest is {self.times[place]:.6g} s.")
        first, last = places
        if first >= last:
            raise InputError(f"The run continues at {begin:.6g} s, but ends at {end:.6g} s; give a longer duration.")
        a, b = sum(self.counts[:first]), sum(self.counts[:last])
        return TimeGrid(
            self.times[first : last + 1],
            self.sampled[first : last + 1],
            self.counts[first:last],
            self.lengths[a:b],
            self.drives[a:b],
        )


@dataclass(frozen=True)
class LaneGrid:
    """Sample times, and individual steps for each batch element.

    All batch elements have the same samples and the same number of steps between samples. Steps of length 0 at the
    end of an interval keep the state. Every batch element therefore takes the same steps as in a single run.
    """

    times: list[float]
    sampled: Any
    """Signals at the sample times, (samples, drives, lanes)."""
    counts: Any
    """Steps in each interval, (intervals,)."""
    drives: Any
    """Drive inputs in every step, (steps, inputs, lanes)."""
    lengths: Any
    """Length of every step [s], (steps, lanes); 0 for unused steps."""
    stored: Any = ...
    """True for requested samples."""

    @cached_property
    def arrays(self) -> tuple[Any, Any, Any, Any, Any]:
        """Return signals at the first and at the other samples, counts, drives and lengths, for C."""
        first, rest = self.sampled[:1].copy(), self.sampled[1:].copy()
        return first, rest, self.counts, self.drives, self.lengths

    @property
    def longest(self) -> float:
        """Return the longest step [s]."""
        return float(self.lengths.max())

    def lane(self, lane: int) -> TimeGrid:
        """Return the grid of one batch element, without steps of length 0."""
        import numpy as np

        lengths = self.lengths[:, lane]
        taken = lengths > 0.0
        ends = np.cumsum(self.counts)
        counts = [int(taken[a:b].sum()) for a, b in zip(ends - self.counts, ends, strict=True)]
        sampled = [tuple(row) for row in self.sampled[:, :, lane].tolist()]
        drives = [tuple(row) for row in self.drives[taken, :, lane].tolist()]
        return TimeGrid(self.times, sampled, counts, lengths[taken].tolist(), drives)


def _list_rows(rows: Any) -> list[Signals]:
    return rows.tolist() if hasattr(rows, "tolist") else rows


def is_jump(before: Signals, after: Signals) -> bool:
    """Return whether two signal values differ by a jump."""
    return any(abs(a - b) > JUMP * max(abs(a), abs(b)) for a, b in zip(before, after, strict=True))


def lane_grid(grids: Sequence[TimeGrid]) -> LaneGrid:
    """Return the merged grids of all batch elements, which have the same samples."""
    import numpy as np

    counts = np.array([grid.counts for grid in grids], np.int_)
    most = counts.max(axis=0)
    starts = np.concatenate([[0], np.cumsum(most)[:-1]])
    drives = np.zeros((int(most.sum()), len(grids[0].drives[0]), len(grids)))
    lengths = np.zeros((len(drives), len(grids)))
    for lane, grid in enumerate(grids):
        first = np.repeat(starts - np.cumsum(counts[lane]) + counts[lane], counts[lane])
        places = first + np.arange(len(grid.lengths))
        drives[places, :, lane] = np.asarray(grid.drives, float)
        lengths[places, lane] = grid.lengths
    sampled = np.stack([np.asarray(grid.sampled, float) for grid in grids], axis=-1)
    return LaneGrid(grids[0].times, sampled, most, drives, lengths, grids[0].stored)


def require_unit(waveform: AbstractWaveform | type[AbstractWaveform], unit: str) -> None:
    """Raise `UnitError` if the fixed unit of a waveform differs from the `unit` of the source."""
    if waveform.unit not in (None, unit):
        kind = "a plain number" if waveform.unit == "1" else f"in {waveform.unit}"
        raise UnitError(
            f"The signal of waveform `{waveform.registered_name}` is {kind}, but the drive needs "
            f"{unit}. For a duty cycle, use the drive `pwm-voltage`."
        )


def just_after(ahead: bool) -> float:
    """Return the relative position in a sample at which its signal is read."""
    return JUST_AFTER + (1.0 if ahead else 0.0)


BEFORE = 1.0 - 1e-9
"""Relative position just before the end of a step."""


def place_signal(at_end: bool) -> float:
    """Return the relative position in a step at which a constant signal is read."""
    return BEFORE if at_end else 0.5


class Steps(NamedTuple):
    """Times and the steps between them."""

    times: Sequence[float]
    counts: list[int]
    begins: list[float]
    lengths: list[float]

    def ends(self) -> list[float]:
        """Return the end time of each interval [s]."""
        return [*self.begins[1:], self.times[-1]]

    def grid(self, waveforms: Sequence[AbstractWaveform], at_end: Sequence[bool]) -> TimeGrid:
        """Return the grid with waveforms; flags mark waveforms that prescribe a state."""
        count, columns = len(self.lengths), list[Sequence[Signals]]()
        ends = self.ends()
        for waveform, late in zip(waveforms, at_end, strict=True):
            if late:
                reader = Reader(waveform)
                columns.append([(reader.before(end),) for end in ends])
            else:
                shape = waveform.shape(0.0, self.times[-1])
                columns.append([(*moments, 0.0) for moments in shape.many(self.begins, ends)])
        rows = [tuple(chain.from_iterable(row)) for row in zip(*columns, strict=True)]
        sampled = rows_of(waveforms, self.times)
        return TimeGrid(list(self.times), sampled, self.counts, self.lengths, rows or [()] * count)


def build_grid(
    waveforms: Sequence[AbstractWaveform], duration: float, samples: int, step: float, at_end: Sequence[bool]
) -> TimeGrid:
    """Return the grid of a run of `duration` [s] with equidistant samples, both ends included."""
    times = [duration * i / (samples - 1) for i in range(samples)]
    return grid_at(waveforms, times, step, at_end)


def grid_of_samples(
    waveforms: Sequence[AbstractWaveform],
    duration: float,
    samples: int,
    interval: float,
    ahead: Sequence[bool],
    every: bool = False,
) -> TimeGrid:
    """Return the grid of a system in discrete time, with one step per period.

    Signals are read at the start of a step, or at its end with `ahead`. The requested number of samples is
    distributed evenly over the steps. With `every`, all steps of a run of moderate length are samples.

    Raises:
        InputError: the run has too many steps, or is shorter than one.
    """
    steps = math.floor(duration / interval + 1e-9)
    if not 1 <= steps <= MOST_STEPS:
        raise InputError(
            f"A run of {duration:.6g} s in samples of {interval:.6g} s has {steps:,} steps, but "
            f"must have 1 to {MOST_STEPS:,}."
        )
    import numpy as np

    pieces = min(samples - 1, steps)
    ends = np.rint(steps * np.arange(pieces + 1) / pieces).astype(np.intp)
    instants = ((np.arange(steps + 1) + JUST_AFTER) * interval).tolist()
    signals = np.empty((steps + 1, len(waveforms)))
    for drive, waveform in enumerate(waveforms):
        signals[:, drive] = waveform.signals(instants)
    whole = every and steps <= MOST_PERIODS
    places = np.arange(steps + 1) if whole else ends
    return TimeGrid(
        (places * interval).tolist(),
        signals[places],
        np.diff(places).tolist(),
        [interval] * steps,
        np.where(np.array(ahead, np.bool_), signals[1:], signals[:-1]),
        ends.tolist() if whole else ...,
    )


def grid_at(waveforms: Sequence[AbstractWaveform], times: list[float], step: float, at_end: Sequence[bool]) -> TimeGrid:
    """Return the grid from time 0 with given samples `times` (the first is 0) and edges.

    Steps are at most `step` [s] long.
    """
    edges = {edge for waveform in waveforms for edge in waveform.edges(times[-1])}
    return cut_steps(edges, times, step).grid(waveforms, at_end)


def cut_steps(edges: Iterable[float], times: Sequence[float], step: float) -> Steps:
    """Return the steps of at most `step` [s] between samples and edges; raise `InputError` for too many steps."""
    duration, samples = times[-1], len(times)
    ahead = [*sorted(edges), math.inf]
    if duration / step + len(ahead) + samples > MOST_STEPS:
        raise InputError(
            f"A run of {duration:.6g} s in steps of {step:.3g} s needs more than "
            f"{MOST_STEPS:,} steps; allow a larger tolerance or a shorter duration."
        )
    counts: list[int] = []
    begins: list[float] = []
    lengths: list[float] = []
    next_edge, hair = 0, 1e-12 * duration
    for first, last in pairwise(times):
        cuts = [first]
        while ahead[next_edge] < last - hair:
            if ahead[next_edge] > cuts[-1] + hair:
                cuts.append(ahead[next_edge])
            next_edge += 1
        before = len(lengths)
        for a, b in pairwise([*cuts, last]):
            pieces = max(1, math.ceil((b - a) / step - 1e-9))
            length = (b - a) / pieces
            lengths += [length] * pieces
            begins += [a + k * length for k in range(pieces)]
        counts.append(len(lengths) - before)
    return Steps(times, counts, begins, lengths)


def rows_of(waveforms: Sequence[AbstractWaveform], times: Sequence[float]) -> list[Signals]:
    """Return the signals at every time [s]."""
    columns = [wave.signals(times) for wave in waveforms]
    return list(zip(*columns, strict=True)) if columns else [()] * len(times)
