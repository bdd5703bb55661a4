"""Held: one value per period, as a controller or a converter puts out."""

from __future__ import annotations

from martensite.parameters import param, part
from martensite.signals.base import AbstractWaveform
from martensite.signals.edges import inside, interval


class Held(AbstractWaveform):
    """Values held for k/f ≤ t < (k + 1)/f each; the last one stays. What a loop has put out."""

    values: tuple[float, ...] = part("one value per period, in the unit of the source")
    frequency: float = param("Hz", "values per second", above=0.0, high=1e9)

    def value(self, time: float) -> float:
        """The value of the period at `time` [s]; the new one at its start."""
        k = interval(time, time * self.frequency, self._start)
        return self.values[min(max(k, 0), len(self.values) - 1)]

    def edges(self, duration: float) -> list[float]:
        """Starts of the periods in (0, duration) [s]."""
        return inside((self._start(k) for k in range(1, len(self.values))), duration)

    def _start(self, k: int) -> float:
        return k / self.frequency
