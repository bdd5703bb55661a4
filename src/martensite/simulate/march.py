"""Time integration on given steps with plain floats, for single runs without numpy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any, cast

from martensite.base.errors import SolveError
from martensite.base.status import Status
from martensite.signals.moments import Moments
from martensite.simulate.compiled import CompiledMarch, Functions, feed_step
from martensite.simulate.grid import TimeGrid
from martensite.simulate.marching import STEP_TOLERANCE, WHOLE, AbstractMarch, Exit, MarchResult, Row, RunLimits

SOLVED = 1e-8
COARSE = 0.2


def march_floats(
    functions: Functions, size: int, grid: TimeGrid, border: Border | None = None, start: Row = ()
) -> MarchResult:
    """Advance through the grid with float functions, from a start or equilibrium.

    Failures set the status. The run stops at the border of the envelope, if given.

    Raises:
        SolveError: its first state has no outputs.
    """
    sampled, inputs = grid.list_inputs()
    try:
        walk, observe = FloatWalk(functions, size, sampled[0], start), functions["observe"]
        rows = [observe(*walk.state, *sampled[0])]
    except ArithmeticError as error:
        raise SolveError(
            f"The run fails at its start (0 s): {error}. Check for a length, width or range of 0."
        ) from None
    steps = zip(inputs, grid.lengths, strict=True)
    try:
        for count, drives in zip(grid.counts, sampled[1:], strict=True):
            for u, dt in islice(steps, count):
                walk.advance(u, dt)
                if border is not None and walk.stops(border.find_exit(walk.state, u)):
                    break
            if walk.gone is not None:
                break
            rows.append(observe(*walk.state, *drives))
    except ArithmeticError:  # division by zero or overflow
        walk.note(math.inf, 0.0)
    return walk.finish(rows, lambda k: grid.times[0] + math.fsum(grid.lengths[:k]))


class Border:
    """Envelope of a run on floats."""

    def __init__(self, compiled: CompiledMarch, functions: Functions, limits: RunLimits) -> None:
        self.judge, self.limits = functions["judge"], limits
        self.first, self.places = len(compiled.convergence_scales), compiled.signals_in_step()

    def find_exit(self, state: Row, inputs: Sequence[float]) -> Exit | None:
        """Return the exit of a state from the limits under step inputs; None if it is inside."""
        judged_outputs = self.judge(*state, *(inputs[place] for place in self.places))
        return self.limits.find_exit(judged_outputs[self.first :], finite=True)


class FloatWalk:
    """Steps of a system on plain floats, with the worst report."""

    def __init__(self, functions: Functions, size: int, signals: Sequence[float], start: Row = ()) -> None:
        self.step, self.size = functions["step"], size
        self.state: Row = start or functions["init"](*signals)
        self.steps, self.gone = 0, cast("Exit | None", None)
        self.worst, self.worst_step = Status.OK, 0

    def advance(self, inputs: Sequence[float], dt: float) -> None:
        """Advance one step of dt [s] under signals or drive inputs."""
        size = self.size
        after = self.step(*self.state, *inputs, dt)
        self.state = after[:size]
        if not (after[size] <= SOLVED and after[size + 1] <= COARSE):
            self.note(after[size], after[size + 1])
        self.steps += 1

    def note(self, residual: float, crossing: float) -> None:
        """Update the status with the report of a step."""
        status = classify_step(residual, crossing)
        if status > self.worst:
            self.worst, self.worst_step = status, self.steps

    def stops(self, crossing: Exit | None) -> bool:
        """Return whether the run leaves the envelope and must end."""
        self.gone = crossing
        return crossing is not None

    def finish(self, rows: Sequence[Row], time_of: Callable[[int], float]) -> MarchResult:
        """Return the result from the rows and the start of a step [s].

        An earlier failure has priority over leaving the envelope.
        """
        if self.gone is not None and not self.worst.failed:
            return MarchResult(list(rows), (), Status.OUT_OF_ENVELOPE, time_of(self.steps), *self.gone, self.steps)
        finite = all(math.isfinite(value) for row in rows for value in row)
        status = self.worst if finite else Status.NOT_FINITE
        return MarchResult(list(rows), (), status, time_of(self.worst_step), steps=self.steps, state=self.state)


class FixedMarch(AbstractMarch):
    """Run with steps of at most `MarchPlan.step`, equal between samples and drive edges.

    No error is estimated. A step that crosses much of a transformation sets the status LONG_STEP.
    """

    def advance(self) -> None:
        """Advance to the next sample or edge."""
        plan = self.plan
        step = plan.step or plan.times[-1]
        begin, sample = self.time, plan.times[self.sample]
        hair = 1e-12 * self.duration
        edges = (e for r in self.readers for e in r.edges(begin + hair, sample - hair))
        end = min(edges, default=sample)
        count = max(1, math.ceil((end - begin) / step - STEP_TOLERANCE))
        length = (end - begin) / count
        for k in range(count):
            here = begin + k * length
            self._step(here, length, end if k + 1 == count else here + length)
            if self.result.status.failed:
                return
        self.time = end
        if end == sample:
            signals = self.signals(sample)
            self.result.rows.append(self.functions["observe"](*self.state, *signals))
            self.sample += 1
        for reader in self.readers:
            reader.forget(end)

    def _step(self, begin: float, length: float, end: float) -> None:
        inputs = list[float]()
        for reader, width in zip(self.readers, self.plan.compiled.widths, strict=True):
            drive_input = reader.moments(begin, end) if width > 1 else reader.before(end)
            inputs += feed_step(drive_input) if isinstance(drive_input, Moments) else (drive_input,)
        after = self.functions["step"](*self.state, *inputs, length)
        residual, crossing, ripple = after[self.size :]
        run, self.state = self.result, after[: self.size]
        self.record_piece(WHOLE, begin, end, inputs, self.state)
        run.steps += 1
        run.longest, run.ripple = max(run.longest, length), max(run.ripple, ripple)
        run.residual = max(run.residual, residual)
        status = classify_step(residual, crossing)
        if status > run.status:
            run.status, run.time = status, begin
        self.time = begin
        self.see(self.functions["judge"](*self.state, *self.signals(end, before=True)))


def classify_step(residual: float, crossing: float) -> Status:
    """Return the status of a step from its report."""
    if math.isnan(residual) or math.isinf(residual):
        return Status.NOT_FINITE
    if residual > SOLVED:
        return Status.UNSOLVED
    return Status.LONG_STEP if crossing > COARSE else Status.OK


def judge_table(
    table: Any, residual: float, crossing: float, left: float = math.inf, state: Sequence[float] = ()
) -> MarchResult:
    """Return the result of a run with rows as an array (samples, outputs), from its worst reports.

    A run that `left` the envelope at a time [s] has that status, unless it failed before.
    """
    import numpy as np

    if left < math.inf and not classify_step(residual, crossing).failed:
        return MarchResult([], (), Status.OUT_OF_ENVELOPE, left)
    finite = bool(np.isfinite(table).all())
    status = classify_step(residual, crossing) if finite else Status.NOT_FINITE
    return MarchResult(table, (), status, math.nan, state=tuple(state))
