"""Pulse-width modulation: u = high for k/f ≤ t < (k + duty)/f, k = 0, 1, …, else low."""

from __future__ import annotations

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, WAVEFORMS
from martensite.signals.edges import require_order
from martensite.signals.levels import HIGH
from martensite.signals.pulses import AbstractPulses


@WAVEFORMS.register("pwm")
class PulseWidthModulation(AbstractPulses):
    """Rectangular signal of constant frequency and duty cycle."""

    low: Number = param(DRIVE, "level when off", default=0.0)
    high: Number = param(DRIVE, "level when on", typical=HIGH)
    frequency: Number = param("Hz", "frequency", above=0.0, high=1e9, typical="10 Hz")
    duty: Number = param("1", "share of the period that is on", low=0.0, high=1.0, typical=0.3)

    @override
    def check(self) -> None:
        require_order("pwm", self.low, self.high)

    @override
    def share(self, k: int) -> float:
        return self.duty

    @override
    def levels(self) -> tuple[float, float]:
        return self.high, self.low

    @override
    def value(self, time: float) -> float:
        return self.high if self.is_on(time) else self.low

    def edges(self, duration: float) -> list[float]:
        """Return all jumps in (0, duration) [s]: k/f and (k + duty)/f."""
        return [] if self.duty in (0.0, 1.0) else super().edges(duration)

    @override
    def count_edges(self, duration: float) -> float:
        return 0.0 if self.duty in (0.0, 1.0) else super().count_edges(duration)
