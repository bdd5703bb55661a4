"""Calibration in the loop: resistance of a wire in martensite and austenite, by one guarded heating.

    cold     the probing signal, for `cold`                                R_M: mean of the readings
    pulse    the largest signal, for an energy of the model; then the      has R changed by `visible`?
             probing signal until `apart` is over
    heat     the heating power grows e-fold in every `growth`              ends `after` R has changed as in the pulse
    soak     a fraction of the signal reached, from `soak` to              R_A: mean of the readings, until it is
             `longest_soak`                                                known to `sharp` of the change
    settle   the probing signal, until `duration` is over                  the wire cools and transforms back
    ready

Power grows exponentially, so that a wire with a small heat loss is heated as slowly, relative to its loss, as a wire
with a large one: the overshoot beyond the end of the transformation does not depend on the heat loss. A running mean of
R measures its change, c = |m - R_M|/R_M. The largest change of the pulse is reached before the end of a transformation.
When heating has changed R by the fraction `enough` of it, the power grows for the time `after`, which completes the
transformation of every wire. This works for wires whose phases differ by little, where the end of a transformation
cannot be seen in the noise. The soak is cooler than the end of heating and hotter than the start of the reverse
transformation.

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
"""Time constants of the running mean in the pulse and in the heating [s]."""
TINY = 1e-12
"""Least resistance [ohm]."""


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
    mean: Scalar
    """Running mean of the readings [ohm]."""
    pulsed: Scalar
    """Largest relative change of the resistance in the pulse."""
    late: Scalar
    """Time of heating after the fraction `enough` of this change [s]."""
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
    visible: Number = param("1", "change of the resistance that a transformation must have", above=0.0, default=0.012)
    growth: Number = param("s", "time in which the signal grows e-fold", above=0.0, default=15.0)
    longest: Number = param("s", "longest time of the heating", above=0.0, default=36.0)
    enough: Number = param("1", "fraction of the change in the pulse", above=0.0, high=1.0, default=0.6)
    after: Number = param("s", "time of heating after this fraction", above=0.0, default=2.5)
    share: Number = param("1", "signal of the soak, over the end of heating", above=0.0, high=1.0, default=0.7)
    soak: Number = param("s", "shortest time in austenite", above=0.0, default=4.0)
    longest_soak: Number = param("s", "longest time in austenite", above=0.0, default=12.0)
    sharp: Number = param(
        "1",
        "standard deviation of R_A, over the change of the resistance, that ends the soak",
        above=0.0,
        default=0.012,
    )
    duration: Number = param("s", "total time", above=0.0, default=80.0)

    def check(self) -> None:
        taken = self.cold + self.apart + self.longest + max(self.soak, self.longest_soak)
        if not taken < self.duration:
            raise ParameterError(
                f"A calibration of {self.duration:g} s has no time to cool: cold, pulse, longest heating and soak take "
                f"{taken:g} s."
            )

    def rest(self, reading: Scalar) -> CalibrationState:
        """Return the initial state with a first reading."""
        return CalibrationState(float(COLD), 0.0, 0.0, 0.0, 0.0, reading, 0.0, 0.0, self.probe, reading, reading, 0.0)

    def advance(
        self,
        xp: Namespace,
        before: CalibrationState,
        reading: Scalar,
        fresh: Scalar,
        dt: Scalar,
        heated: Scalar,
        noise: Scalar,
    ) -> CalibrationState:
        """Advance the calibration by a sample.

        Args:
            xp: namespace.
            before: state after the last sample.
            reading: resistance [ohm].
            fresh: 1 for a new reading, else 0.
            dt: time since the last sample [s].
            heated: energy since then, over the energy of the heating without latent heat.
            noise: relative standard deviation of a reading.
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
        complete = state.late > self.after
        ends = [
            state.clock >= self.cold,
            state.clock >= self.apart,
            xp.either(complete, lost),
            xp.both(
                state.clock >= self.soak, xp.either(state.clock >= self.longest_soak, self._is_sharp(state, noise))
            ),
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
        failed = xp.either(failed, xp.both(at[PULSE], xp.both(ends[PULSE], state.pulsed < self.visible)))
        phase, signal = xp.where(failed, float(SETTLE), phase), xp.where(failed, self.probe, signal)
        moved = phase > before.phase + 0.5
        total, count, clock = (xp.where(moved, 0.0, x) for x in (total, state.count, state.clock))
        return state._replace(phase=phase, clock=clock, total=total, count=count, signal=signal)

    def _is_sharp(self, now: CalibrationState, noise: Scalar) -> Flag:
        """Return whether the noise of R_A is small compared with its distance from R_M."""
        way, error = now.austenite - now.martensite, noise * now.martensite / self.sharp
        return now.count * way * way >= error * error

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
        """Return the state with the running mean and its change; while cold the mean is R_M."""
        lag = xp.where(at[HEAT], SLOW, FAST)
        mean = xp.where(at[COLD], now.martensite, now.mean + step / (lag + dt) * (reading - now.mean))
        change = xp.abs(mean - now.martensite) / xp.maximum(xp.abs(now.martensite), TINY)
        pulsed = xp.where(at[PULSE], xp.maximum(now.pulsed, change), now.pulsed)
        has_begun = xp.either(change > self.enough * now.pulsed, now.late > 0.0)
        return now._replace(mean=mean, pulsed=pulsed, late=xp.where(xp.both(at[HEAT], has_begun), now.late + dt, 0.0))
