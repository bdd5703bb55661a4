"""What a run in a loop consists of: periods, and in them pieces of one signal each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import System
from martensite.base.errors import InputError, ParameterError
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.signals.carrier import Carrier, limit_duty
from martensite.signals.held import Held


@dataclass(frozen=True)
class LoopPlan:
    """Everything about a loop but its numbers of iterations."""

    system: System
    drive: AbstractDrive
    periods: int
    period: float
    pulses: bool
    shortest: float
    """Shortest pulse or gap [s]."""
    probe: float
    step: float
    """Longest step [s]."""

    def start(self, k: int) -> float:
        """Start of a period [s], just as waveforms reckon it."""
        return k / (1.0 / self.period)

    def pieces(self, signal: float) -> list[tuple[float, float]]:
        """Signal and length [s] of what a period consists of."""
        if not self.pulses:
            return [(signal, self.period)]
        share = limit_duty(signal, self.shortest / self.period)
        both = (1.0, share * self.period), (0.0, (1.0 - share) * self.period)
        return [(level, length) for level, length in both if length > 0.0]

    def waveform(self, signals: Sequence[float]) -> AbstractWaveform:
        """What was played, as a waveform."""
        frequency = 1.0 / self.period
        held = Held(values=tuple(signals), frequency=frequency)
        if not self.pulses:
            return held
        return Carrier(duty=held, frequency=frequency, shortest=self.shortest)


def whole_periods(duration: float, period: float) -> int:
    """The number of periods of a run.

    Raises:
        ParameterError: the duration is no whole number of periods.
    """
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
    """Raise `InputError` if system and arguments do not fit each other."""
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
