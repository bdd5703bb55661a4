"""A waveform as it will be: for who looks ahead."""

from martensite.base.parameters import Number, param, part
from martensite.signals.base import AbstractWaveform
from martensite.signals.edges import select_inside

TIME_TOLERANCE = 1e-9
"""Difference of times that is rounding [s]: a jump at the very time that is looked at has come."""


class Ahead(AbstractWaveform):
    """Another waveform, a time earlier: u(t + lead)."""

    waveform: AbstractWaveform = part("the waveform")
    lead: Number = param("s", "how far it looks ahead", low=0.0)

    def value(self, time: float) -> float:
        """Return the value of the waveform at `time` + lead [s]."""
        return self.waveform.value(time + self.lead + TIME_TOLERANCE)

    def edges(self, duration: float) -> list[float]:
        """Return the edges of the waveform, shifted to earlier times [s]."""
        found = self.waveform.edges(duration + self.lead)
        return select_inside((edge - self.lead for edge in found if edge > self.lead), duration)
