"""A stuck sensor: it goes on sending, and always the same."""

from __future__ import annotations

from martensite.base.parameters import text
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.kernels.namespace import Flag, Namespace, Scalar


@FAULTS.register("stuck")
class Stuck(AbstractFault):
    """A sensor that repeats its last reading as if it were new."""

    sensor: str = text("name of the sensor", typical="temperature")

    def names(self) -> dict[str, str]:
        """The sensor."""
        return {self.sensor: "sensor"}

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, held: Scalar, active: Flag) -> Scalar:
        """The last reading."""
        return xp.where(active, held, reading) if sensor == self.sensor else reading
