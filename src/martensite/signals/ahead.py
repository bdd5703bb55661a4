"""A waveform read ahead of time."""

from collections.abc import Sequence

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.signals.base import AbstractWaveform
from martensite.signals.edges import select_inside

TIME_TOLERANCE = 1e-9
"""Rounding of times [s]: a jump exactly at the requested time counts as past."""


class Ahead(AbstractWaveform):
    """Another waveform, advanced in time: u(t + lead)."""

    waveform: AbstractWaveform = part("the waveform")
    lead: Number = param("s", "how far it looks ahead", low=0.0)

    @override
    def value(self, time: float) -> float:
        return self.waveform.value(time + self.lead + TIME_TOLERANCE)

    @override
    def signals(self, times: Sequence[float]) -> list[float]:
        return self.waveform.signals([time + self.lead + TIME_TOLERANCE for time in times])

    @override
    def edges(self, duration: float) -> list[float]:
        edges = self.waveform.edges(duration + self.lead)
        return select_inside((edge - self.lead for edge in edges if edge > self.lead), duration)
