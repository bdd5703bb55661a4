"""Triangle: from low at t = 0 linearly to high after half a period, and back."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import blend_levels, find_interval, require_countable, require_order, select_inside
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment


@WAVEFORMS.register("triangle")
class Triangle(AbstractWaveform):
    """Linear oscillation between `low` and `high`, starting at `low`."""

    low: Number = param(DRIVE, "lowest level", default=0.0)
    high: Number = param(DRIVE, "highest level", typical=HIGH)
    frequency: Number = param("Hz", "frequency", above=0.0, high=1e9, typical="0.1 Hz")

    @override
    def check(self) -> None:
        require_order("triangle", self.low, self.high)

    @override
    def value(self, time: float) -> float:
        k = find_interval(time, 2.0 * time * self.frequency, self._bend)
        begin, end = self._bend(k), self._bend(k + 1)
        share = (time - begin) / (end - begin)
        if k % 2:
            return blend_levels(self.high, self.low, share)
        return blend_levels(self.low, self.high, share)

    def edges(self, duration: float) -> list[float]:
        """Return all bends in (0, duration) [s]: k/(2 f)."""
        count = self.count_edges(duration)
        require_countable("triangle", count, duration)
        return select_inside((self._bend(k) for k in range(1, int(count) + 2)), duration)

    @override
    def count_edges(self, duration: float) -> float:
        return 2.0 * self.frequency * duration

    def segments(self, begin: float) -> Iterator[Segment]:
        """Yield rising and falling lines alternately."""
        rise = 2.0 * self.frequency * (self.high - self.low)
        for k in count(max(find_interval(begin, 2.0 * begin * self.frequency, self._bend), 0)):
            level, slope = (self.high, -rise) if k % 2 else (self.low, rise)
            yield Segment(self._bend(k), level, slope)

    def _bend(self, k: int) -> float:
        return 0.5 * k / self.frequency
