"""Sample-and-hold signal of a controller or a converter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.signals.base import MANY, AbstractWaveform, read_levels
from martensite.signals.edges import find_interval, select_inside
from martensite.signals.moments import Segment


class Held(AbstractWaveform):
    """Values held for k/f ≤ t < (k + 1)/f each; the last value stays."""

    values: tuple[float, ...] = part("one value per period, in the unit of the source")
    frequency: Number = param("Hz", "values per second", above=0.0, high=1e9, typical="2 Hz")

    @override
    def value(self, time: float) -> float:
        return self.values[self._period(time)]

    @override
    def signals(self, times: Sequence[float]) -> list[float]:
        if len(times) < MANY:
            return super().signals(times)
        import numpy as np

        starts = np.arange(len(self.values)) / self.frequency
        return read_levels(np.column_stack([starts, self.values]), times)

    @override
    def edges(self, duration: float) -> list[float]:
        return select_inside((self._start(k) for k in range(1, len(self.values))), duration)

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        for k in range(self._period(begin), len(self.values)):
            yield Segment(self._start(k), self.values[k])

    def _period(self, time: float) -> int:
        k = find_interval(time, time * self.frequency, self._start)
        return min(max(k, 0), len(self.values) - 1)

    def _start(self, k: int) -> float:
        return k / self.frequency
