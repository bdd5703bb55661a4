"""The march in a loop: at the start of every period a drive measures, and sets the signal.

The signal is held for the period. With `pulses` it is a duty, and the source is on for that
share of the period, from its start, and off for the rest. Steps end where pulses end.

What is measured at the start of a period is the state then. Electrical outputs are those at the
end of the last pulse, since nothing can be measured on an open switch; without a pulse in the
last period they are those of an earlier one. The first ones are measured under the signal
`probe` before anything moves.

A waveform is a drive that ignores what is measured; a controller uses it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from martensite.actuators.assembly import System
from martensite.base.errors import InputError, SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractDrive
from martensite.simulate.api import first_step
from martensite.simulate.compiled import bind_system
from martensite.simulate.envelope import Envelope, describe_exit
from martensite.simulate.grid import MOST_STEPS
from martensite.simulate.loop_plan import LoopPlan, check_loop, whole_periods
from martensite.simulate.march import Track, WorstStep, check_track
from martensite.simulate.marching import Exit
from martensite.simulate.result import Result
from martensite.simulate.warnings import add_warnings

ELECTRICAL = ("drive", "resistance", "current", "voltage", "power")
"""Outputs that are measured while the source is on."""
Row = tuple[float, ...]


@dataclass(frozen=True)
class LoopResult:
    """A run in a loop, period by period."""

    result: Result
    """Sampled at the starts of the periods, and at the end."""
    period: float
    """[s]"""
    signals: list[float]
    """What the drive asked for in each period."""
    ends: dict[str, list[float]]
    """Outputs at the end of each signal: of the pulse, or of the period; of whole periods."""
    means: dict[str, list[float]]
    """Outputs averaged over each period; of the drive the share that is on, or the signal."""


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
    """Run a system from rest under a drive that is called at the start of every period.

    The drive gets the time [s], all outputs in SI by name, and its own memory, and answers with
    the signal of the period. Runs on plain floats; no accuracy is estimated, so compare with a
    run in half the step. A run that comes to where no wire can be stops there, with the status
    OUT_OF_ENVELOPE; what is returned ends with the start of the period in which it did.

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
        SolveError: the run failed, or the drive answered with no number.
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


@dataclass
class _Walk:
    """One march through all periods."""

    plan: LoopPlan
    rows: list[Row] = field(default_factory=list[Row])
    ends: list[Row] = field(default_factory=list[Row])
    sums: list[list[float]] = field(default_factory=list[list[float]])
    signals: list[float] = field(default_factory=list[float])
    watch: WorstStep = field(default_factory=WorstStep)
    times: list[float] = field(default_factory=list[float])
    """Start of every step [s]."""
    longest: float = 0.0
    gone: Exit | None = None
    """Where the envelope was left, and when [s]."""
    left: float = 0.0

    def __post_init__(self) -> None:
        functions, self.size = bind_system(self.plan.system)
        self.advance: Callable[..., Row] = functions["step"]
        self.observe: Callable[..., Row] = functions["observe"]
        self.names = tuple(self.plan.system.outputs())
        self.envelope = Envelope(self.plan.system)
        self.state: Row = functions["init"](self.plan.probe)
        self.switched: Row = self.observe(*self.state, self.plan.probe)
        """Outputs when the source was last on."""

    def run(self) -> Track:
        """All periods; failures are a status."""
        memory: Any = self.plan.drive.init()
        try:
            for k in range(self.plan.periods):
                memory = self._period(self.plan.start(k), memory)
                if self.gone is not None and not self.watch.worst.failed:
                    return self._cut_at_stop(self.gone)
            last = self.plan.pieces(self.signals[-1])[0][0]
            self.rows.append(self.observe(*self.state, last))
        except ArithmeticError:  # a division by zero or an overflow
            self.watch.note(math.inf, 0.0, max(len(self.times) - 1, 0))
        noted = self.times if self.watch.worst is not Status.OK else []
        return check_track(self.rows, self.watch.worst, noted[self.watch.step] if noted else None)

    def _cut_at_stop(self, gone: Exit) -> Track:
        """A run that left the envelope; of the last period only the start is kept."""
        whole = len(self.rows) - 1
        self.ends, self.sums = self.ends[:whole], self.sums[:whole]
        return Track(self.rows, Status.OUT_OF_ENVELOPE, self.left, gone.place, gone.value)

    def _period(self, time: float, memory: Any) -> Any:
        seen = self.observe(*self.state, self.switched[0])
        found = dict(zip(self.names, seen, strict=False))  # a profile comes after
        found |= {name: self.switched[self.names.index(name)] for name in ELECTRICAL}
        signal, memory = self.plan.drive(time, found, memory)
        if not math.isfinite(signal):
            raise SolveError(f"The drive answered with {signal} at t = {time:.6g} s.")
        self.signals.append(signal)
        pieces = self.plan.pieces(signal)
        self.rows.append(self.observe(*self.state, pieces[0][0]))
        self.sums.append([0.0] * len(self.rows[-1]))
        for number, (level, length) in enumerate(pieces):
            end = self._piece(time, level, length)
            time += length
            if self.gone is not None:
                break
            if number == 0:
                on = level != 0.0 or not self.plan.pulses
                self.ends.append(end if on else self.rows[-1])
                self.switched = end if on else self.switched
        return memory

    def _piece(self, time: float, level: float, length: float) -> Row:
        """Go on under one signal; its outputs at the end."""
        steps = max(1, math.ceil(length / self.plan.step - 1e-9))
        dt = length / steps
        self.longest = max(self.longest, dt)
        half, sums = 0.5 * dt / self.plan.period, self.sums[-1]
        before = self.observe(*self.state, level)
        for k in range(steps):
            self.times.append(time + k * dt)
            after = self.advance(*self.state, level, dt)
            self.state = after[: self.size]
            self.watch.note(after[self.size], after[self.size + 1], len(self.times) - 1)
            row = self.observe(*self.state, level)
            sums[:] = [s + half * (a + b) for s, a, b in zip(sums, before, row, strict=True)]
            before = row
            gone = self.envelope.find_exit(row)
            if gone is not None and math.isfinite(gone.value):
                self.gone, self.left = gone, time + (k + 1) * dt
                break
        return before

    def loop(self, found: Track) -> LoopResult:
        """What was found, with its alarms."""
        plan, count = self.plan, len(self.times)
        times = [plan.start(k) for k in range(len(found.rows))]
        result = Result(
            plan.system,
            plan.waveform(self.signals),
            times,
            self._columns(found.rows),
            found.status,
            found.status_time,
            count,
            self.longest,
        )
        ends = self._columns(self.ends)
        if found.status is Status.OUT_OF_ENVELOPE:
            when = found.status_time or 0.0
            result.warnings.append(describe_exit(plan.system, when, found.place, found.value))
        add_warnings(result, self._add_peaks(result.columns, ends))
        return LoopResult(result, plan.period, self.signals, ends, self._columns(self.sums))

    def _add_peaks(self, starts: dict[str, list[float]], ends: dict[str, list[float]]) -> dict[str, list[float]]:
        """Columns with the peaks at the ends of pulses, and with what the drive asked for."""
        peaks = {name: [*map(max, starts[name], ends[name]), starts[name][-1]] for name in ("hottest", "stress")}
        asked = [*self.signals, self.signals[-1]][: len(starts["drive"])]
        return {**starts, **peaks, "drive": asked}

    def _columns(self, rows: Sequence[Sequence[float]]) -> dict[str, list[float]]:
        return {name: [row[i] for row in rows] for i, name in enumerate(self.names)}
