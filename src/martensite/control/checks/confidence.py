"""Check of the confidence of an observer."""

from martensite.base.parameters import Number, param, text
from martensite.control.checks.base import CHECKS, CheckResult, Column, Named
from martensite.control.checks.reading import AbstractReadingCheck
from martensite.kernels.namespace import Namespace, Scalar


@CHECKS.register("low-confidence")
class LowConfidence(AbstractReadingCheck):
    """Cut signals if an observer has had low confidence in its estimates for too long.

    The confidence is an estimate between 0 and 1, such as the confidence of the observer `model-bank`. NaN counts as 0.
    """

    alarm, size = 9, 1

    reading: str = text("name of the confidence", default="estimated.confidence", typical="current")
    limit: Number = param("1", "least confidence", above=0.0, high=1.0, default=0.3)
    longest: Number = param("s", "time for which it may be lower", low=0.0, default=0.5, typical="0.1 s")

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the time of low confidence, 0 s."""
        return (0.0,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        fine = readings[self.reading] >= self.limit
        time = xp.where(fine, 0.0, memory[0] + dt)
        trips = time > self.longest
        return CheckResult(trips, fine, (time,))
