"""Base of pulsed waveforms: one pulse from the start of each period.

On for k/f ≤ t < (k + D_k)/f, k = 0, 1, …, with frequency f and duty cycle D_k of period k.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from itertools import count

from martensite.base.interfaces import override
from martensite.base.parameters import Number
from martensite.signals.base import AbstractWaveform
from martensite.signals.edges import find_interval, require_countable, select_inside
from martensite.signals.moments import Segment


class AbstractPulses(AbstractWaveform):
    """Pulses; a subclass declares the frequency [Hz] and gives the duty cycle."""

    frequency: Number
    stepwise = True

    @abstractmethod
    def share(self, k: int) -> float:
        """Return the duty cycle of period k."""

    def levels(self) -> tuple[float, float]:
        """Return the levels of pulse and gap."""
        return 1.0, 0.0

    def is_on(self, time: float) -> bool:
        """Return whether a pulse is on at `time` [s]; right-continuous."""
        return time < self._end(find_interval(time, time * self.frequency, self._start))

    @override
    def edges(self, duration: float) -> list[float]:
        count = self.count_edges(duration)
        require_countable(self.registered_name, count, duration)
        periods = range(int(0.5 * count) + 2)
        return select_inside((t for k in periods for t in (self._start(k), self._end(k))), duration)

    @override
    def count_edges(self, duration: float) -> float:
        return 2.0 * self.frequency * duration

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        on, off = self.levels()
        for k in count(max(find_interval(begin, begin * self.frequency, self._start), 0)):
            start, end, after = self._start(k), self._end(k), self._start(k + 1)
            if end > start:
                yield Segment(start, on)
            if end < after:
                yield Segment(max(start, end), off)

    def _start(self, k: int) -> float:
        return k / self.frequency

    def _end(self, k: int) -> float:
        return (k + self.share(k)) / self.frequency
