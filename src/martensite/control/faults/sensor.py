"""Faults of one sensor: it drifts, sends nothing new, or repeats itself."""

from typing import Self

from martensite.base.parameters import param, text
from martensite.base.units import DIFFERENCE, RATE
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.kernels.namespace import Flag, Namespace, Scalar


class AbstractSensorFault(AbstractFault):
    """Interface of a fault of one sensor."""

    sensor: str = text("name of the sensor", typical="temperature")

    def names(self) -> dict[str, str]:
        """The sensor."""
        return {self.sensor: "sensor"}


@FAULTS.register("drift")
class Drift(AbstractSensorFault):
    """A sensor with an offset that grows.

        reading = true reading + b + r (t - t_0)

    with the `bias` b from the beginning t_0 of the fault on, and the `rate` r. The wrong readings are as fresh and as
    noisy as ever: only another source of the same knowledge reveals them.
    """

    names_reading = ("sensor",)

    bias: Scalar = param(DIFFERENCE, "offset when it begins", default=0.0, typical=0.5)
    rate: Scalar = param(RATE, "growth of it", default=0.0, typical=0.2)

    def fault_at(self, xp: Namespace, time: Scalar) -> Self:
        """With the offset that it has by now."""
        since = xp.maximum(time - self.start, 0.0)
        return self.rebuilt({"bias": self.bias + self.rate * since})

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, held: Scalar, active: Flag) -> Scalar:
        """The reading, and the offset."""
        off = xp.where(active, self.bias, 0.0)
        return reading + off if sensor == self.sensor else reading


@FAULTS.register("drop-out")
class DropOut(AbstractSensorFault):
    """A sensor whose readings do not come; their age `NAME.age` tells."""

    def fresh(self, xp: Namespace, sensor: str, fresh: Flag, active: Flag) -> Flag:
        """Nothing new."""
        return xp.both(fresh, xp.negate(active)) if sensor == self.sensor else fresh


@FAULTS.register("stuck")
class Stuck(AbstractSensorFault):
    """A sensor that repeats its last reading as if it were new."""

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, held: Scalar, active: Flag) -> Scalar:
        """The last reading."""
        return xp.where(active, held, reading) if sensor == self.sensor else reading
