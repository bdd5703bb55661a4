"""A lost sensor: its last reading is too old.

The age of a reading is what has gone by since it was made. The limit must be longer than the
sample time of the sensor and its delay together.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param, text
from martensite.control.checks.base import CHECKS, AbstractCheck, Column, Looked, Named
from martensite.control.loop.names import AGE
from martensite.kernels.namespace import Namespace, Scalar


@CHECKS.register("sensor-lost")
class SensorLost(AbstractCheck):
    """A sensor of which nothing new is heard."""

    alarm = 4

    reading: str = text("name of the reading", typical="temperature")
    timeout: Scalar = param("s", "age beyond which it is lost", above=0.0, default=math.inf, typical="0.3 s")

    def reads(self) -> tuple[str, ...]:
        """The age of the reading."""
        return (self.reading + AGE,)

    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Whether it is too old."""
        fine = readings[self.reading + AGE] <= self.timeout
        return Looked(xp.negate(fine), fine, ())
