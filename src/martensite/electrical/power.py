"""Power source: P = u in the element, within a current and a supply voltage limit."""

from __future__ import annotations

from typing import ClassVar

from martensite.electrical.base import SOURCES, AbstractSource
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar


@SOURCES.register("power")
class PowerSource(AbstractSource):
    """An imposed electrical power in the element; negative demands give none."""

    unit: ClassVar[str] = "W"

    series_resistance: Scalar = param(
        "ohm", "resistance outside the element", low=0.0, high=1e6, default=0.0
    )
    current_limit: Scalar = param("A", "current limit", above=0.0, high=1e6, default=1e6)
    voltage_limit: Scalar = param("V", "supply voltage", above=0.0, high=1e9, default=1e9)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in watt."""
        reachable = self.voltage_limit / (resistance + self.series_resistance)
        limit = xp.minimum(reachable, self.current_limit)
        return xp.minimum(xp.sqrt(xp.maximum(drive, 0.0) / resistance), limit)
