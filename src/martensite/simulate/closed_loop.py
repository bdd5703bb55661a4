"""Closed-loop simulation: a drive measures at the start of every period and sets the signal.

The signal is held for the period. With `pulses` the signal is a duty cycle, and the pulse is at the start of the
period. Steps end at pulse ends.

Measurements are taken at the start of a period. Electrical outputs are taken at the end of the last pulse, since an
open switch permits no measurement. The first electrical outputs are measured under the signal `probe`.

A waveform is a drive without measurement; a controller uses measurements.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from martensite.actuators.assembly import System
from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.signals.carrier import Carrier, limit_duty
from martensite.signals.held import Held
from martensite.simulate.alarms import judge_limits
from martensite.simulate.api import first_step
from martensite.simulate.compiled import bind_system
from martensite.simulate.envelope import Envelope, describe_exit, rows_inside
from martensite.simulate.grid import MOST_STEPS
from martensite.simulate.march import FloatWalk
from martensite.simulate.marching import MarchResult, Row
from martensite.simulate.restarts import HOME
from martensite.simulate.result import Result
from martensite.simulate.start_report import describe_start
from martensite.simulate.tracing import AbstractTrace, RowsTrace

ELECTRICAL = ("drive", "resistance", "current", "voltage", "power")
"""Outputs that are measured while the source is on."""


@dataclass(frozen=True)
class LoopPlan:
    """Settings of a loop except its number of iterations."""

    system: System
    drive: AbstractDrive
    periods: int
    period: float
    is_pulsed: bool
    shortest: float
    """Shortest pulse or gap [s]."""
    probe: float
    step: float
    """Longest step [s]."""

    def start(self, k: int) -> float:
        """Return the start of a period [s], with the rounding of waveforms."""
        return k / (1.0 / self.period)

    def pieces(self, signal: float) -> list[tuple[float, float]]:
        """Return the signals and lengths [s] of the parts of a period."""
        if not self.is_pulsed:
            return [(signal, self.period)]
        share = limit_duty(signal, self.shortest / self.period)
        both = (1.0, share * self.period), (0.0, (1.0 - share) * self.period)
        return [(level, length) for level, length in both if length > 0.0]

    def waveform(self, signals: Sequence[float]) -> AbstractWaveform:
        """Return the applied signals as a waveform."""
        frequency = 1.0 / self.period
        staircase = Held(values=tuple(signals), frequency=frequency)
        if not self.is_pulsed:
            return staircase
        return Carrier(duty=staircase, frequency=frequency, shortest=self.shortest)


def whole_periods(duration: float, period: float) -> int:
    """Return the number of periods of a run; raise `ParameterError` if it is not an integer."""
    for name, value in (("duration", duration), ("period", period)):
        if not 0.0 < value < math.inf:
            raise ParameterError(f"Argument `{name}` must be above 0 s, but is {value}.")
    periods = round(duration / period)
    if periods < 1 or abs(periods * period - duration) > 1e-9 * duration:
        raise ParameterError(
            f"Argument `duration` must be a whole number of periods of {period:.6g} s, but is {duration:.6g} s."
        )
    return periods


def check_loop(system: System, pulses: bool, shortest: float, period: float, step: float | None) -> None:
    """Raise `InputError` for arguments that are inconsistent with the system."""
    source = system.source
    if source.sets_temperature:
        raise InputError("A loop needs a drive that heats; `temperature` sets it instead.")
    if pulses and source.unit != "1":
        raise InputError(f"Pulses need a drive that is a switch, `pwm-voltage`, but it is `{source.registered_name}`.")
    if shortest and not (pulses and 0.0 < shortest <= 0.5 * period):
        raise ParameterError(
            f"Argument `shortest` must be at most half a period, and is for pulses only, but is {shortest} s."
        )
    if step is not None and not 0.0 < step < math.inf:
        raise ParameterError(f"Argument `step` must be above 0 s, but is {step}.")


@dataclass(frozen=True)
class LoopResult:
    """Closed-loop run, by period."""

    result: Result
    """Samples at the starts of the periods and at the end."""
    period: float
    """[s]"""
    signals: list[float]
    """Signal of the drive in each period."""
    ends: dict[str, list[float]]
    """Outputs at the end of the pulse or the period, for complete periods."""
    means: dict[str, list[float]]
    """Mean outputs of each period; mean duty cycle or signal for the drive."""


def simulate_loop(
    system: System,
    drive: AbstractDrive,
    duration: float,
    period: float,
    *,
    pulses: bool = False,
    shortest: float = 0.0,
    probe: float | None = None,
    step: float | None = None,
) -> LoopResult:
    """Simulate a system from equilibrium under a drive that is called at the start of every period.

    The drive receives the time [s], all outputs in SI by name, and its own memory, and returns the signal of the
    period. Runs use plain floats without error estimation, so compare with a run at half the step. A run that
    leaves the envelope stops with the status OUT_OF_ENVELOPE, at the start of that period.

    Args:
        system: element, environment, source and mechanism.
        drive: a controller, or a waveform.
        duration: length of the run [s], a whole number of periods.
        period: time between two calls of the drive [s].
        pulses: the signal is a duty and the source a switch (`pwm-voltage`).
        shortest: shortest pulse or gap of the switch [s], with `pulses` only.
        probe: signal under which the first electrical outputs are measured; on with `pulses`,
            else 0.
        step: longest step [s]; by default a tenth of the thermal time constant.

    Raises:
        InputError: an argument is out of range, or the source sets the temperature.
        SolveError: the run failed, or the drive returned no number.
    """
    periods = whole_periods(duration, period)
    check_loop(system, pulses, shortest, period, step)
    longest = step or min(first_step(system, duration, 2), period)
    if max(duration / longest, 2.0 * periods) > MOST_STEPS:
        raise InputError(f"The loop needs more than {MOST_STEPS:,} steps; shorten its duration.")
    started = probe if probe is not None else (1.0 if pulses else 0.0)
    plan = LoopPlan(system, drive, periods, period, pulses, shortest, started, longest)
    walk = _Walk(plan)
    return walk.loop(walk.run().require())


class _Walk:
    def __init__(self, plan: LoopPlan) -> None:
        functions, size = bind_system(plan.system)
        self.plan, self.walk = plan, FloatWalk(functions, size, (plan.probe,))
        self.observe: Callable[..., Row] = functions["observe"]
        self.names = tuple(plan.system.outputs())
        self.envelope = Envelope(plan.system)
        self.rows: list[Row] = []
        self.ends: list[Row] = []
        self.sums: list[list[float]] = []
        self.signals: list[float] = []
        self.passed: list[tuple[float, Row]] = []
        """Time [s] and outputs at both ends of every step."""
        self.times: list[float] = []
        """Start of every step [s]."""
        self.longest = self.end_time = 0.0
        self.switched: Row = self.observe(*self.walk.state, plan.probe)
        """Outputs when the source was last on."""

    def run(self) -> MarchResult:
        """Run all periods; failures set the status. Of a period that leaves the envelope only the start is kept."""
        memory: Any = self.plan.drive.init()
        try:
            for k in range(self.plan.periods):
                memory = self._period(self.plan.start(k), memory)
                if self.walk.gone is not None:
                    whole = len(self.rows) - 1
                    self.ends, self.sums = self.ends[:whole], self.sums[:whole]
                    break
            else:
                last = self.plan.pieces(self.signals[-1])[0][0]
                self.rows.append(self.observe(*self.walk.state, last))
        except ArithmeticError:  # division by zero or overflow
            self.walk.note(math.inf, 0.0)
        return self.walk.finish(self.rows, lambda k: self.times[k] if k < len(self.times) else self.end_time)

    def _period(self, time: float, memory: Any) -> Any:
        row = self.observe(*self.walk.state, self.switched[0])
        outputs = dict(zip(self.names, row, strict=False))  # a profile comes after
        outputs |= {name: self.switched[self.names.index(name)] for name in ELECTRICAL}
        signal, memory = self.plan.drive(time, outputs, memory)
        if not math.isfinite(signal):
            raise SolveError(f"The drive returned {signal} at t = {time:.6g} s.")
        self.signals.append(signal)
        pieces = self.plan.pieces(signal)
        self.rows.append(self.observe(*self.walk.state, pieces[0][0]))
        self.sums.append([0.0] * len(self.rows[-1]))
        for number, (level, length) in enumerate(pieces):
            end = self._piece(time, level, length)
            time += length
            if self.walk.gone is not None:
                break
            if number == 0:
                on = level != 0.0 or not self.plan.is_pulsed
                self.ends.append(end if on else self.rows[-1])
                self.switched = end if on else self.switched
        return memory

    def _piece(self, time: float, level: float, length: float) -> Row:
        """Continue under one signal and return the outputs at the end."""
        steps = max(1, math.ceil(length / self.plan.step - 1e-9))
        dt = length / steps
        self.longest = max(self.longest, dt)
        half, sums = 0.5 * dt / self.plan.period, self.sums[-1]
        before = self.observe(*self.walk.state, level)
        self.passed.append((time, before))
        for k in range(steps):
            self.times.append(time + k * dt)
            self.end_time = time + (k + 1) * dt
            self.walk.advance((level,), dt)
            row = self.observe(*self.walk.state, level)
            sums[:] = [s + half * (a + b) for s, a, b in zip(sums, before, row, strict=True)]
            before = row
            self.passed.append((self.end_time, row))
            if self.walk.stops(self.envelope.find_exit(row, finite=True)):
                break
        return before

    def loop(self, run: MarchResult) -> LoopResult:
        """Return the result, with its alarms."""
        plan, count = self.plan, len(self.times)
        times = np.array([plan.start(k) for k in range(len(run.rows))], float)
        result = Result(
            plan.system,
            plan.waveform(self.signals),
            times,
            {name: np.array(one) for name, one in self._columns(run.rows).items()},
            run.status,
            run.status_time,
            count,
            self.longest,
            trace=self._trace(),
            begin=partial(describe_start, HOME),
            judged=judge_limits,
        )
        ends = self._columns(self.ends)
        if run.status is Status.OUT_OF_ENVELOPE:
            result = replace(result, notes=[describe_exit(plan.system, run.time, run.place, run.value)])
        return LoopResult(result, plan.period, self.signals, ends, self._columns(self.sums))

    def _trace(self) -> AbstractTrace:
        """Return the outputs at both ends of all steps, with the demand of the drive."""
        rows = [row for _, row in self.passed]
        inside_rows = rows if self.walk.gone is None else list(rows_inside(self.plan.system, rows))
        times, place = [time for time, _ in self.passed[: len(inside_rows)]], self.names.index("drive")
        table = np.array(inside_rows)
        if self.plan.is_pulsed:
            periods = np.searchsorted([self.plan.start(k) for k in range(len(self.signals))], times, side="right") - 1
            table[:, place] = np.array(self.signals)[periods]
        return RowsTrace(times, table, len(self.names))

    def _columns(self, rows: Sequence[Sequence[float]]) -> dict[str, list[float]]:
        return {name: [row[i] for row in rows] for i, name in enumerate(self.names)}
