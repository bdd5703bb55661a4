"""Calibration in the loop: resistance of a wire in martensite and austenite, by one guarded heating.

    cold     the probing signal, for `cold`                                R_M: mean of the readings
    pulse    the largest signal, for an energy of the model; then the      has R changed by `visible`?
             probing signal until `apart` is over
    heat     the heating power grows e-fold in every `growth`              ends when R has changed and is constant
    soak     a fraction of the signal reached, for `soak`                  R_A: mean of the readings
    settle   the probing signal, until `duration` is over                  the wire cools and transforms back
    ready

Power grows exponentially, so that a wire with a small heat loss is heated as slowly, relative to its loss, as a wire
with a large one: the overshoot beyond the end of the transformation does not depend on the heat loss. Two running means
m₁ and m₂ with time constants of 0.3 s and 1.2 s measure the change of R, c = |m₁ - m₂|/R_M. A transformation has
started when c exceeds `seen`, and ended when c is below both `flat` and a fraction of its peak. The soak is cooler than
the end of heating and hotter than the start of the reverse transformation.

A wire whose resistance hardly changes would be heated too far. The short pulse detects it, since its effect depends on
its energy and hardly on the heat loss. The calibration fails if R does not change by `visible` during the pulse, or if
heating has not ended after `longest` or at `largest`.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.signals.base import DRIVE

COLD, PULSE, HEAT, SOAK, SETTLE, READY = range(6)
FAST, SLOW = 0.3, 1.2
"""Time constants of the running means [s]."""
LEFT = 0.3
"""Fraction of the peak of the change below which a transformation is over."""
HOLDS = 0.4
"""Time for which the change must stay below [s]."""


class CalibrationState(NamedTuple):
    """Memory of a calibration."""

    phase: Scalar
    elapsed: Scalar
    """Time since the start [s]."""
    clock: Scalar
    """Time in the phase [s]."""
    total: Scalar
    """Sum of the readings of the phase; during a pulse its relative energy."""
    count: Scalar
    fast: Scalar
    slow: Scalar
    peak: Scalar
    """Largest change in the phase."""
    flat: Scalar
    """Time since the end of the change [s]."""
    signal: Scalar
    martensite: Scalar
    """R_M [ohm]."""
    austenite: Scalar
    """R_A [ohm]."""
    done: Scalar
    """1 if R_A is known."""


class Calibration(Parametrised):
    """Signals and times of a calibration."""

    probe: Number = param(DRIVE, "signal of a current that measures but hardly heats", above=0.0, default=0.02)
    largest: Number = param(DRIVE, "largest signal of the heating", above=0.0, default=1.0)
    begin: Number = param("1", "signal at which heating begins, over the probing one", above=1.0, default=4.0)
    cold: Number = param("s", "time at the probing signal", above=0.0, default=8.0)
    pulse: Number = param("1", "energy of the pulse, over that for all but latent heat", above=0.0, default=1.6)
    apart: Number = param("s", "time from the pulse to the heating", above=0.0, default=16.0)
    visible: Number = param("1", "change of the resistance that a transformation must have", above=0.0, default=0.03)
    growth: Number = param("s", "time in which the signal grows e-fold", above=0.0, default=15.0)
    longest: Number = param("s", "longest time of the heating", above=0.0, default=36.0)
    beyond: Number = param("s", "time of further growth after the end", low=0.0, default=0.3)
    share: Number = param("1", "signal of the soak, over the end of heating", above=0.0, high=1.0, default=0.7)
    soak: Number = param("s", "time in austenite", above=0.0, default=4.0)
    duration: Number = param("s", "total time", above=0.0, default=80.0)
    seen: Number = param("1", "change of the resistance that shows a transformation", above=0.0, default=0.006)
    flat: Number = param("1", "change of the resistance that counts as zero", above=0.0, default=0.0035)

    def check(self) -> None:
        taken = self.cold + self.apart + self.longest + self.soak
        if not taken < self.duration:
            raise ParameterError(
                f"A calibration of {self.duration:g} s has no time to cool: cold, pulse, longest heating and soak take "
                f"{taken:g} s."
            )

    def rest(self, reading: Scalar) -> CalibrationState:
        """Return the initial state with a first reading."""
        means = (reading, reading)
        return CalibrationState(float(COLD), 0.0, 0.0, 0.0, 0.0, *means, 0.0, 0.0, self.probe, *means, 0.0)

    def advance(
        self, xp: Namespace, before: CalibrationState, reading: Scalar, fresh: Scalar, dt: Scalar, heated: Scalar
    ) -> CalibrationState:
        """Advance the calibration by a sample.

        Args:
            xp: namespace.
            before: state after the last sample.
            reading: resistance [ohm].
            fresh: 1 for a new reading, else 0.
            dt: time since the last sample [s].
            heated: energy since then, over the energy of the heating without latent heat.
        """
        at = [xp.both(before.phase > k - 0.5, before.phase < k + 0.5) for k in range(READY + 1)]
        state = self._average(
            xp, before._replace(elapsed=before.elapsed + dt, clock=before.clock + dt), at, reading, fresh
        )
        state = self._watch_change(xp, state, at, reading, fresh * dt, dt)
        total = xp.where(at[PULSE], before.total + heated, state.total)
        state = state._replace(total=total)
        grown = xp.minimum(before.signal * xp.exp(dt / self.growth), self.largest)
        lost = xp.either(state.clock >= self.longest, before.signal >= self.largest)
        complete = state.flat > HOLDS + self.beyond
        ends = [
            state.clock >= self.cold,
            state.clock >= self.apart,
            xp.either(complete, lost),
            state.clock >= self.soak,
            state.elapsed >= self.duration,
        ]
        phase, signal = before.phase, before.signal
        pulsed = xp.where(total < self.pulse, signal, self.probe)
        signal = xp.where(at[HEAT], grown, xp.where(at[PULSE], pulsed, signal))
        begin = self.begin * self.probe
        for k, then in enumerate([self.largest, begin, self.share * signal, self.probe, self.probe]):
            over = xp.both(at[k], ends[k])
            phase, signal = xp.where(over, k + 1.0, phase), xp.where(over, then, signal)
        failed = xp.both(at[HEAT], xp.both(lost, xp.negate(complete)))
        failed = xp.either(failed, xp.both(at[PULSE], xp.both(ends[PULSE], state.peak < self.visible)))
        phase, signal = xp.where(failed, float(SETTLE), phase), xp.where(failed, self.probe, signal)
        moved = phase > before.phase + 0.5
        total, count, clock, peak = (xp.where(moved, 0.0, x) for x in (total, state.count, state.clock, state.peak))
        return state._replace(phase=phase, clock=clock, total=total, count=count, peak=peak, signal=signal)

    def _average(
        self, xp: Namespace, now: CalibrationState, at: list[Flag], reading: Scalar, fresh: Scalar
    ) -> CalibrationState:
        total, count = now.total + fresh * reading, now.count + fresh
        some = count > 0.0
        mean = total / xp.where(some, count, 1.0)
        martensite = xp.where(xp.both(at[COLD], some), mean, now.martensite)
        soaked = xp.both(at[SOAK], some)
        austenite, done = xp.where(soaked, mean, now.austenite), xp.where(soaked, 1.0, now.done)
        return now._replace(total=total, count=count, martensite=martensite, austenite=austenite, done=done)

    def _watch_change(
        self, xp: Namespace, now: CalibrationState, at: list[Flag], reading: Scalar, step: Scalar, dt: Scalar
    ) -> CalibrationState:
        """Return the state with running means and their change; while cold they equal the mean reading."""
        fast = now.fast + step / (FAST + dt) * (reading - now.fast)
        slow = now.slow + step / (SLOW + dt) * (reading - now.slow)
        fast, slow = (xp.where(at[COLD], now.martensite, x) for x in (fast, slow))
        change = xp.abs(fast - xp.where(at[PULSE], now.martensite, slow)) / xp.maximum(xp.abs(now.martensite), 1e-12)
        peak = xp.where(xp.either(at[HEAT], at[PULSE]), xp.maximum(now.peak, change), 0.0)
        level = xp.both(peak > self.seen, change < xp.maximum(self.flat, LEFT * peak))
        stays = xp.both(at[HEAT], xp.either(level, now.flat > HOLDS))
        return now._replace(fast=fast, slow=slow, peak=peak, flat=xp.where(stays, now.flat + dt, 0.0))
