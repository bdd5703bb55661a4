"""Current source: I = u, within the current and the voltage of the supply."""

from __future__ import annotations

from typing import ClassVar

from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSupply, SignalRange


@SOURCES.register("current")
class CurrentSource(AbstractSupply):
    """An imposed current."""

    unit: ClassVar[str] = "A"

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in ampere."""
        most = self.most(xp, resistance)
        return xp.clip(drive, -most, most)

    def reach(self, resistance: float) -> SignalRange:
        """Currents [A] that the limits of the supply allow."""
        most = self.most(floats, resistance)
        return SignalRange(-most, most)
