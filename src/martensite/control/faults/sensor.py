"""Faults of one sensor: it drifts, sends nothing new, repeats itself, is disturbed, or comes late."""

from typing import Self

from martensite.base.parameters import Number, param, text
from martensite.base.units import DIFFERENCE, RATE
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.signals.levels import MARGIN


class AbstractSensorFault(AbstractFault):
    """Interface of a fault of one sensor."""

    names_reading = ("sensor",)

    sensor: str = text("name of the sensor", typical="temperature")

    def names(self) -> dict[str, str]:
        """Return the sensor."""
        return {self.sensor: "sensor"}


@FAULTS.register("drift")
class Drift(AbstractSensorFault):
    """A sensor with an offset that grows.

        reading = true reading + b + r (t - t_0)

    with the `bias` b from the beginning t_0 of the fault on, and the `rate` r. The wrong readings are as fresh and as
    noisy as ever: only another source of the same knowledge reveals them.
    """

    bias: Number = param(DIFFERENCE, "offset when it begins", default=0.0, typical=0.5)
    rate: Number = param(RATE, "growth of it", default=0.0, typical=0.2)

    def fault_at(self, xp: Namespace, time: Scalar) -> Self:
        """With the offset that it has by now."""
        since = xp.maximum(time - self.start, 0.0)
        return self.rebuilt({"bias": self.bias + self.rate * since})

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, held: Scalar, active: Flag) -> Scalar:
        """Return the reading, and the offset."""
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
        """Return the last reading."""
        return xp.where(active, held, reading) if sensor == self.sensor else reading


@FAULTS.register("noise-burst")
class NoiseBurst(AbstractSensorFault):
    """A sensor that is disturbed, as by a motor beside its cable.

    The deviation times the standard normal number of the sensor noise is added to the readings, behind the rounding of
    the instrument. A run without noise has no such numbers, and no burst.
    """

    deviation: Number = param(DIFFERENCE, "standard deviation that is added", low=0.0, typical=MARGIN)

    def disturb(self, xp: Namespace, sensor: str, reading: Scalar, number: Scalar, active: Flag) -> Scalar:
        """Return the reading, and what disturbs it."""
        more = xp.where(active, self.deviation * number, 0.0)
        return reading + more if sensor == self.sensor else reading


@FAULTS.register("late-readings")
class LateReadings(AbstractSensorFault):
    """A sensor whose readings arrive later, as over a bus that is busy; their age tells."""

    by: Number = param("s", "how much later", low=0.0, high=1e3, typical="0.2 s")

    def travel(self, xp: Namespace, sensor: str, travel: Scalar, active: Flag) -> Scalar:
        """Return its time, and what it is late by [s]."""
        return travel + xp.where(active, self.by, 0.0) if sensor == self.sensor else travel

    def latest(self, sensor: str) -> float:
        """Return the additional delay [s]."""
        return self.by if sensor == self.sensor else 0.0
