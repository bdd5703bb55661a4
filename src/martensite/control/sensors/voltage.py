"""Voltage sensor: a divider with its converter.

    τ dU_s/dt = U - U_s,    reading = round(((1 + g) U_s + b + σ n)/q) q,  within ±range

U is the voltage across the element, for a switched source the rms voltage of a period. The
defaults are assumed: ±20 V in 12 bits, and noise of two steps.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS
from martensite.control.sensors.channel import AbstractChannel
from martensite.kernels.namespace import Scalar


@SENSORS.register("voltage")
class VoltageSensor(AbstractChannel):
    """The voltage, with errors of gain and offset."""

    unit = "V"
    sees = ("voltage",)

    offset: Scalar = param("V", "reading of zero", default=0.0)
    noise: Scalar = param("V", "standard deviation of a reading", low=0.0, default=20e-3)
    resolution: Scalar = param("V", "least step of a reading", low=0.0, default=20.0 / 2**11)
    range: Scalar = param("V", "largest reading, either way", above=0.0, default=20.0)
