"""Linear position sensor: the position behind some play, offset, drift, noise and its least step.

    p⁺ = max(y - w/2, min(y + w/2, p)),    reading = round((p + b + v t + σ n)/q) q

p is the position of its slider, y that of what carries it along, and w the backlash between the
two: after a turn the slider stays until the play is used up (Krasnosel'skii and Pokrovskii 1989).
It starts in the middle of the play. b is the offset of the zero, which drifts at the rate v, a
given number and not a random walk, so that a run tells what a drift of that size does.

The defaults are those of a magnetic encoder of 12 bits over poles of 2 mm, q = 2 mm/4096, without
play, offset and drift; the noise is assumed.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("position")
class PositionSensor(AbstractSensor):
    """A position sensor without lag."""

    cites = ("copaci2019", "krasnoselskii1989")
    unit = "m"
    sees = ("position",)

    noise: Scalar = param("m", "standard deviation of a reading", low=0.0, default=0.5e-6)
    resolution: Scalar = param("m", "least step of a reading", low=0.0, default=2e-3 / 4096)
    backlash: Scalar = param("m", "play between sensor and what moves", low=0.0, default=0.0)
    offset: Scalar = param("m", "reading of zero at the start", default=0.0)
    drift: Scalar = param("m/s", "change of the offset with time", default=0.0)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """In the middle of the play, and no time gone by."""
        return truth[0], 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """The position of the slider with offset and noise [m]."""
        half, time = 0.5 * self.backlash, state[1] + dt
        place = xp.maximum(truth[0] - half, xp.minimum(truth[0] + half, state[0]))
        value = place + (self.offset + self.drift * time)
        return value + self.noise * noise, (place, time)
