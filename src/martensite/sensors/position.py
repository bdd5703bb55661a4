"""Linear position encoder: what it says is the position, noise and its least step.

    reading = round((y + σ n)/q) q

The defaults are those of a magnetic encoder of 12 bits over poles of 2 mm, q = 2 mm/4096; the
noise is assumed.
"""

from __future__ import annotations

from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.sensors.base import SENSORS, AbstractSensor, Column


@SENSORS.register("position")
class PositionSensor(AbstractSensor):
    """An encoder without lag."""

    cites = ("copaci2019",)
    unit = "m"
    sees = ("position",)

    noise: float = param("m", "standard deviation of a reading", low=0.0, default=0.5e-6)
    resolution: float = param("m", "least step of a reading", low=0.0, default=2e-3 / 4096)

    def step(
        self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """The position with noise [m]."""
        return truth[0] + self.noise * noise, ()
