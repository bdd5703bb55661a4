"""Current sensor: a shunt or a Hall element with its converter.

    τ dI_s/dt = I - I_s,    reading = round(((1 + g) I_s + b + σ n)/q) q,  within ±range

I is the current through the element, for a switched source the rms current of a period. The
defaults are assumed: ±5 A in 12 bits, and noise of two steps.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS
from martensite.control.sensors.channel import AbstractChannel
from martensite.kernels.namespace import Scalar


@SENSORS.register("current")
class CurrentSensor(AbstractChannel):
    """The current, with errors of gain and offset."""

    unit = "A"
    sees = ("current",)

    offset: Scalar = param("A", "reading of zero", default=0.0)
    noise: Scalar = param("A", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Scalar = param("A", "least step of a reading", low=0.0, default=5.0 / 2**11)
    range: Scalar = param("A", "largest reading, either way", above=0.0, default=5.0)
