"""Constant signal: u(t) = level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment


@WAVEFORMS.register("constant")
class Constant(AbstractWaveform):
    """Constant level."""

    level: Number = param(DRIVE, "level", typical=HIGH)

    def value(self, time: float) -> float:
        """Return the level."""
        return self.level

    def signals(self, times: Sequence[float]) -> list[float]:
        """Return the level, once per time."""
        return [self.level] * len(times)

    def segments(self, begin: float) -> Iterator[Segment]:
        """Yield one segment."""
        yield Segment(0.0, self.level)
