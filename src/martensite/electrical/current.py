"""Current source with a supply voltage limit: I = u while |u| (R + R_s) ≤ U_max."""

from __future__ import annotations

from typing import ClassVar

from martensite.electrical.base import SOURCES, AbstractSource
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar


@SOURCES.register("current")
class CurrentSource(AbstractSource):
    """An imposed current, limited in current and by the supply voltage."""

    unit: ClassVar[str] = "A"

    series_resistance: Scalar = param(
        "ohm", "resistance outside the element", low=0.0, high=1e6, default=0.0
    )
    current_limit: Scalar = param("A", "current limit", above=0.0, high=1e6, default=1e6)
    voltage_limit: Scalar = param("V", "supply voltage", above=0.0, high=1e9, default=1e9)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in ampere."""
        reachable = self.voltage_limit / (resistance + self.series_resistance)
        limit = xp.minimum(reachable, self.current_limit)
        return xp.clip(drive, -limit, limit)
