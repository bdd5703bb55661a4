"""Simulation with controllers that are called at the start of every period.

Waveforms continue from step to step. Controllers measure at the start of a period and hold their signals.
Measurements are all outputs in SI by name, under the signals of the previous period.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.signals.held import Held
from martensite.signals.moments import Moments
from martensite.signals.reader import Reader
from martensite.simulate.alarms import judge_limits
from martensite.simulate.api import first_step
from martensite.simulate.closed_loop import whole_periods
from martensite.simulate.compiled import bind_march, compile_march, feed_step
from martensite.simulate.drive_waveforms import arrange_waveforms
from martensite.simulate.envelope import describe_exit, envelope_of, rows_inside
from martensite.simulate.grid import MOST_STEPS, just_after
from martensite.simulate.march import Border, FloatWalk
from martensite.simulate.marching import MarchResult, Row
from martensite.simulate.restarts import HOME
from martensite.simulate.result import Result
from martensite.simulate.start_report import describe_start
from martensite.simulate.tracing import AbstractTrace, RowsTrace

Drives = Mapping[str, AbstractDrive]


def simulate_controlled(
    system: AbstractSystem,
    drives: AbstractDrive | Drives,
    duration: float,
    period: float,
    *,
    step: float | None = None,
    every: int = 1,
    watch: Callable[[float], None] | None = None,
) -> Result:
    """Simulate a system from equilibrium under controllers and waveforms.

    Runs use plain floats without error estimation, so compare with a run at half the step. A run that leaves the
    envelope stops with the status OUT_OF_ENVELOPE and ends with the last sample inside.

    Args:
        system: a `System` of one element, or a `Machine` of several.
        drives: controllers and waveforms by the name of what they drive; one alone for a system
            with one drive. What is not named gets 0; a temperature must be named.
        duration: length of the run [s], a whole number of periods.
        period: time between two calls of a controller [s].
        step: longest step [s]; by default as in the first run of `simulate`.
        every: periods per sample of the result.
        watch: called after every period with the fraction of the run that is done.

    Raises:
        InputError: a name, a unit or an argument does not fit.
        SolveError: the run failed, or a controller returned no number.
    """
    periods = whole_periods(duration, period)
    interval = system.sample_time()
    longest = min(interval or step or first_step(system, duration, 2), period)
    if interval and (abs(round(period / interval) * interval - period) > 1e-6 * interval or period < interval):
        raise ParameterError(
            f"Argument `period` must be a whole number of samples of {interval:.6g} s, but is {period:.6g} s."
        )
    if every < 1 or periods % every:
        raise ParameterError(f"Argument `every` must divide the {periods} periods of the run, but is {every}.")
    if duration / longest > MOST_STEPS:
        raise InputError(f"The run needs more than {MOST_STEPS:,} steps; shorten its duration.")
    pieces = max(1, math.ceil(period / longest - 1e-6))
    plan = _Plan(system, arrange_waveforms(system, drives), periods, period, pieces, every)
    walk = _ControlledWalk(plan)
    return walk.result(walk.run(watch).require())


@dataclass(frozen=True)
class _Plan:
    system: AbstractSystem
    drives: Sequence[AbstractDrive]
    periods: int
    period: float
    pieces: int
    """Steps in a period."""
    every: int


class _ControlledWalk:
    def __init__(self, plan: _Plan) -> None:
        functions, size = bind_march(plan.system)
        compiled = compile_march(plan.system)
        self.plan, self.widths, self.observe = plan, compiled.widths, functions["observe"]
        self.border = Border(compiled, functions, envelope_of(plan.system))
        self.names = tuple(plan.system.outputs())
        discrete = plan.system.sample_time() > 0.0
        self.shares = [just_after(drive.ahead) for drive in plan.system.drives()]
        self.readers = [
            Reader(drive) if isinstance(drive, AbstractWaveform) and not discrete else None for drive in plan.drives
        ]
        self.memories: list[Any] = [drive.init() for drive in plan.drives]
        self.rows: list[tuple[float, ...]] = []
        self.signals: list[tuple[float, ...]] = []
        self.now = self._signals(0.0, {})
        self.walk = FloatWalk(functions, size, self.now)
        self.outputs = self.observe(*self.walk.state, *self.now)
        self.passed: list[tuple[float, Row]] = []
        """Time [s] and outputs at the ends of steps, on both sides of a change of signals."""

    def run(self, tell: Callable[[float], None] | None) -> MarchResult:
        """Return all periods; failures set the status."""
        plan, walk = self.plan, self.walk
        try:
            for k in range(plan.periods):
                self._period(k)
                if walk.gone is not None:
                    break
                if tell is not None:
                    tell((k + 1) / plan.periods)
            else:
                self.rows.append(self.observe(*walk.state, *self.now))
        except ArithmeticError:  # division by zero or overflow
            walk.note(math.inf, 0.0)
        return walk.finish(self.rows, lambda k: k * plan.period / plan.pieces)

    def _period(self, k: int) -> None:
        plan, walk, time = self.plan, self.walk, k * self.plan.period
        self.now = self._signals(time, dict(zip(self.names, self.outputs, strict=False)))
        self.signals.append(self.now)
        row = self.observe(*walk.state, *self.now)
        self.passed.append((time, row))
        if k % plan.every == 0:
            self.rows.append(row)
        dt = plan.period / plan.pieces
        for piece in range(plan.pieces):
            inputs = self._collect_inputs(time + piece * dt, dt)
            walk.advance(inputs, dt)
            end = time + (piece + 1) * dt
            self.now = tuple(
                drive.value(end) if isinstance(drive, AbstractWaveform) else signal
                for drive, signal in zip(plan.drives, self.now, strict=True)
            )
            self.outputs = self.observe(*walk.state, *self.now)
            self.passed.append((end, self.outputs))
            if walk.stops(self.border.find_exit(walk.state, inputs)):
                return

    def _signals(self, time: float, outputs: Mapping[str, float]) -> tuple[float, ...]:
        """Return the signals of all drives at the start of a period."""
        signals: list[float] = []
        for i, drive in enumerate(self.plan.drives):
            if isinstance(drive, AbstractWaveform):
                signals.append(drive.value(time))
                continue
            signal, self.memories[i] = drive(time, outputs, self.memories[i]) if outputs else (0.0, self.memories[i])
            if not math.isfinite(signal):
                raise SolveError(f"A controller returned {signal} at t = {time:.6g} s.")
            signals.append(signal)
        return tuple(signals)

    def _collect_inputs(self, time: float, dt: float) -> tuple[float, ...]:
        """Return the drive inputs of a step: waveforms continue, controllers hold."""
        inputs: list[float] = []
        for i, (drive, signal) in enumerate(zip(self.plan.drives, self.now, strict=True)):
            reader, heats = self.readers[i], self.widths[i] > 1
            if reader is not None:
                end = time + dt
                inputs += feed_step(reader.moments(time, end)) if heats else (reader.before(end),)
            elif isinstance(drive, AbstractWaveform):
                inputs.append(drive.value(time + self.shares[i] * dt))
            else:
                inputs += feed_step(Moments.constant(signal)) if heats else (signal,)
        return tuple(inputs)

    def result(self, run: MarchResult) -> Result:
        """Return the result, with its alarms."""
        plan = self.plan
        times = np.array([k * plan.every * plan.period for k in range(len(run.rows))], float)
        columns = dict(zip(self.names, np.array(run.rows, float).T.copy(), strict=False))
        played: dict[str, AbstractWaveform] = {}
        drives = zip(plan.system.drives(), plan.drives, strict=True)
        for i, (declared, drive) in enumerate(drives):
            staircase = Held(values=tuple(s[i] for s in self.signals), frequency=1.0 / plan.period)
            played[declared.name] = drive if isinstance(drive, AbstractWaveform) else staircase
        result = Result(
            plan.system,
            played,
            times,
            columns,
            run.status,
            run.status_time,
            run.steps,
            plan.period / plan.pieces,
            trace=self._trace(),
            begin=partial(describe_start, HOME),
            judged=judge_limits,
        )
        if run.status is Status.OUT_OF_ENVELOPE:
            result = replace(result, notes=[describe_exit(plan.system, run.time, run.place, run.value)])
        return result

    def _trace(self) -> AbstractTrace:
        """Return the outputs at the ends of all steps."""
        rows = [row for _, row in self.passed]
        inside_rows = rows if self.walk.gone is None else list(rows_inside(self.plan.system, rows))
        return RowsTrace([time for time, _ in self.passed[: len(inside_rows)]], inside_rows, len(self.names))
