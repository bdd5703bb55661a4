"""Checks of readings: too large, too old, constant, contradictory, or no current."""

from martensite.base.parameters import Number, param, text
from martensite.base.units import DEGREES, DIFFERENCE
from martensite.control.checks.base import CHECKS, AbstractCheck, CheckResult, Column, Named
from martensite.control.loop.names import AGE
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import MARGIN


class AbstractReadingCheck(AbstractCheck):
    """Interface of a check of one reading."""

    names_reading = ("reading",)

    reading: str = text("name of the reading", typical="temperature")

    def reads(self) -> tuple[str, ...]:
        return (self.reading,)


class AbstractWhileOn(AbstractReadingCheck):
    """Interface of a check of one reading while a signal is on; the last value of the memory is 1 while it is."""

    least: Number = param(DRIVE, "signal that counts as zero", low=0.0, default=0.0, typical=0.05)

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        return (*memory[:-1], self.on(xp, allowed, self.least))


class AbstractAbove(AbstractReadingCheck):
    """Interface of a check of one reading; a subclass declares `limit` and `band` in its unit."""

    limit: Scalar
    band: Scalar
    """Distance below the limit at which the check clears."""

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        size = xp.abs(readings[self.reading])
        return CheckResult(xp.negate(size <= self.limit), size < self.limit - self.band, ())


@CHECKS.register("overheat")
class Overheat(AbstractAbove):
    """Cut signals if a measured temperature is above its limit or NaN."""

    alarm = 1

    limit: Number = param("K", "highest temperature", above=0.0, typical="80 degC")
    band: Number = param(DEGREES, "distance of clearing below the limit", low=0.0, default=0.0, typical="5 K")


@CHECKS.register("over-current")
class OverCurrent(AbstractAbove):
    """Cut signals if a measured current of either direction is above its limit."""

    alarm = 2

    limit: Number = param("A", "largest current", above=0.0, typical="1 A")
    band: Number = param("A", "distance of clearing below the limit", low=0.0, default=0.0, typical="0.2 A")


@CHECKS.register("over-stress")
class OverStress(AbstractAbove):
    """Cut signals if a measured stress is above its limit."""

    alarm = 3

    limit: Number = param("Pa", "largest stress", above=0.0, typical="100 MPa")
    band: Number = param("Pa", "distance of clearing below the limit", low=0.0, default=0.0, typical="10 MPa")


@CHECKS.register("over-force")
class OverForce(AbstractAbove):
    """Cut signals if a measured force is above its limit."""

    alarm = 3

    limit: Number = param("N", "largest force", above=0.0, typical="10 N")
    band: Number = param("N", "distance of clearing below the limit", low=0.0, default=0.0, typical="1 N")


@CHECKS.register("mismatch")
class Mismatch(AbstractCheck):
    """Cut signals if two readings contradict each other.

    Compare two sensors, or a sensor with the estimate of an observer (`estimated.NAME`). Only this check finds a
    reading that drifts.
    """

    alarm, size = 7, 1
    names_reading = ("reading",)

    reading: str = text("name of a reading", typical="temperature")
    other: str = text("name of the other reading, or of an estimate", typical="=reading")
    limit: Number = param(DIFFERENCE, "largest difference", above=0.0, typical=MARGIN)
    longest: Number = param("s", "time for which they may differ more", low=0.0, default=0.0, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        return self.reading, self.other

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the time of the mismatch, 0 s."""
        return (0.0,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        fine = xp.abs(readings[self.reading] - readings[self.other]) <= self.limit
        time = xp.where(fine, 0.0, memory[0] + dt)
        trips = time > self.longest
        return CheckResult(trips, xp.negate(trips), (time,))


@CHECKS.register("sensor-lost")
class SensorLost(AbstractReadingCheck):
    """Cut signals if a sensor sends no new readings.

    The limit must be longer than the sample time and the delay of the sensor together.
    """

    alarm = 4

    timeout: Number = param("s", "age beyond which the sensor is lost", above=0.0, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        return (self.reading + AGE,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        fine = readings[self.reading + AGE] <= self.timeout
        return CheckResult(xp.negate(fine), fine, ())


@CHECKS.register("sensor-stuck")
class SensorStuck(AbstractWhileOn):
    """Cut signals if the reading of a sensor does not change.

    Noise moves a real reading. Without a band, a reading is stuck if it is equal bit by bit. That is right for a sensor
    with noise. A sensor that rounds to steps larger than its noise repeats itself in a steady state and needs a longer
    time. Time counts only while a signal is on, and pauses in between.
    """

    alarm, size = 5, 3

    longest: Number = param("s", "time under a signal until it is stuck", above=0.0, typical="0.3 s")
    band: Number = param(DIFFERENCE, "change that counts as zero", low=0.0, default=0.0, typical=0.1)

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the reading, the time for which it has been constant [s], and the state of the signal."""
        return readings[self.reading], 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        same, time, on = memory
        now = readings[self.reading]
        moved = xp.abs(now - same) > self.band
        same, time = xp.where(moved, now, same), xp.where(moved, 0.0, time + on * dt)
        trips = time > self.longest
        return CheckResult(trips, xp.negate(trips), (same, time, on))


@CHECKS.register("open-circuit")
class NoCurrent(AbstractWhileOn):
    """Cut signals if no current flows in a circuit.

    The reading of the current is late by one period and the delay of its sensor; the time until the alarm must be
    longer. Without a signal the circuit cannot be tested: a guard with the answer `resume` tries again after `hold`.
    """

    alarm, size = 6, 2

    reading: str = text("name of the reading of the current", typical="current")
    most: Number = param("A", "current that counts as zero", low=0.0, default=0.0, typical="0.02 A")
    longest: Number = param("s", "time under a signal until it is open", low=0.0, typical="0.3 s")

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the time without a current [s], and the state of the signal."""
        return 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        time, on = memory
        none = xp.both(on > 0.5, xp.abs(readings[self.reading]) <= self.most)
        time = xp.where(none, time + dt, 0.0)
        trips = time > self.longest
        return CheckResult(trips, xp.negate(trips), (time, on))
