"""Checks of readings: too large, too old, always the same, contradicting; a current that does not flow."""

from martensite.base.parameters import Number, param, text
from martensite.base.units import DEGREES, DIFFERENCE
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.control.loop.names import AGE
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import MARGIN


class AbstractReadingCheck(AbstractCheck):
    """Interface of a check of one reading."""

    names_reading = ("reading",)

    reading: str = text("name of the reading", typical="temperature")

    def reads(self) -> tuple[str, ...]:
        """Return the reading."""
        return (self.reading,)


class AbstractWhileOn(AbstractReadingCheck):
    """Interface of a check of one reading while a signal is on, which is the last number that it remembers."""

    least: Number = param(DRIVE, "signal that counts as none", low=0.0, default=0.0, typical=0.05)

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """With whether a signal is on in the next period."""
        return (*memory[:-1], self.on(xp, allowed, self.least))


class AbstractAbove(AbstractReadingCheck):
    """Interface of a check of one reading; a subclass declares `limit` and `band` in its unit."""

    limit: Scalar
    """Most that is allowed; without it the check is refused, for it could not trip."""
    band: Scalar
    """Distance below the limit at which the check clears."""

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the size of the reading is above the limit."""
        size = xp.abs(readings[self.reading])
        return Looked(xp.negate(size <= self.limit), size < self.limit - self.band, ())


@CHECKS.register("overheat")
class Overheat(AbstractAbove):
    """A measured temperature above its limit.

    NaN is above every limit.
    """

    alarm = 1

    limit: Number = param("K", "highest temperature", above=0.0, typical="80 degC")
    band: Number = param(DEGREES, "how far below it is well again", low=0.0, default=0.0, typical="5 K")


@CHECKS.register("over-current")
class OverCurrent(AbstractAbove):
    """A measured current, of either direction, above its limit."""

    alarm = 2

    limit: Number = param("A", "largest current", above=0.0, typical="1 A")
    band: Number = param("A", "how far below it is well again", low=0.0, default=0.0, typical="0.2 A")


@CHECKS.register("over-stress")
class OverStress(AbstractAbove):
    """A measured stress above its limit."""

    alarm = 3

    limit: Number = param("Pa", "largest stress", above=0.0, typical="100 MPa")
    band: Number = param("Pa", "how far below it is well again", low=0.0, default=0.0, typical="10 MPa")


@CHECKS.register("over-force")
class OverForce(AbstractAbove):
    """A measured force above its limit."""

    alarm = 3

    limit: Number = param("N", "largest force", above=0.0, typical="10 N")
    band: Number = param("N", "how far below it is well again", low=0.0, default=0.0, typical="1 N")


@CHECKS.register("mismatch")
class Mismatch(AbstractCheck):
    """Two readings that contradict each other.

    Two sensors, or a sensor and the estimate of an observer (`estimated.NAME`). This is what finds a reading that
    drifts, which looks as sound as any.
    """

    alarm, size = 7, 1
    names_reading = ("reading",)

    reading: str = text("name of a reading", typical="temperature")
    other: str = text("name of the other reading, or of an estimate", typical="=reading")
    limit: Number = param(DIFFERENCE, "largest difference", above=0.0, typical=MARGIN)
    longest: Number = param("s", "time for which they may differ more", low=0.0, default=0.0, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        """Both."""
        return self.reading, self.other

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """For how long they have differed."""
        return (0.0,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the readings have differed for too long."""
        fine = xp.abs(readings[self.reading] - readings[self.other]) <= self.limit
        time = xp.where(fine, 0.0, memory[0] + dt)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (time,))


@CHECKS.register("sensor-lost")
class SensorLost(AbstractReadingCheck):
    """A sensor of which nothing new is heard.

    The age of a reading is what has gone by since it was made. The limit must be longer than the sample time of the
    sensor and its delay together.
    """

    alarm = 4

    timeout: Number = param("s", "age beyond which it is lost", above=0.0, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        """Return the age of the reading."""
        return (self.reading + AGE,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the reading is too old."""
        fine = readings[self.reading + AGE] <= self.timeout
        return Looked(xp.negate(fine), fine, ())


@CHECKS.register("sensor-stuck")
class SensorStuck(AbstractWhileOn):
    """A sensor whose reading does not change.

    A real reading moves: by noise, if by nothing else. Without a band a reading is stuck when it is the same bit for
    bit; that is right for a sensor with noise and wrong for one that is rounded to steps larger than its noise, which
    at rest repeats itself and needs a longer time. Time counts only while a signal is on, and goes on from where it was
    when there was a pause.
    """

    alarm, size = 5, 3

    longest: Number = param("s", "time under a signal until it is stuck", above=0.0, typical="0.3 s")
    band: Number = param(DIFFERENCE, "change that is none", low=0.0, default=0.0, typical=0.1)

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the reading, for how long it has been so, and whether a signal is on."""
        return readings[self.reading], 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the reading has been constant for too long."""
        same, time, on = memory
        now = readings[self.reading]
        moved = xp.abs(now - same) > self.band
        same, time = xp.where(moved, now, same), xp.where(moved, 0.0, time + on * dt)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (same, time, on))


@CHECKS.register("open-circuit")
class NoCurrent(AbstractWhileOn):
    """A circuit through which nothing flows.

    The current is measured under the signal of the period before, and late by the delay of its sensor, which the time
    until the alarm must exceed. Under no signal nothing can be known: a guard that resumes tries again, after its
    `hold`.
    """

    alarm, size = 6, 2

    reading: str = text("name of the reading of the current", typical="current")
    most: Number = param("A", "current that counts as none", low=0.0, default=0.0, typical="0.02 A")
    longest: Number = param("s", "time under a signal until it is open", low=0.0, typical="0.3 s")

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """For how long there has been no current, and whether a signal is on."""
        return 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether there has been no current for too long."""
        time, on = memory
        none = xp.both(on > 0.5, xp.abs(readings[self.reading]) <= self.most)
        time = xp.where(none, time + dt, 0.0)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (time, on))
