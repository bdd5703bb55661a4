"""Gyroscope: the rate at which an angle changes.

    y = (φ - φ⁻)/Δt,    τ dω/dt = y - ω,    reading = round((ω + b + σ n)/q) q,  within ±range

y is the mean rate since the reading before, from the angles then and now, so that its integral is the way gone. Its
bandwidth 1/(2π τ) is that of a lag. b is the bias, a constant: integrated, it makes an angle that runs away.

The defaults are assumed: a range of ±2000 deg/s in 16 bits, 40 Hz, and noise of 0.1 deg/s.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.control.sensors.lag import follow_lag
from martensite.kernels.namespace import Namespace, Scalar

DEGREE = math.pi / 180.0


@SENSORS.register("gyroscope")
class GyroscopeSensor(AbstractSensor):
    """Angular rate, from differences of an angle."""

    unit = "rad/s"
    sees = ("angle",)

    bias: Scalar = param("rad/s", "reading at rest", default=0.0)
    lag: Scalar = param("s", "time constant; 0 for none", low=0.0, default=4e-3)
    noise: Scalar = param("rad/s", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Scalar = param("rad/s", "least step of a reading", low=0.0, default=2000.0 * DEGREE / 2**15)
    range: Scalar = param("rad/s", "largest reading, either way", above=0.0, default=2000.0 * DEGREE)

    def limits(self) -> tuple[Scalar, Scalar]:
        """As far either way."""
        return -self.range, self.range

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """The angle, and no rate."""
        return truth[0], 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """The lagged rate with bias and noise [rad/s]; in no time it stays as it was."""
        before, felt = state
        some = dt > 0.0
        rate = xp.where(some, (truth[0] - before) / xp.where(some, dt, 1.0), felt)
        felt = follow_lag(xp, felt, rate, self.lag, dt)
        return felt + self.bias + self.noise * noise, (truth[0], felt)
