"""Sine between two levels, by default starting at the lower level (a raised cosine).

    u(t) = low + (high − low)/2 · (1 − cos(2π f t + φ))

φ is 0, π/2 or π: the signal starts at `low`, rising through the middle, or at `high`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import blend_levels, require_order
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment, Tone

_TURNS = {"low": 0.0, "middle": 0.25, "high": 0.5}
"""Phase -> lead over the start at `low`, as a fraction of a period."""


@WAVEFORMS.register("sine")
class Sine(AbstractWaveform):
    """Smooth oscillation between `low` and `high`, without edges."""

    low: Number = param(DRIVE, "lowest level", default=0.0)
    high: Number = param(DRIVE, "highest level", typical=HIGH)
    frequency: Number = param("Hz", "frequency", above=0.0, high=1e9, typical="0.1 Hz")
    phase: str = option("where it starts: at `low`, rising through the `middle`, or at `high`", *_TURNS, default="low")

    @override
    def check(self) -> None:
        require_order("sine", self.low, self.high)

    @override
    def value(self, time: float) -> float:
        turns = math.fmod(time * self.frequency, 1.0) + _TURNS[self.phase]
        return blend_levels(self.low, self.high, 0.5 - 0.5 * math.cos(2.0 * math.pi * turns))

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        yield Segment(0.0, 0.5 * (self.low + self.high))

    @override
    def tones(self) -> tuple[Tone, ...]:
        ahead = math.tau * _TURNS[self.phase]
        return (Tone(-0.5 * (self.high - self.low), math.tau * self.frequency, ahead),)
