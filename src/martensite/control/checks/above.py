"""A reading above its limit; cleared once it is below the limit by a band.

What is no number is above every limit.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param, text
from martensite.base.units import DEGREES
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.kernels.namespace import Namespace, Scalar


class AbstractAbove(AbstractCheck):
    """Interface of a check of one reading; a subclass declares `limit` and `band` in its unit."""

    limit: Scalar
    """Most that is allowed; infinite for none."""
    band: Scalar
    """How far below the limit it is well again."""

    reading: str = text("name of the reading", typical="temperature")

    def reads(self) -> tuple[str, ...]:
        """The reading."""
        return (self.reading,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Whether its size is above the limit."""
        size = xp.abs(readings[self.reading])
        return Looked(xp.negate(size <= self.limit), size < self.limit - self.band, ())


@CHECKS.register("overheat")
class Overheat(AbstractAbove):
    """A measured temperature above its limit."""

    alarm = 1

    limit: Scalar = param("K", "highest temperature", above=0.0, default=math.inf, typical="80 degC")
    band: Scalar = param(DEGREES, "how far below it is well again", low=0.0, default=0.0, typical="5 K")


@CHECKS.register("over-current")
class OverCurrent(AbstractAbove):
    """A measured current, of either direction, above its limit."""

    alarm = 2

    limit: Scalar = param("A", "largest current", above=0.0, default=math.inf, typical="1 A")
    band: Scalar = param("A", "how far below it is well again", low=0.0, default=0.0, typical="0.2 A")


@CHECKS.register("over-stress")
class OverStress(AbstractAbove):
    """A measured stress above its limit."""

    alarm = 3

    limit: Scalar = param("Pa", "largest stress", above=0.0, default=math.inf, typical="100 MPa")
    band: Scalar = param("Pa", "how far below it is well again", low=0.0, default=0.0, typical="10 MPa")


@CHECKS.register("over-force")
class OverForce(AbstractAbove):
    """A measured force above its limit."""

    alarm = 3

    limit: Scalar = param("N", "largest force", above=0.0, default=math.inf, typical="10 N")
    band: Scalar = param("N", "how far below it is well again", low=0.0, default=0.0, typical="1 N")
