"""Voltage source with series resistance and current limit: I = u/(R + R_s), |I| ≤ I_max."""

from __future__ import annotations

from typing import ClassVar

from martensite.electrical.base import SOURCES, AbstractSource
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar


@SOURCES.register("voltage")
class VoltageSource(AbstractSource):
    """A supply voltage; leads, driver and supply resistance count as `series_resistance`."""

    unit: ClassVar[str] = "V"

    series_resistance: Scalar = param(
        "ohm", "resistance outside the element", low=0.0, high=1e6, default=0.0
    )
    current_limit: Scalar = param("A", "current limit", above=0.0, high=1e6, default=1e6)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in volt."""
        wanted = drive / (resistance + self.series_resistance)
        return xp.clip(wanted, -self.current_limit, self.current_limit)
