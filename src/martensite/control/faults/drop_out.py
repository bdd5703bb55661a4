"""A drop-out: a sensor sends nothing new, and what it said last gets older and older."""

from __future__ import annotations

from martensite.base.parameters import text
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.kernels.namespace import Flag, Namespace


@FAULTS.register("drop-out")
class DropOut(AbstractFault):
    """A sensor whose readings do not come; their age `NAME.age` tells."""

    sensor: str = text("name of the sensor", typical="temperature")

    def names(self) -> dict[str, str]:
        """The sensor."""
        return {self.sensor: "sensor"}

    def fresh(self, xp: Namespace, sensor: str, fresh: Flag, active: Flag) -> Flag:
        """Nothing new."""
        return xp.both(fresh, xp.negate(active)) if sensor == self.sensor else fresh
