"""Inclinometer: an angle against gravity, smoothed.

    τ dφ_s/dt = φ - φ_s,    reading = round((φ_s + b + σ n)/q) q,  within ±range

An accelerometer feels the direction of gravity, and every jolt with it; the low-pass of time
constant τ that keeps jolts away makes it late. What jolts leave behind is part of the noise σ:
accelerations of what it sits on are not computed. b is an error of mounting. An angle
without that lag is got from both a `tilt` and a `gyroscope`, by an observer.

All defaults are assumed.
"""

from __future__ import annotations

import math

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS
from martensite.control.sensors.channel import AbstractChannel
from martensite.kernels.namespace import Scalar

DEGREE = math.pi / 180.0


@SENSORS.register("tilt")
class TiltSensor(AbstractChannel):
    """An angle with a low-pass."""

    unit = "rad"
    sees = ("angle",)

    lag: Scalar = param("s", "time constant; 0 for none", low=0.0, default=0.05)
    offset: Scalar = param("rad", "reading of zero", default=0.0)
    noise: Scalar = param("rad", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Scalar = param("rad", "least step of a reading", low=0.0, default=0.01 * DEGREE)
    range: Scalar = param("rad", "largest reading, either way", above=0.0, default=0.5 * math.pi)
