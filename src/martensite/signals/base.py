"""Drives: waveforms and controllers have the same interface.

A drive turns time and measurement into a signal; its memory is passed in and returned. A waveform needs neither, and
lists its edges: the times of jumps and bends, which always end a time step. Levels of a waveform have the unit of the
driven source: volt, ampere, watt, kelvin or none.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, takewhile
from typing import Any, ClassVar

from martensite.base.interfaces import override
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.base.units import DRIVE as DRIVE
from martensite.signals.moments import Moments, Segment, SignalShape, Tone, fit_parabolas

WAVEFORMS: Registry[AbstractWaveform] = Registry("waveform", "martensite.signals", typical="step")
MANY = 100
"""Number of times from which arrays are faster than single values."""


def read_levels(steps: Any, times: Sequence[float]) -> list[float]:
    """Return the levels at some times [s], from rows of start [s] and level, ascending; the first also before it."""
    import numpy as np

    starts, levels = np.asarray(steps, float).T
    return levels[np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)].tolist()


class AbstractDrive(Parametrised):
    """Interface of all drives of a source."""

    @abstractmethod
    def init(self) -> Any:
        """Return the memory before the first call."""

    @abstractmethod
    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return the value at `time` [s]."""


class AbstractWaveform(AbstractDrive):
    """Signal that is known in advance."""

    unit: ClassVar[str | None] = None
    """SI unit of the sources that it can drive; None for any source."""
    stepwise: ClassVar[bool] = False
    """True if its segments are levels that begin exactly where its value changes."""

    @override
    def init(self) -> None:
        pass

    @override
    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        return self.value(time), memory

    @abstractmethod
    def value(self, time: float) -> float:
        """Return the signal at `time` [s], in the unit of the source; right-continuous at jumps."""

    def signals(self, times: Sequence[float]) -> list[float]:
        """Return the signals at many times, with the values of `value`."""
        if not self.stepwise or len(times) < MANY:
            return list(map(self.value, times))
        last = max(times)
        segments = takewhile(lambda segment: segment.start <= last, self.segments(min(times)))
        return read_levels([(one.start, one.level) for one in segments], times)

    def edges(self, duration: float) -> list[float]:
        """Return the times of jumps and bends in (0, duration) [s], ascending."""
        return []

    def count_edges(self, duration: float) -> float:
        """Return the approximate number of edges in `duration` [s] of a periodic waveform; else 0."""
        return 0.0

    def segments(self, begin: float) -> Iterator[Segment]:
        """Yield the segments from the one at `begin` [s] on, without tones; the last segment never ends.

        By default, parabolas are fitted to the values between edges.
        """
        first, last = 0.0, 1.0
        while True:
            cuts = [first, *(edge for edge in self.edges(last) if edge > first), last]
            for one, next_one in pairwise(cuts):
                if next_one > begin:
                    yield from fit_parabolas(self.value, one, next_one)
            first, last = last, 2.0 * last

    def tones(self) -> tuple[Tone, ...]:
        """Return the tones that are added to the segments at all times."""
        return ()

    def shape(self, begin: float, end: float) -> SignalShape:
        """Return the waveform in [begin, end] [s] as segments and tones."""
        segments = takewhile(lambda segment: segment.start < end, self.segments(begin))
        return SignalShape(list(segments) or [next(self.segments(begin))], self.tones())

    def moments(self, begin: float, end: float) -> Moments:
        """Return the exact mean, mean square and range over [begin, end] [s]."""
        return self.shape(begin, end).moments(begin, end)
