"""A sensor that says the truth, for comparison: no lag, no noise, no rounding.

    reading = y

y is any one output; mounted on a bench it has a sample time and a delay like any other sensor, so
that the cost of these alone can be seen.
"""

from __future__ import annotations

from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("ideal")
class IdealSensor(AbstractSensor):
    """Says one output exactly, in the unit of that output."""

    unit = None
    sees = ("position",)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """The truth."""
        return truth[0], ()
