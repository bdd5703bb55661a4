"""Faults of one sensor: drift, missing or repeated readings, noise, and delay."""

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
        return {self.sensor: "sensor"}


@FAULTS.register("drift")
class Drift(AbstractSensorFault):
    """A sensor with an offset that grows.

        reading = true reading + b + r (t - t_0)

    `bias` b is the offset at the start t_0 of the fault, `rate` r its growth. Age and noise of the readings are normal:
    only a second source of the same quantity reveals the fault.
    """

    bias: Number = param(DIFFERENCE, "offset when it begins", default=0.0, typical=0.5)
    rate: Number = param(RATE, "rate of the offset", default=0.0, typical=0.2)

    def fault_at(self, xp: Namespace, time: Scalar) -> Self:
        since = xp.maximum(time - self.start, 0.0)
        return self.rebuilt({"bias": self.bias + self.rate * since})

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, last_reading: Scalar, active: Flag) -> Scalar:
        off = xp.where(active, self.bias, 0.0)
        return reading + off if sensor == self.sensor else reading


@FAULTS.register("drop-out")
class DropOut(AbstractSensorFault):
    """A sensor that sends no readings; their age `NAME.age` grows."""

    def fresh(self, xp: Namespace, sensor: str, fresh: Flag, active: Flag) -> Flag:
        return xp.both(fresh, xp.negate(active)) if sensor == self.sensor else fresh


@FAULTS.register("stuck")
class Stuck(AbstractSensorFault):
    """A sensor that repeats its last reading as a new one."""

    def reading(self, xp: Namespace, sensor: str, reading: Scalar, last_reading: Scalar, active: Flag) -> Scalar:
        return xp.where(active, last_reading, reading) if sensor == self.sensor else reading


@FAULTS.register("noise-burst")
class NoiseBurst(AbstractSensorFault):
    """A sensor with additional noise, as from a motor near its cable.

    The deviation times the standard normal number of the sensor noise is added to the rounded readings. A run without
    noise has no burst.
    """

    deviation: Number = param(DIFFERENCE, "standard deviation that is added", low=0.0, typical=MARGIN)

    def disturb(self, xp: Namespace, sensor: str, reading: Scalar, number: Scalar, active: Flag) -> Scalar:
        more = xp.where(active, self.deviation * number, 0.0)
        return reading + more if sensor == self.sensor else reading


@FAULTS.register("late-readings")
class LateReadings(AbstractSensorFault):
    """A sensor whose readings arrive late, as over a busy bus; their age shows it."""

    by: Number = param("s", "how much later", low=0.0, high=1e3, typical="0.2 s")

    def travel(self, xp: Namespace, sensor: str, travel: Scalar, active: Flag) -> Scalar:
        return travel + xp.where(active, self.by, 0.0) if sensor == self.sensor else travel

    def latest(self, sensor: str) -> float:
        return self.by if sensor == self.sensor else 0.0
