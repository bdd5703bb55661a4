"""A march of one run on plain floats: what it is given, what it did, and what all marches share."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.base.errors import SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.signals.reader import Reader
from martensite.simulate.compiled import CompiledMarch, Functions

Row = tuple[float, ...]
SHORTEST = 1e-12
"""Length of a step, as a fraction of the run, that is taken whatever its error: a jump lies in it."""
FINEST, ROUGHNESS = 1e-4, 3e-11
"""Fraction of the first step of a motion with inertia that is the shortest step: at most, and per tolerance."""
STEP_TOLERANCE = 1e-9
"""Fraction of a step that counts as zero."""
START, WHOLE, FIRST, SECOND = -1, 0, 1, 2
"""Parts of a record: the start of a run, a whole step, and both halves of a step."""


class RunLimits(NamedTuple):
    """Limits that end a run."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    """One pair for each of `CompiledMarch.envelope`."""

    def find_exit(self, values: Sequence[float], finite: bool = False) -> Exit | None:
        """Return the first of some values that is outside; or no number, unless only `finite` ones count."""
        for place, (low, value, high) in enumerate(zip(self.low, values, self.high, strict=False)):
            if not low <= value <= high and (not finite or math.isfinite(value)):
                return Exit(place, value)
        return None


class Exit(NamedTuple):
    """Place at which the envelope is left."""

    place: int
    """Which of its bounds is passed."""
    value: float
    """Value at the exit, in SI."""


@dataclass(frozen=True)
class MarchPlan:
    """Everything about an adaptive run but the numbers of the system."""

    compiled: CompiledMarch
    waveforms: Sequence[AbstractWaveform]
    times: Sequence[float]
    """Samples [s], ascending from where the run begins, to where it ends."""
    tolerance: float
    """Accepted error of a step, as a fraction of the range of each judged output."""
    first: float
    """Length of the first step [s]."""
    limits: RunLimits
    ranges: tuple[float, ...] = ()
    """Ranges of the judged outputs, if they are known."""
    recorded: bool = True
    """True if the accepted steps are recorded (`martensite.simulate.track`)."""
    totalled: bool = False
    """True if a march in C keeps the lowest and highest value and the integral of every output (`totals.c`)."""
    step: float | None = None
    """Longest step [s] of a march on equal steps between samples and edges, without control."""
    parted: bool = False
    """True if the last step before every edge of a drive is split. Two runs with steps cut at the same places would
    have the same errors.
    """
    inertial: float = 0.0
    """First step [s] of what moves with inertia; 0 if nothing does."""
    skipped: int = 0
    """Samples of the whole run before the first of these times."""
    start: Row = ()
    """State at the first of the times; as assembled, at rest, if none."""
    extremes: tuple[Row, Row] = ((), ())
    """Minimum and maximum of the judged outputs before."""
    drives: dict[float, list[Any]] = field(default_factory=dict[float, list[Any]], repr=False)
    """End of the run, or of its last leg [s] -> segments of its drives as C takes them; shared by all passes."""

    @property
    def shortest(self) -> float:
        """Step that is taken whatever its error [s].

        With inertia, an error that a solve leaves in a position is an error in the speed, larger in a shorter step.
        """
        return max(SHORTEST * self.times[-1], self.inertial * min(FINEST, ROUGHNESS / max(self.tolerance, ROUGHNESS)))

    @property
    def order(self) -> int:
        """Return the order of one step with error control."""
        return self.compiled.order


@dataclass
class Marched:
    """Result of an adaptive run."""

    rows: Any
    """Outputs at the samples that were reached: a list of rows, or an array of a run in C."""
    ranges: tuple[float, ...] = ()
    """Ranges of the judged outputs, over all steps."""
    status: Status = Status.OK
    time: float = 0.0
    """End of the run [s], or begin of the step of its status; NaN if it was not recorded."""
    place: int = -1
    """Which limit of the envelope was passed; -1 if none."""
    value: float = 0.0
    """Value at the exit, in SI."""
    steps: int = 0
    rejected: int = 0
    longest: float = 0.0
    """Longest step taken [s]."""
    ripple: float = 0.0
    """Largest temperature [K] that a mean of a drive left out."""
    residual: float = 0.0
    """Largest of the solves, and the errors of all steps that could be no shorter, above their tolerance."""
    put_in: float = 0.0
    """Heat [J] that came into elements whose heat is known; without a meaning on given steps."""
    lost: float = 0.0
    """Heat [J] that they lost to the ambient."""
    accounts: tuple[float, ...] = (0.0,) * len(ACCOUNTS)
    """Energies [J], see `assembly.ledger.ACCOUNTS`: more held than in the beginning, or work."""
    record: Any = field(default_factory=list[Row])
    """Pieces of accepted steps, in the layout of `martensite.simulate.track`; an array of a run in C."""
    state: Row = ()
    """In the end."""
    extremes: tuple[Row, Row] = ((), ())
    """Minimum and maximum of the judged outputs, since the run of which this is a part began."""
    gap: Row = ()
    """Largest difference of the judged outputs to the pass before, until this leg began; empty for the first pass."""
    gaps: Any = ()
    """Differences at every sample at which passes are compared, (samples, judged)."""
    used: str = ""
    """Runtime of the run, `C` or `floats`."""

    def find_largest_gap(self, before: Row, samples: int | None = None) -> Row:
        """Return the largest difference of every judged output to the pass before; empty if none is known.

        Args:
            before: largest differences before this run.
            samples: number of compared samples that count; all if None.
        """
        if not len(self.gaps):
            return before
        largest = tuple(self.gaps[:samples].max(axis=0, initial=0.0).tolist())
        return tuple(map(max, before, largest)) if before else largest

    @property
    def ends(self) -> list[float]:
        """Return the ends of the recorded pieces of steps [s]."""
        return [float(row[2] + row[3]) for row in self.record if row[1] != START]

    @property
    def status_time(self) -> float | None:
        """When its status came about [s]; None for none, or where that was not recorded."""
        return None if self.status is Status.OK or math.isnan(self.time) else self.time

    def require(self) -> Marched:
        """Return it, or raise `SolveError` if it cannot be trusted."""
        if self.status.failed and self.status is not Status.OUT_OF_ENVELOPE:
            when = "during the run" if self.status_time is None else f"at t = {self.status_time:.6g} s"
            raise SolveError(f"The coupled step of law, heat and mechanism failed {when}. {self.status.sentence}")
        return self


class AbstractMarch:
    """One run under way, on floats."""

    def __init__(self, plan: MarchPlan, functions: Functions) -> None:
        self.plan, self.functions, self.size = plan, functions, plan.compiled.size
        self.readers = [Reader(waveform) for waveform in plan.waveforms]
        self.time, self.duration = plan.times[0], plan.times[-1]
        signals = self.signals(self.time)
        self.state: Row = plan.start or functions["init"](*signals)[: self.size]
        self.seen: Row = functions["judge"](*self.state, *signals)
        self.convergence_scales = len(plan.compiled.convergence_scales)
        judged, (low, high) = self.seen[: self.convergence_scales], plan.extremes
        self.low, self.high = list(map(min, judged, low or judged)), list(map(max, judged, high or judged))
        self.sample: int = 1
        self.found = Marched([functions["observe"](*self.state, *signals)])
        self.record_piece(START, self.time, self.time, (), self.state)
        self.check_envelope()

    @abstractmethod
    def advance(self) -> None:
        """Take one step, or some."""

    def run(self, watch: Callable[[float], None] | None = None) -> Marched:
        """To the end, or to where it cannot go on; `watch` is told the completed fraction."""
        found = self.found
        try:
            while self.time < self.duration and not found.status.failed:
                self.advance()
                if watch is not None:
                    watch((self.time - self.plan.times[0]) / (self.duration - self.plan.times[0]))
        except ArithmeticError:  # a division by zero or an overflow
            found.status = Status.NOT_FINITE
        if found.status.failed or found.status is Status.OK:
            found.time = self.time
        found.ranges = tuple(b - a for a, b in zip(self.low, self.high, strict=True))
        found.state, found.extremes = self.state, (tuple(self.low), tuple(self.high))
        return found

    def signals(self, time: float, before: bool = False) -> Row:
        """Return the drive signals at a time [s], or just before it."""
        return tuple(r.before(time) if before else r.value(time) for r in self.readers)

    def record_piece(self, part: int, begin: float, end: float, brought: Sequence[float], state: Row) -> None:
        """Record a piece of an accepted step, from what the drives brought in it, and the state at its end."""
        if not self.plan.recorded:
            return
        row, at = [0.0, float(part), begin, end - begin], 0
        for reader, width in zip(self.readers, self.plan.compiled.widths, strict=True):
            after = reader.level(begin)
            before = after if part == START else reader.level(end, before=True)
            wide = width > 1 and part != START
            row += [after, before, *(brought[at : at + 5] if wide else (after, after * after, after, after, 0.0))]
            at += width
        self.found.record.append((*row, *state))

    def see(self, seen: Row) -> None:
        """Note what is judged at the end of a step."""
        self.seen = seen
        for k in range(self.convergence_scales):
            self.low[k], self.high[k] = min(self.low[k], seen[k]), max(self.high[k], seen[k])
        self.check_envelope()

    def check_envelope(self) -> None:
        """Stop where the envelope is left."""
        found, limits = self.found, self.plan.limits
        gone = limits.find_exit(self.seen[self.convergence_scales :])
        if gone is not None and not found.status.failed:
            finite = math.isfinite(gone.value)
            found.status = Status.OUT_OF_ENVELOPE if finite else Status.NOT_FINITE
            found.place, found.value = gone
