"""Constant signal: u(t) = level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment


@WAVEFORMS.register("constant")
class Constant(AbstractWaveform):
    """Constant level."""

    level: Number = param(DRIVE, "level", typical=HIGH)

    @override
    def value(self, time: float) -> float:
        return self.level

    @override
    def signals(self, times: Sequence[float]) -> list[float]:
        return [self.level] * len(times)

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        yield Segment(0.0, self.level)
