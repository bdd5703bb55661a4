"""Plan, result and common base of time integration of one run on floats."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.base.errors import SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.signals.reader import Reader
from martensite.simulate.compiled import CompiledMarch, Functions
from martensite.simulate.forks import NO_DECISION, Decision

Row = tuple[float, ...]
SHORTEST = 1e-12
"""Length of a step, as a fraction of the run, that is accepted with any error, as at a jump."""
FINEST, ROUGHNESS = 1e-4, 3e-11
"""Shortest step as a fraction of the first step with inertia: maximum, and per tolerance."""
STEP_TOLERANCE = 1e-9
"""Fraction of a step that counts as zero."""
START, WHOLE, FIRST, SECOND = -1, 0, 1, 2
"""Parts of a record: start of a run, whole step, first and second half."""


class RunLimits(NamedTuple):
    """Limits that end a run."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    """One pair for each of `CompiledMarch.envelope`."""

    def find_exit(self, values: Sequence[float], finite: bool = False) -> Exit | None:
        """Return the first value outside; also a non-finite one, unless only `finite` values count."""
        for place, (low, value, high) in enumerate(zip(self.low, values, self.high, strict=False)):
            if not low <= value <= high and (not finite or math.isfinite(value)):
                return Exit(place, value)
        return None


class Exit(NamedTuple):
    """Exit from the envelope."""

    place: int
    """Index of the exceeded bound."""
    value: float
    """Value at the exit, in SI."""


class MarchPlan(NamedTuple):
    """Settings of a run except parameter values."""

    compiled: CompiledMarch
    waveforms: Sequence[AbstractWaveform]
    times: Sequence[float]
    """Sample times [s], ascending, from the start to the end of the run."""
    tolerance: float
    """Accepted error of a step, as a fraction of the range of each judged output."""
    first: float
    """Length of the first step [s]."""
    limits: RunLimits
    ranges: tuple[float, ...] = ()
    """Known ranges of judged outputs, if any."""
    recorded: bool = True
    """True if accepted steps are recorded (`martensite.simulate.track`) and heat and work are summed."""
    totalled: bool = False
    """True if C keeps the minimum, maximum and integral of every output (`totals.c`)."""
    step: float | None = None
    """Longest step [s] of a run on equal steps between samples and edges, without step size control."""
    parted: bool = False
    """True if the last step before every drive edge is split.

    Two passes with the same steps would have the same errors.
    """
    inertial: float = 0.0
    """First step [s] of a system with inertia; 0 without inertia."""
    skipped: int = 0
    """Number of samples of the whole run before these times."""
    start: Row = ()
    """State at the first time; equilibrium as assembled if None."""
    extremes: tuple[Row, Row] = ((), ())
    """Minimum and maximum of earlier judged outputs."""

    @property
    def shortest(self) -> float:
        """Return the step that is accepted with any error [s].

        With inertia, a residual error in position causes a speed error that grows for shorter steps.
        """
        return max(SHORTEST * self.times[-1], self.inertial * min(FINEST, ROUGHNESS / max(self.tolerance, ROUGHNESS)))

    @property
    def order(self) -> int:
        """Return the order of a step with step size control."""
        return self.compiled.order


@dataclass
class MarchResult:
    """Result of a run."""

    rows: Any
    """Outputs at the reached samples: a list of rows, or an array from C."""
    ranges: tuple[float, ...] = ()
    """Ranges of judged outputs over all steps."""
    status: Status = Status.OK
    time: float = 0.0
    """End of the run [s], or start of the step that set the status; NaN if not recorded."""
    place: int = -1
    """Index of the exceeded bound of the envelope; -1 if none."""
    value: float = 0.0
    """Value at the exit, in SI."""
    steps: int = 0
    rejected: int = 0
    longest: float = 0.0
    """Longest step taken [s]."""
    ripple: float = 0.0
    """Largest temperature error [K] of drive means."""
    residual: float = 0.0
    """Largest residual of the solves, and the sum of errors above the tolerance at minimum steps."""
    put_in: float = 0.0
    """Heat [J] into elements with known heat; undefined on given steps."""
    lost: float = 0.0
    """Heat loss [J] of these elements to ambient."""
    accounts: tuple[float, ...] = (0.0,) * len(ACCOUNTS)
    """Changes of stored energy or work [J], see `assembly.ledger.ACCOUNTS`."""
    record: Any = field(default_factory=list[Row])
    """Pieces of accepted steps, in the layout of `martensite.simulate.track`; an array from C."""
    state: Row = ()
    """State at the end."""
    extremes: tuple[Row, Row] = ((), ())
    """Minimum and maximum of judged outputs since the start of the whole run."""
    decision: Decision = NO_DECISION
    """Closest decision about a forgotten branch."""
    undecided: float = 0.0
    """Error [K] of this decision if it may change it; else 0."""
    gap: Row = ()
    """Largest difference of judged outputs from the previous pass up to this leg; empty for the first pass."""
    gaps: Any = ()
    """Differences at every compared sample, (samples, judged)."""
    largest: Row = ()
    """Largest of `gap` and `gaps` for each judged output; empty for the first pass."""
    runtime: str = ""
    """Runtime of the run, `C` or `floats`."""

    def find_largest_gap(self, before: Row, samples: int | None = None) -> Row:
        """Return the largest difference of every judged output from the previous pass; empty if unknown.

        Args:
            before: largest differences before this run.
            samples: number of compared samples that count; all if None.
        """
        if not len(self.gaps):
            return before
        largest = tuple(np.maximum.reduce(self.gaps[:samples].T.copy(), axis=1, initial=0.0).tolist())
        return tuple(map(max, before, largest)) if before else largest

    @property
    def ends(self) -> list[float]:
        """Return the ends of the recorded pieces of steps [s]."""
        return [float(row[2] + row[3]) for row in self.record if row[1] != START]

    @property
    def status_time(self) -> float | None:
        """Return the time of the status [s]; None if the status is ok or the time unknown."""
        return None if self.status is Status.OK or math.isnan(self.time) else self.time

    def require(self) -> MarchResult:
        """Return the result, or raise `SolveError` after a failure."""
        if self.status.failed and self.status is not Status.OUT_OF_ENVELOPE:
            when = "during the run" if self.status_time is None else f"at t = {self.status_time:.6g} s"
            raise SolveError(f"The coupled step of law, heat and mechanism failed {when}. {self.status.sentence}")
        return self


class AbstractMarch:
    """Run in progress, on floats."""

    def __init__(self, plan: MarchPlan, functions: Functions) -> None:
        self.plan, self.functions, self.size = plan, functions, plan.compiled.size
        self.readers = [Reader(waveform) for waveform in plan.waveforms]
        self.time: float = plan.times[0]
        self.duration: float = plan.times[-1]
        signals = self.signals(self.time)
        self.state: Row = plan.start or functions["init"](*signals)[: self.size]
        self.judged_outputs: Row = functions["judge"](*self.state, *signals)
        self.convergence_scales = len(plan.compiled.convergence_scales)
        judged, (low, high) = self.judged_outputs[: self.convergence_scales], plan.extremes
        self.low: list[float] = list(map(min, judged, low or judged))
        self.high: list[float] = list(map(max, judged, high or judged))
        self.sample: int = 1
        self.result = MarchResult([functions["observe"](*self.state, *signals)])
        self.record_piece(START, self.time, self.time, (), self.state)
        self.check_envelope()

    @abstractmethod
    def advance(self) -> None:
        """Take one or several steps."""

    def run(self, watch: Callable[[float], None] | None = None) -> MarchResult:
        """Run to the end or a failure; call `watch` with the completed fraction."""
        run = self.result
        try:
            while self.time < self.duration and not run.status.failed:
                self.advance()
                if watch is not None:
                    watch((self.time - self.plan.times[0]) / (self.duration - self.plan.times[0]))
        except ArithmeticError:  # division by zero or overflow
            run.status = Status.NOT_FINITE
        if run.status.failed or run.status is Status.OK:
            run.time = self.time
        run.ranges = tuple(b - a for a, b in zip(self.low, self.high, strict=True))
        run.state, run.extremes = self.state, (tuple(self.low), tuple(self.high))
        return run

    def signals(self, time: float, before: bool = False) -> Row:
        """Return the drive signals at a time [s], or just before it."""
        return tuple(r.before(time) if before else r.value(time) for r in self.readers)

    def record_piece(self, part: int, begin: float, end: float, inputs: Sequence[float], state: Row) -> None:
        """Record a piece of an accepted step with its drive inputs and final state."""
        if not self.plan.recorded:
            return
        row, at = [0.0, float(part), begin, end - begin], 0
        for reader, width in zip(self.readers, self.plan.compiled.widths, strict=True):
            after = reader.level(begin)
            before = after if part == START else reader.level(end, before=True)
            wide = width > 1 and part != START
            row += [after, before, *(inputs[at : at + 5] if wide else (after, after * after, after, after, 0.0))]
            at += width
        self.result.record.append((*row, *state))

    def see(self, judged_outputs: Row) -> None:
        """Update the ranges with judged outputs at the end of a step."""
        self.judged_outputs = judged_outputs
        for k in range(self.convergence_scales):
            self.low[k], self.high[k] = min(self.low[k], judged_outputs[k]), max(self.high[k], judged_outputs[k])
        self.check_envelope()

    def check_envelope(self) -> None:
        """Stop at an exit from the envelope."""
        run, limits = self.result, self.plan.limits
        crossing = limits.find_exit(self.judged_outputs[self.convergence_scales :])
        if crossing is not None and not run.status.failed:
            finite = math.isfinite(crossing.value)
            run.status = Status.OUT_OF_ENVELOPE if finite else Status.NOT_FINITE
            run.place, run.value = crossing
