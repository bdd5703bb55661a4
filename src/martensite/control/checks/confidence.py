"""The check of an observer that says how far it can be trusted."""

from martensite.base.parameters import Number, param, text
from martensite.control.checks.base import CHECKS, Column, Looked, Named
from martensite.control.checks.reading import AbstractReadingCheck
from martensite.kernels.namespace import Namespace, Scalar


@CHECKS.register("low-confidence")
class LowConfidence(AbstractReadingCheck):
    """An observer that has not trusted its own estimates for a while.

    The confidence is an estimate between 1 and 0, such as that of the observer `model-bank`. NaN counts as no
    confidence. Controllers may get slower by the same reading; this cuts where they would only stop.
    """

    alarm, size = 9, 1

    reading: str = text("name of the confidence", default="estimated.confidence", typical="current")
    limit: Number = param("1", "least confidence", above=0.0, high=1.0, default=0.3)
    longest: Number = param("s", "time for which it may be lower", low=0.0, default=0.5, typical="0.1 s")

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """For how long it has been lower."""
        return (0.0,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check whether the confidence has been low for too long."""
        fine = readings[self.reading] >= self.limit
        time = xp.where(fine, 0.0, memory[0] + dt)
        trips = time > self.longest
        return Looked(trips, fine, (time,))
