"""Constant signal: u(t) = level."""

from __future__ import annotations

from martensite.parameters import param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform


@WAVEFORMS.register("constant")
class Constant(AbstractWaveform):
    """The same level all the time."""

    level: float = param(DRIVE, "level")

    def value(self, time: float) -> float:
        """The level, at any time."""
        return self.level
