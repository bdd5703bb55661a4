"""A stuck sensor: it says the same for too long, though the element is heated.

A real reading moves: by noise, if by nothing else. Without a band a reading is stuck when it is
the same bit for bit; that is right for a sensor with noise and wrong for one that is rounded to
steps larger than its noise, which at rest repeats itself and needs a longer time. Time counts
only while a signal is on, and goes on from where it was when there was a pause.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param, text
from martensite.base.units import DIFFERENCE
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CHECKS.register("sensor-stuck")
class SensorStuck(AbstractCheck):
    """A sensor whose reading does not change."""

    alarm, size = 5, 3
    names_reading = ("reading",)

    reading: str = text("name of the reading", typical="temperature")
    longest: Scalar = param(
        "s", "time under a signal after which it is stuck", above=0.0, default=math.inf, typical="0.3 s"
    )
    band: Scalar = param(DIFFERENCE, "change that is none", low=0.0, default=0.0, typical=0.1)
    least: Scalar = param(DRIVE, "signal that counts as none", low=0.0, default=0.0, typical=0.05)

    def reads(self) -> tuple[str, ...]:
        """The reading."""
        return (self.reading,)

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """The reading, for how long it has been so, and whether a signal is on."""
        return readings[self.reading], 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Whether it has been the same for too long."""
        same, time, on = memory
        now = readings[self.reading]
        moved = xp.abs(now - same) > self.band
        same, time = xp.where(moved, now, same), xp.where(moved, 0.0, time + on * dt)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (same, time, on))

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """With whether a signal is on in the next period."""
        return (*memory[:2], self.on(xp, allowed, self.least))
