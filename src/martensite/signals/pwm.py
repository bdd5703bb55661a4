"""Pulse-width modulation: u = high for k/f ≤ t < (k + duty)/f, k = 0, 1, …, else low."""

from __future__ import annotations

from martensite.parameters import param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import inside, interval, require_countable, require_order


@WAVEFORMS.register("pwm")
class PulseWidthModulation(AbstractWaveform):
    """A rectangular signal of constant frequency and duty."""

    low: float = param(DRIVE, "level when off", default=0.0)
    high: float = param(DRIVE, "level when on")
    frequency: float = param("Hz", "frequency", above=0.0, high=1e9)
    duty: float = param("1", "share of the period that is on", low=0.0, high=1.0)

    def check(self) -> None:
        """The levels are in order."""
        require_order("pwm", self.low, self.high)

    def value(self, time: float) -> float:
        """Level at `time` [s]; the new one at a jump itself."""
        k = interval(time, time * self.frequency, self._on)
        return self.high if time < self._off(k) else self.low

    def edges(self, duration: float) -> list[float]:
        """All jumps in (0, duration) [s]: k/f and (k + duty)/f."""
        if self.duty in (0.0, 1.0):
            return []
        count = 2.0 * self.frequency * duration
        require_countable("pwm", count, duration)
        periods = range(int(0.5 * count) + 2)
        return inside((t for k in periods for t in (self._on(k), self._off(k))), duration)

    def _on(self, k: int) -> float:
        return k / self.frequency

    def _off(self, k: int) -> float:
        return (k + self.duty) / self.frequency
