"""An open circuit: a signal is on, but no current flows.

The current is measured under the signal of the period before, and late by the delay of its sensor, which the time until
the alarm must exceed. Under no signal nothing can be known: a guard that resumes tries again, after its `hold`.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param, text
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CHECKS.register("open-circuit")
class NoCurrent(AbstractCheck):
    """A circuit through which nothing flows."""

    alarm, size = 6, 2

    reading: str = text("name of the reading of the current", typical="current")
    most: Scalar = param("A", "current that counts as none", low=0.0, default=0.0, typical="0.02 A")
    longest: Scalar = param(
        "s", "time under a signal after which it is open", low=0.0, default=math.inf, typical="0.3 s"
    )
    least: Scalar = param(DRIVE, "signal that counts as none", low=0.0, default=0.0, typical=0.05)

    def reads(self) -> tuple[str, ...]:
        """The current."""
        return (self.reading,)

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """For how long there has been no current, and whether a signal is on."""
        return 0.0, 0.0

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Whether there has been no current for too long."""
        time, on = memory
        none = xp.both(on > 0.5, xp.abs(readings[self.reading]) <= self.most)
        time = xp.where(none, time + dt, 0.0)
        trips = time > self.longest
        return Looked(trips, xp.negate(trips), (time, on))

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """With whether a signal is on in the next period."""
        return memory[0], self.on(xp, allowed, self.least)
