"""The march on plain floats: for single runs, in a process that needs no numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.errors import SolveError
from martensite.base.status import Status
from martensite.simulate.compiled import CompiledMarch, Functions
from martensite.simulate.grid import TimeGrid
from martensite.simulate.marching import RunLimits

SOLVED = 1e-8
COARSE = 0.2


@dataclass(frozen=True)
class Track:
    """What one march returns: rows of outputs at the samples, and how its steps ended."""

    rows: Sequence[Sequence[float]]
    status: Status
    status_time: float | None
    """Start of the first step with this status [s], or where it left the envelope; None where it
    was not recorded."""
    place: int = -1
    """Which limit of the envelope was passed; -1 if none, or if that was not recorded."""
    value: float = 0.0
    """What came there, in SI."""

    def require(self) -> Track:
        """Return this track, or raise `SolveError` if it cannot be trusted."""
        if self.status.failed and self.status is not Status.OUT_OF_ENVELOPE:
            when = "during the run" if self.status_time is None else f"{self.status_time:.6g} s"
            raise SolveError(
                f"The coupled step of law, heat and mechanism failed at t = {when}. {self.status.sentence}"
            )
        return self


def march_floats(functions: Functions, size: int, grid: TimeGrid, border: Border | None = None) -> Track:
    """Advance through the grid with traced float functions; failures are a status.

    It stops where it comes to the border of the envelope, if there is one.
    """
    step, observe = functions["step"], functions["observe"]
    state = functions["init"](*grid.sampled[0])
    rows = [observe(*state, *grid.sampled[0])]
    watch = WorstStep()
    k = 0
    try:
        for count, drives in zip(grid.counts, grid.sampled[1:], strict=True):
            for u, dt in zip(grid.drives[k : k + count], grid.lengths[k : k + count], strict=True):
                after = step(*state, *u, dt)
                state = after[:size]
                watch.note(after[size], after[size + 1], k)
                k += 1
                if border is not None and border.is_passed(state, border.signals(u)):
                    return _stop_track(rows, watch, border, math.fsum(grid.lengths[:k]))
            rows.append(observe(*state, *drives))
    except ArithmeticError:  # a division by zero or an overflow
        watch.note(math.inf, 0.0, k)
    return check_track(rows, watch.worst, math.fsum(grid.lengths[: watch.step]))


def _stop_track(rows: Sequence[tuple[float, ...]], watch: WorstStep, border: Border, time: float) -> Track:
    """A track that ended at a border; one that had failed before is not to be trusted either."""
    if watch.worst.failed:
        return check_track(rows, watch.worst, time)
    return Track(list(rows), Status.OUT_OF_ENVELOPE, time, border.place, border.value)


class Border:
    """The envelope of a run on floats, looked at from inside."""

    def __init__(self, compiled: CompiledMarch, functions: Functions, limits: RunLimits) -> None:
        self.judge, self.limits = functions["judge"], limits
        self.first, self.places = len(compiled.convergence_scales), compiled.signals_in_step()
        self.place, self.value = -1, 0.0

    def signals(self, inputs: Sequence[float]) -> list[float]:
        """The signals of a step from its inputs."""
        return [inputs[place] for place in self.places]

    def is_passed(self, state: Sequence[float], signals: Sequence[float]) -> bool:
        """Whether a state is outside; where it is, and how far, is kept."""
        seen = self.judge(*state, *signals)[self.first :]
        rows = zip(self.limits.low, seen, self.limits.high, strict=False)
        for place, (low, value, high) in enumerate(rows):
            if math.isfinite(value) and not low <= value <= high:
                self.place, self.value = place, value
                return True
        return False


class WorstStep:
    """Remembers the worst step and where it was."""

    def __init__(self) -> None:
        self.worst = Status.OK
        self.step = 0

    def note(self, residual: float, crossing: float, step: int) -> None:
        """Classify a step if its report is suspicious; called for every step."""
        if residual <= SOLVED and crossing <= COARSE:
            return
        status = classify_step(residual, crossing)
        if status > self.worst:
            self.worst, self.step = status, step


def classify_step(residual: float, crossing: float) -> Status:
    """Status of a step from its report."""
    if math.isnan(residual) or math.isinf(residual):
        return Status.NOT_FINITE
    if residual > SOLVED:
        return Status.UNSOLVED
    return Status.LONG_STEP if crossing > COARSE else Status.OK


def check_track(rows: Sequence[tuple[float, ...]], status: Status, time: float | None = None) -> Track:
    """A track whose rows have been checked for numbers that are none."""
    finite = all(math.isfinite(value) for row in rows for value in row)
    return Track(list(rows), status if finite else Status.NOT_FINITE, time)


def track_of(table: Any, residual: float, crossing: float, ripple: float, left: float = math.inf) -> Track:
    """A track whose rows are an array (samples, outputs), from its worst reports.

    One that `left` the envelope at a time [s] has that status, unless it had failed before.
    """
    import numpy as np

    if left < math.inf and not classify_step(residual, crossing).failed:
        return Track([], Status.OUT_OF_ENVELOPE, left)
    finite = bool(np.isfinite(table).all())
    status = classify_step(residual, crossing) if finite else Status.NOT_FINITE
    return Track(table.tolist(), status, None)
