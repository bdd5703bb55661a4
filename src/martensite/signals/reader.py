"""Forward reader of a waveform that creates segments on demand and drops old ones."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator

from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Moments, Segment, SignalShape

AHEAD = 512
"""Number of segments created at once."""


class Reader:
    """Reader of a waveform in a moving window of time."""

    def __init__(self, waveform: AbstractWaveform) -> None:
        self._coming: Iterator[Segment] = waveform.segments(0.0)
        self._segments: list[Segment] = []
        self._starts: list[float] = []
        self._ended = False
        self.tones = waveform.tones()
        self.fastest = max((tone.rate for tone in self.tones), default=0.0)
        """Highest ω of the tones [rad/s]."""

    def moments(self, begin: float, end: float) -> Moments:
        """Return the moments over [begin, end] [s]."""
        self._need(end)
        first = self._place(begin)
        if not self.tones:
            segment = self._segments[first]
            alone = first + 1 == len(self._starts) or self._starts[first + 1] >= end
            if alone and segment.slope == 0.0 == segment.bend:
                return Moments.constant(segment.level)
        return SignalShape(self._segments[first : self._place(end) + 1], self.tones).moments(begin, end)

    def value(self, time: float) -> float:
        """Return the signal at `time` [s]; right-continuous."""
        self._need(time)
        return SignalShape([self._segments[self._place(time)]], self.tones).value(time)

    def before(self, time: float) -> float:
        """Return the signal just before `time` [s]."""
        return self.level(time, before=True) + math.fsum(tone.value(time) for tone in self.tones)

    def level(self, time: float, before: bool = False) -> float:
        """Return the signal without tones at `time` [s], or just before."""
        self._need(time)
        place = self._place(time)
        if before and place > 0 and not self._starts[place] < time:
            place -= 1
        return self._segments[place].value(time)

    def edges(self, begin: float, end: float) -> list[float]:
        """Return the times of jumps and bends in (begin, end) [s]."""
        self._need(end)
        first = bisect_right(self._starts, begin)
        last = self._place(end) + 1
        return [start for start in self._starts[first:last] if start < end]

    def forget(self, time: float) -> None:
        """Drop the part before `time` [s], which must not be read again."""
        place = self._place(time) - 1
        if place > AHEAD:
            del self._segments[:place], self._starts[:place]

    def _place(self, time: float) -> int:
        return max(0, bisect_right(self._starts, time) - 1)

    def _need(self, time: float) -> None:
        """Create segments until one starts after `time` [s]."""
        while not self._ended and (not self._starts or self._starts[-1] <= time):
            for _ in range(AHEAD):
                segment = next(self._coming, None)
                if segment is None:
                    self._ended = True
                    break
                self._segments.append(segment)
                self._starts.append(segment.start)
