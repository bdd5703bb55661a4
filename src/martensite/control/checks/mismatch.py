"""A mismatch: two readings of the same thing differ for too long.

Two sensors, or a sensor and the estimate of an observer (`estimated.NAME`). This is what finds a
reading that drifts, which looks as sound as any.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param, text
from martensite.base.units import DIFFERENCE
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.kernels.namespace import Namespace, Scalar


@CHECKS.register("mismatch")
class Mismatch(AbstractCheck):
    """Two readings that contradict each other."""

    alarm, size = 7, 1
    names_reading = ("reading",)

    reading: str = text("name of a reading", typical="temperature")
    other: str = text("name of the other reading, or of an estimate", typical="=reading")
    limit: Scalar = param(DIFFERENCE, "largest difference", above=0.0, default=math.inf, typical=0.1)
    longest: Scalar = param("s", "time for which they may differ more", low=0.0, default=0.0, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        """Both."""
        return self.reading, self.other

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """For how long they have differed."""
        return (0.0,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Whether they have differed for too long."""
        fine = xp.abs(readings[self.reading] - readings[self.other]) <= self.limit
        time = xp.where(fine, 0.0, memory[0] + dt)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (time,))
