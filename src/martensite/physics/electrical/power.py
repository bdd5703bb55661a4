"""Power source: P = u in the element, within the current and the voltage of the supply."""

from __future__ import annotations

from typing import ClassVar

from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSupply, SignalRange


@SOURCES.register("power")
class PowerSource(AbstractSupply):
    """An imposed electrical power in the element; negative demands give none."""

    unit: ClassVar[str] = "W"
    linear: ClassVar[str] = "power"

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """I [A] for a drive in watt."""
        wanted = xp.sqrt(xp.maximum(drive, 0.0) / resistance)
        return xp.minimum(wanted, self.most(xp, resistance))

    def reach(self, resistance: float) -> SignalRange:
        """Powers [W] that the limits of the supply allow; none is taken out of the element."""
        most = self.most(floats, resistance)
        return SignalRange(0.0, most * most * resistance)
