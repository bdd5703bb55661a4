"""The drive interface: waveforms and controllers answer the same call.

A drive turns time and measurement into a signal; its memory is passed in and returned. A
waveform needs neither measurement nor memory, and names its edges: the times at which it
jumps or bends. The march snaps its steps to them, so nothing is stepped over.

The levels of a waveform are declared in the unit `drive`: volt, ampere, watt, kelvin or a
plain number, whatever the source takes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, takewhile
from typing import Any, ClassVar

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.base.units import DRIVE as DRIVE
from martensite.signals.moments import Moments, Segment, SignalShape, Tone, fit_parabolas

WAVEFORMS: Registry[AbstractWaveform] = Registry("waveform", "martensite.signals", typical="step")
MANY = 1000
"""Times from which on arrays are quicker than numbers one by one, even if NumPy is loaded first."""


class AbstractDrive(Parametrised):
    """Interface of everything that drives a source."""

    @abstractmethod
    def init(self) -> Any:
        """Return the memory before the first call."""

    @abstractmethod
    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return the signal at `time` [s] and the new memory."""


class AbstractWaveform(AbstractDrive):
    """A signal that is known beforehand."""

    unit: ClassVar[str | None] = None
    """Unit of the only sources that it can drive; None if it drives any."""

    def init(self) -> None:
        """A waveform remembers nothing."""

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return the value at `time` [s], independent of measurements."""
        return self.value(time), memory

    @abstractmethod
    def value(self, time: float) -> float:
        """Return the signal at `time` [s], in the unit of the source; right-continuous at jumps."""

    def signals(self, times: Sequence[float]) -> list[float]:
        """Return the signals at many times, the same numbers as one by one."""
        return list(map(self.value, times))

    def edges(self, duration: float) -> list[float]:
        """Return the times in (0, duration) at which the signal jumps or bends, ascending [s]."""
        return []

    def count_edges(self, duration: float) -> float:
        """About how many edges a run of `duration` [s] holds, where they come without end; else 0."""
        return 0.0

    def segments(self, begin: float) -> Iterator[Segment]:
        """Yield the segments without the tones, ascending, from the segment at `begin` [s] on.

        The last segment never ends. By default parabolas are fitted to the values between edges, as many as necessary.
        """
        first, last = 0.0, 1.0
        while True:
            cuts = [first, *(edge for edge in self.edges(last) if edge > first), last]
            for one, next_one in pairwise(cuts):
                if next_one > begin:
                    yield from fit_parabolas(self.value, one, next_one)
            first, last = last, 2.0 * last

    def tones(self) -> tuple[Tone, ...]:
        """Return the tones that are added at all times to the segments."""
        return ()

    def shape(self, begin: float, end: float) -> SignalShape:
        """Return the waveform as segments and tones in [begin, end] [s]."""
        known = takewhile(lambda segment: segment.start < end, self.segments(begin))
        return SignalShape(list(known) or [next(self.segments(begin))], self.tones())

    def moments(self, begin: float, end: float) -> Moments:
        """Return the mean, mean square and range over [begin, end] [s], exactly."""
        return self.shape(begin, end).moments(begin, end)
