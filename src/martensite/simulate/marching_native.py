"""Time integration in C: one run, or a batch of runs with individual steps.

A single run is a batch with one element. Both use `marching.c` with `adaptive.c` or `fixed.c`. Memory holds the
results and, for a single run, a window of the drives, independent of the number of steps. Batch elements are at
different times and hold their complete drives; runs with too many segments are made one by one.
"""

from __future__ import annotations

import ctypes
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import chain
from operator import is_
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.simulate.forks import Decision, read_decision
from martensite.simulate.march_kernel import kernel_of, load_kernel
from martensite.simulate.marching import MarchPlan, MarchResult
from martensite.simulate.native import fill_column, spread_column, spread_limits
from martensite.simulate.native_drives import DriveWindow, get_address, make_table, open_drive
from martensite.simulate.recorded_track import Observe, record_width
from martensite.simulate.restarts import tabulate_times

Numbers = NDArray[np.float64]
DONE, PAUSED, SIGNALS, RECORD = range(4)
ROUNDS = 4096
"""Rounds of all batch elements between two checks from Python."""
MOST_SEGMENTS = 1 << 21
"""Maximum number of drive segments in a batch."""
FIRST_RECORD = 4096
NOTHING = np.empty(0)
UNSEEN = np.array([[np.inf], [-np.inf]])
"""Minimum and maximum before a run."""
EXPECTED = 512
"""Initial capacity of the record of a batch, in steps."""
FIXED = ("p", "first", "limits", "ranges", "numbers", "states", "extremes")
"""Arrays of all passes of a run."""
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


class Runs(NamedTuple):
    """Runs of one system: common settings and individual values."""

    plan: MarchPlan
    """Waveforms of all runs, unless replaced by `own`."""
    values: Sequence[Any]
    """Parameters in order, each a scalar or (runs,)."""
    size: int
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
        return self._replace(
            values=[np.asarray(v)[places] if np.ndim(v) else v for v in self.values],
            size=len(places),
            first=self.first if np.ndim(self.first) == 0 else self.first[places],
            own=None if self.own is None else [self.own[place] for place in places],
            limits=None if self.limits is None else np.asarray(self.limits)[:, :, places],
            ranges=ranges,
        )


class MarchRows(NamedTuple):
    """Results of runs."""

    outputs: Numbers
    """(runs, samples, outputs); NaN after the end of a run that stopped."""
    numbers: Numbers
    """(runs, RANGES + judged): status, time, place, value, steps, rejected, longest step, ripple,
    residual, heat put in and lost, accounts, closest decision, and the ranges of what is judged; see `MarchResult`.
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

    def take_run(self, run: int, times: Sequence[float], checked: bool = True) -> MarchResult:
        """Return one run; if `checked`, its status reports outputs that are not finite."""
        numbers = self.numbers[run].tolist()
        status, end, place, value, steps, rejected, *more = numbers[:11]
        low, high = self.extremes[run].tolist()
        rows, verdict = self.outputs[run], Status(int(status))
        if verdict.failed:
            rows = rows[: bisect_right(times, end)]
        elif checked and np.count_nonzero(np.isfinite(rows)) < rows.size:
            verdict = Status.NOT_FINITE
        ranges = tuple(numbers[RANGES:])
        march = MarchResult(rows, ranges, verdict, end, int(place), value, int(steps), int(rejected), *more)
        march.accounts, march.record = tuple(numbers[11:DECIDED]), self.record
        march.decision = read_decision(numbers[DECIDED:RANGES])
        march.state, march.extremes = tuple(self.states[run].tolist()), (tuple(low), tuple(high))
        return march


def march_runs(runs: Runs, watch: Callable[[float], None] | None = None) -> MarchRows:
    """Simulate runs to their ends; call `watch` with the completed fraction at intervals."""
    marching = NativeMarch(runs)
    if runs.lanes == 1 or marching.knows_all():
        return marching.go(watch)
    places = np.arange(runs.size)
    alone = runs._replace(lanes=1)
    ranges = marching.ranges
    rows = [NativeMarch(alone.choose(places[k : k + 1], ranges[k : k + 1])).go() for k in places]
    for k, row in enumerate(rows):
        row.record[:, 0] = k
    return MarchRows(*map(np.concatenate, zip(*rows, strict=True)))


class MarchArrays:
    """Arrays that the C code reads and fills, including drives."""

    def __init__(self, runs: Runs) -> None:
        compiled, count = runs.plan.compiled, runs.size
        judged = len(compiled.convergence_scales)
        self.width = record_width(compiled.drives, sum(compiled.states_observed(runs.outputs)))
        self.p, self.first = np.empty((len(runs.values), count)), np.empty(count)
        self.limits = np.empty((2, len(compiled.envelope), count))
        self.drives = make_table(max(1, compiled.drives * (1 if runs.own is None else count)))
        self.ranges, self.numbers = np.empty((count, judged)), np.empty((count, RANGES + judged))
        self.states, self.extremes = np.empty((count, compiled.size)), np.empty((count, 2, judged))
        self.write_runs(runs)

    def write_runs(self, runs: Runs) -> None:
        """Write the parameters, limits and drives of runs, and prepare their first pass."""
        plan = self.plan = runs.plan
        self.runs = runs
        fill_column(self.p, runs.values)
        self.first[...] = plan.first if runs.first is None else runs.first
        self.limits[...] = spread_limits(plan.limits if runs.limits is None else runs.limits, runs.size)
        self.windows = _open_windows(runs)
        self.set_plan(plan)

    def set_plan(self, plan: MarchPlan) -> None:
        """Prepare a pass: samples, known ranges, and the start of the runs."""
        runs, samples = self.runs, len(plan.times)
        self.plan, self.times = plan, tabulate_times(plan.times)
        self.rows: Numbers = np.empty((runs.size, samples, len(runs.outputs)))
        self.rows.fill(np.nan)
        steps = int((plan.times[-1] - plan.times[0]) / plan.step) if plan.step else EXPECTED * (runs.size - 1)
        self.record: Numbers = np.empty((max(FIRST_RECORD, 2 * steps) if plan.recorded else 0, self.width))
        self.totals = np.full((runs.size, 3, len(runs.outputs)), np.nan) if plan.totalled else NOTHING
        self.ranges[...] = plan.ranges or 0.0 if runs.ranges is None else runs.ranges
        self.states[...] = plan.start or 0.0
        self.extremes[...] = plan.extremes if plan.extremes[0] else UNSEEN

    def describe(self, locate: Callable[[NDArray[Any]], int]) -> _March:
        """Return the C structure with the address of each array."""
        self.fill_drives(locate)
        march = _March(
            runs=self.runs.size,
            rounds=ROUNDS,
            drives=locate(np.frombuffer(memoryview(self.drives), np.uint8)),
            **{name: locate(getattr(self, name)) for name in FIXED},
        )
        self.describe_plan(march, locate)
        return march

    def describe_plan(self, march: _March, locate: Callable[[NDArray[Any]], int]) -> None:
        """Write the numbers and arrays of the pass into the C structure."""
        plan = self.plan
        march.samples, march.placed = len(plan.times), bool(plan.start)
        march.parted, march.tolerance = plan.parted, plan.tolerance
        march.recording, march.recorded, march.capacity = plan.recorded, 0, len(self.record)
        march.duration, march.step, march.shortest = plan.times[-1], plan.step or 0.0, plan.shortest
        march.times, march.rows, march.record = locate(self.times), locate(self.rows), locate(self.record)
        march.totals = locate(self.totals) if plan.totalled else None

    def knows_all(self) -> bool:
        """Return whether all drives are stored up to their ends."""
        return all(window.known_until() == np.inf for window in chain.from_iterable(self.windows))

    def fill_drives(self, locate: Callable[[NDArray[Any]], int]) -> None:
        """Write the addresses of segments and tones of every drive."""
        for k, window in enumerate(chain.from_iterable(self.windows)):
            if window.whole and locate is get_address:
                self.drives[k] = window.table
            else:
                window.fill(self.drives[k], locate)


def _open_windows(runs: Runs) -> list[list[DriveWindow]]:
    """Return the drives of all runs or of each run, with their segments: of a batch up to the ends of the drives."""
    plan, end = runs.plan, runs.plan.times[-1]
    if runs.own is None:
        windows = [[open_drive(waveform, end) for waveform in plan.waveforms]]
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


class NativeMarch(MarchArrays):
    """Run in progress, in C."""

    def __init__(self, runs: Runs) -> None:
        super().__init__(runs)
        self._load(runs)
        self.march = self.describe(get_address)

    def _load(self, runs: Runs) -> None:
        """Load the library of runs."""
        self.library = load_kernel(kernel_of(self.plan, runs.outputs, runs.lanes, runs.own))
        self.block = np.empty(self.library.size_of_block(), np.uint8)

    def set_runs(self, runs: Runs) -> None:
        """Prepare another pass of a single run, or another run of the same structure and outputs."""
        plan, mine = runs.plan, self.plan
        alike = (plan.step is None) is (mine.step is None) and all(map(is_, plan.waveforms, mine.waveforms))
        whole = all(window.whole for window in self.windows[0]) and plan.times[-1] == mine.times[-1]
        same = runs.values is self.runs.values and plan.limits is mine.limits and plan.first == mine.first
        if alike and whole and same:
            self.set_plan(plan)
        else:
            self.write_runs(runs)
            self.fill_drives(get_address)
        if not alike:
            self._load(runs)
        self.describe_plan(self.march, get_address)

    def go(self, watch: Callable[[float], None] | None = None) -> MarchRows:
        """Integrate to the end."""
        begin = 1
        march, block = ctypes.byref(self.march), ctypes.c_void_p(get_address(self.block))
        while True:
            answer = self.library.march_on(march, block, ctypes.c_long(begin))
            begin = 0
            if answer == DONE:
                rows, record = self.rows, self.record[: self.march.recorded]
                self.rows = self.record = NOTHING  # which only their run keeps
                return MarchRows(rows, self.numbers, record, self.totals, self.states, self.extremes)
            if answer == SIGNALS:
                self._extend()
            if answer == RECORD:
                self.record = np.concatenate([self.record, np.empty((3 * len(self.record), self.width))])
                self.march.record, self.march.capacity = get_address(self.record), len(self.record)
            if watch is not None:
                watch(self._done())

    def _extend(self) -> None:
        """Extend the drives of runs that wait for segments."""
        now = self._time()
        for window in self.windows[0]:
            if window.known_until() < np.inf:
                window.extend(now)
        self.fill_drives(get_address)
        self.library.forget_cursors(ctypes.c_void_p(get_address(self.block)))

    def _time(self) -> float:
        """Return the time of a single run [s], or the number of completed runs."""
        return self.library.time_of(ctypes.c_void_p(get_address(self.block)))

    def _done(self) -> float:
        """Return the completed fraction of the runs."""
        begin, end = (self.plan.times[0], self.plan.times[-1]) if self.runs.lanes == 1 else (0.0, self.runs.size)
        return max(self._time() - begin, 0.0) / (end - begin)


def observe_in_c(runs: Runs) -> Observe:
    """Return the function that computes stored outputs of recorded states, with the parameters of each run."""
    library = load_kernel(kernel_of(runs.plan, runs.outputs, runs.lanes, runs.own))
    count, outputs = runs.size, runs.outputs
    table = spread_column(runs.values, count)

    def observe(states: Numbers, signals: Numbers, run: NDArray[np.intp]) -> Numbers:
        rows = np.ascontiguousarray(np.concatenate([states, signals], axis=1))
        output_rows = np.empty((len(rows), len(outputs)))
        counts = np.bincount(run, minlength=count).astype(np.int_)
        arrays = (counts, np.ascontiguousarray(table), rows, output_rows)
        library.observe_rows(ctypes.c_long(count), *(ctypes.c_void_p(get_address(one)) for one in arrays))
        return output_rows

    return observe
