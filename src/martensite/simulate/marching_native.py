"""Time integration in C: one run, or a batch of runs with individual steps.

A single run is a batch with one element. Both use `marching.c` with `adaptive.c` or `fixed.c`. Memory holds the
results and, for a single run, a window of the drives, independent of the number of steps. Batch elements are at
different times and hold their complete drives; runs with too many segments are made one by one.
"""

from __future__ import annotations

import ctypes
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import chain
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.simulate.forks import Decision, read_decision
from martensite.simulate.march_kernel import kernel_of, load_kernel
from martensite.simulate.marching import Marched, MarchPlan
from martensite.simulate.native import spread, spread_column, spread_limits
from martensite.simulate.native_drives import DriveWindow, list_drives, make_table
from martensite.simulate.recorded_track import Observe, record_width

Numbers = NDArray[np.float64]
DONE, PAUSED, SIGNALS, RECORD = range(4)
ROUNDS = 4096
"""Rounds of all batch elements between two checks from Python."""
MOST_SEGMENTS = 1 << 21
"""Maximum number of drive segments in a batch."""
FIRST_RECORD = 4096
EXPECTED = 512
"""Initial capacity of the record of a batch, in steps."""
DECIDED = 11 + len(ACCOUNTS)
"""Numbers of a run before its closest decision, see `Decision`."""
RANGES = DECIDED + len(Decision._fields)
"""Numbers of a run before the ranges of judged outputs."""


class _March(ctypes.Structure):
    _fields_ = [
        *(
            (name, ctypes.c_long)
            for name in ("runs", "samples", "rounds", "recording", "parted", "recorded", "capacity")
        ),
        *((name, ctypes.c_double) for name in ("tolerance", "duration", "step", "shortest")),
        *(
            (name, ctypes.c_void_p)
            for name in ("p", "first", "times", "drives", "limits", "ranges", "rows", "numbers", "record")
        ),
        ("states", ctypes.c_void_p),
        ("extremes", ctypes.c_void_p),
        ("placed", ctypes.c_long),
        ("totals", ctypes.c_void_p),
    ]


@dataclass(frozen=True, eq=False)
class Runs:
    """Runs of one system: common settings and individual values."""

    plan: MarchPlan
    """Waveforms of all runs, unless replaced by `own`."""
    values: Sequence[Any]
    """Parameters in order, each a scalar or (runs,)."""
    count: int
    outputs: tuple[int, ...]
    """Indices of stored outputs."""
    lanes: int
    """Batch size: a multiple of `BLOCK`, or 1."""
    first: Any = None
    """First step of every run [s]; the first step of the plan if None."""
    own: Sequence[Sequence[AbstractWaveform]] | None = None
    """Waveforms of every run."""
    ranges: Any = None
    """Ranges of the judged outputs, (runs, judged), if they are known."""
    limits: Any = None
    """Limits that end a run, low and high, (2, envelope, runs); the limits of the plan if None."""

    def choose(self, places: Any, ranges: Any) -> Runs:
        """Return selected runs, with known ranges of judged outputs, (runs, judged)."""
        return replace(
            self,
            values=[np.asarray(v)[places] if np.ndim(v) else v for v in self.values],
            count=len(places),
            first=self.first if np.ndim(self.first) == 0 else self.first[places],
            own=None if self.own is None else [self.own[place] for place in places],
            limits=None if self.limits is None else np.asarray(self.limits)[:, :, places],
            ranges=ranges,
        )


@dataclass(frozen=True, eq=False)
class MarchRows:
    """Results of runs."""

    outputs: Numbers
    """(runs, samples, outputs); NaN after the end of a run that stopped."""
    numbers: Numbers
    """(runs, RANGES + judged): status, time, place, value, steps, rejected, longest step, ripple,
    residual, heat put in and lost, accounts, closest decision, and the ranges of what is judged; see `Marched`.
    """
    record: Numbers
    """Pieces of accepted steps, in the layout of `martensite.simulate.track`; none if they were not recorded."""
    totals: Numbers
    """Lowest, highest and integral of every output over all steps, (runs, 3, outputs), if they were asked for."""
    states: Numbers
    """States at the ends of runs, (runs, states)."""
    extremes: Numbers
    """Minimum and maximum of judged outputs, (runs, 2, judged)."""

    def choose(self, places: NDArray[np.intp]) -> MarchRows:
        """Return selected runs in the given order."""
        if len(places) == len(self.outputs):
            return self
        at = np.full(len(self.outputs), -1)
        at[places] = np.arange(len(places))
        own = at[self.record[:, 0].astype(np.intp)]
        record = np.concatenate([own[:, None], self.record[:, 1:]], axis=1)[own >= 0]
        totals = self.totals[places] if len(self.totals) else self.totals
        others = (getattr(self, name)[places] for name in ("states", "extremes"))
        return MarchRows(self.outputs[places], self.numbers[places], record, totals, *others)

    def take_run(self, run: int, times: Sequence[float]) -> Marched:
        """Return one run."""
        numbers = self.numbers[run].tolist()
        status, end, place, value, steps, rejected, *more = numbers
        accounts, ranges = tuple(numbers[11:DECIDED]), tuple(numbers[RANGES:])
        rows, verdict = self.outputs[run], Status(int(status))
        reached = bisect_right(times, end) if verdict.failed else len(times)
        if not verdict.failed and not np.isfinite(rows[:reached]).all():
            verdict = Status.NOT_FINITE
        march = Marched(rows[:reached], ranges, verdict, end, int(place), value, int(steps), int(rejected), *more[:5])
        march.accounts, march.record = accounts, self.record
        march.decision = read_decision(numbers[DECIDED:RANGES])
        low, high = self.extremes[run].tolist()
        march.state, march.extremes = tuple(self.states[run].tolist()), (tuple(low), tuple(high))
        return march


def march_runs(runs: Runs, watch: Callable[[float], None] | None = None) -> MarchRows:
    """Simulate runs to their ends; call `watch` with the completed fraction at intervals."""
    marching = Marching(runs)
    if runs.lanes == 1 or marching.knows_all():
        return marching.go(watch)
    places = np.arange(runs.count)
    alone = replace(runs, lanes=1)
    ranges = marching.ranges
    rows = [Marching(alone.choose(places[k : k + 1], ranges[k : k + 1])).go() for k in places]
    for k, row in enumerate(rows):
        row.record[:, 0] = k
    return MarchRows(*(np.concatenate([getattr(row, one.name) for row in rows]) for one in fields(MarchRows)))


class MarchArrays:
    """Arrays that the C code reads and fills, including drives."""

    def __init__(self, runs: Runs, earlier: Self | None = None) -> None:
        """Build the arrays; take those of an `earlier` pass of the same run that do not change."""
        plan, compiled = runs.plan, runs.plan.compiled
        self.runs, self.plan = runs, plan
        judged = len(compiled.convergence_scales)
        if earlier is not None and earlier.serves(runs):
            self.p, self.first, self.limits = earlier.p, earlier.first, earlier.limits
            self.windows, self.drives, self.filled = earlier.windows, earlier.drives, earlier.filled
        else:
            self.p = spread_column(runs.values, runs.count)
            self.first = spread(plan.first if runs.first is None else runs.first, (runs.count,))
            limits = plan.limits if runs.limits is None else runs.limits
            self.limits = spread_limits(limits, runs.count)
            self.windows = _open_windows(runs)
            self.drives = make_table(max(1, sum(map(len, self.windows))))
            self.filled = False
        self.times = np.fromiter(chain(plan.times, (np.inf,)), float, len(plan.times) + 1)
        ranges = plan.ranges or 0.0 if runs.ranges is None else runs.ranges
        self.ranges = spread(ranges, (runs.count, judged))
        self.rows = np.full((runs.count, len(plan.times), len(runs.outputs)), np.nan)
        self.numbers = np.zeros((runs.count, RANGES + judged))
        width = record_width(compiled.drives, sum(compiled.states_observed(runs.outputs)))
        steps = int((plan.times[-1] - plan.times[0]) / plan.step) if plan.step else EXPECTED * (runs.count - 1)
        self.record = np.empty((max(FIRST_RECORD, 2 * steps) if plan.recorded else 0, width))
        self.totals = np.full((runs.count, 3, len(runs.outputs)), np.nan) if plan.totalled else np.empty(0)
        self.states = spread(plan.start or 0.0, (runs.count, compiled.size))
        self.extremes = np.empty((runs.count, 2, judged))
        self.extremes[:, 0], self.extremes[:, 1] = plan.extremes[0] or np.inf, plan.extremes[1] or -np.inf

    def serves(self, runs: Runs) -> bool:
        """Return whether the parameters, limits and complete drives of a single run are those of another pass."""
        mine, other = self.plan, runs.plan
        same = runs.count == 1 and runs.values is self.runs.values and other.drives is mine.drives
        whole = all(window.whole for window in chain.from_iterable(self.windows))
        return same and whole and other.limits is mine.limits and other.times[-1] == mine.times[-1]

    def describe(self, locate: Callable[[NDArray[Any]], int]) -> _March:
        """Return the C structure with the address of each array."""
        plan = self.plan
        places = ("p", "first", "times", "limits", "ranges", "rows", "numbers", "record", "states", "extremes")
        if not self.filled:
            self.fill_drives(locate)
        return _March(
            runs=self.runs.count,
            samples=len(plan.times),
            rounds=ROUNDS,
            recording=plan.recorded,
            parted=plan.parted,
            capacity=len(self.record),
            tolerance=plan.tolerance,
            duration=plan.times[-1],
            step=plan.step or 0.0,
            shortest=plan.shortest,
            placed=bool(plan.start),
            drives=locate(np.frombuffer(memoryview(self.drives), np.uint8)),
            totals=locate(self.totals) if plan.totalled else None,
            **{name: locate(getattr(self, name)) for name in places},
        )

    def knows_all(self) -> bool:
        """Return whether all drives are stored up to their ends."""
        return all(window.known_until() == np.inf for window in chain.from_iterable(self.windows))

    def fill_drives(self, locate: Callable[[NDArray[Any]], int]) -> None:
        """Write the addresses of segments and tones of every drive."""
        for window, drive in zip(chain.from_iterable(self.windows), self.drives, strict=False):
            window.fill(drive, locate)
        self.filled = True


def _open_windows(runs: Runs) -> list[list[DriveWindow]]:
    """Return the drives of all runs or of each run, with their segments: of a batch up to the ends of the drives."""
    plan, end = runs.plan, runs.plan.times[-1]
    if runs.own is None:
        rows = zip(plan.waveforms, list_drives(plan), strict=True)
        windows = [[DriveWindow(waveform, end, whole) for waveform, whole in rows]]
    else:
        windows = [[DriveWindow(waveform, end) for waveform in row] for row in runs.own]
    most = MOST_SEGMENTS
    for window in chain.from_iterable(windows):
        if runs.lanes > 1:
            most -= window.extend_to_end(most)
        else:
            window.extend(0.0)
            while not window.known_until() > plan.times[0]:
                window.extend(plan.times[0])
    return windows


class Marching(MarchArrays):
    """Run in progress, in C."""

    def __init__(self, runs: Runs, earlier: Self | None = None) -> None:
        super().__init__(runs, earlier)
        if earlier is not None and earlier.p is self.p:
            self.library, self.block = earlier.library, earlier.block
        else:
            self.library = load_kernel(kernel_of(self.plan, runs.outputs, runs.lanes, runs.own))
            self.block = np.empty(self.library.size_of_block(), np.uint8)
        self.march = self.describe(_get_address)

    def go(self, watch: Callable[[float], None] | None = None) -> MarchRows:
        """Integrate to the end."""
        begin = 1
        march, block = ctypes.byref(self.march), ctypes.c_void_p(_get_address(self.block))
        while True:
            answer = self.library.march_on(march, block, ctypes.c_long(begin))
            begin = 0
            if answer == DONE:
                record = self.record[: self.march.recorded]
                return MarchRows(self.rows, self.numbers, record, self.totals, self.states, self.extremes)
            if answer == SIGNALS:
                self._extend()
            if answer == RECORD:
                self.record = np.concatenate([self.record, np.empty((3 * len(self.record), self.record.shape[1]))])
                self.march.record, self.march.capacity = _get_address(self.record), len(self.record)
            if watch is not None:
                watch(self._done())

    def _extend(self) -> None:
        """Extend the drives of runs that wait for segments."""
        now = self._time()
        for window in self.windows[0]:
            if window.known_until() < np.inf:
                window.extend(now)
        self.fill_drives(_get_address)
        self.library.forget_cursors(ctypes.c_void_p(_get_address(self.block)))

    def _time(self) -> float:
        """Return the time of a single run [s], or the number of completed runs."""
        return self.library.time_of(ctypes.c_void_p(_get_address(self.block)))

    def _done(self) -> float:
        """Return the completed fraction of the runs."""
        begin, end = (self.plan.times[0], self.plan.times[-1]) if self.runs.lanes == 1 else (0.0, self.runs.count)
        return max(self._time() - begin, 0.0) / (end - begin)


def observe_in_c(runs: Runs) -> Observe:
    """Return the function that computes stored outputs of recorded states, with the parameters of each run."""
    library = load_kernel(kernel_of(runs.plan, runs.outputs, runs.lanes, runs.own))
    count, outputs = runs.count, runs.outputs
    table = spread_column(runs.values, count)

    def observe(states: Numbers, signals: Numbers, run: NDArray[np.intp]) -> Numbers:
        rows = np.ascontiguousarray(np.concatenate([states, signals], axis=1))
        output_rows = np.empty((len(rows), len(outputs)))
        counts = np.bincount(run, minlength=count).astype(np.int_)
        arrays = (counts, np.ascontiguousarray(table), rows, output_rows)
        library.observe_rows(ctypes.c_long(count), *(ctypes.c_void_p(_get_address(one)) for one in arrays))
        return output_rows

    return observe


def _get_address(array: Any) -> int:
    return ctypes.addressof(ctypes.c_char.from_buffer(array)) if array.size else 0  # `array.ctypes` is much slower
