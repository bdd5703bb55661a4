"""Voltage source: I = u/(R + R_s), within the current and the voltage of the supply."""

from __future__ import annotations

from typing import ClassVar

from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSupply, SignalRange


@SOURCES.register("voltage")
class VoltageSource(AbstractSupply):
    """A voltage; leads, driver and supply resistance count as `series_resistance`."""

    unit: ClassVar[str] = "V"

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in volt."""
        most = self.most(xp, resistance)
        return xp.clip(drive / (resistance + self.series_resistance), -most, most)

    def reach(self, resistance: float) -> SignalRange:
        """Voltages [V] over element and series resistance that limits of the supply allow."""
        most = self.most(floats, resistance) * (resistance + self.series_resistance)
        return SignalRange(-most, most)
