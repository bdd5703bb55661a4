"""Load cell: a force, by a spring with strain gauges.

    τ dF_s/dt = F - F_s,    c(F) = (1 + g) F + 4 ν F (1 - |F|/range)
    reading = round((c(F_s) + b + σ n)/q) q,  within ±range

ν is the nonlinearity: the largest deviation from the straight line through zero and full load, as
a share of the range, reached at half of it. Creep and hysteresis of the cell are not modelled, nor
is its own compliance, which a soft one adds to the mechanism.

The defaults are assumed: a range of 50 N in 16 bits.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.control.sensors.base import SENSORS
from martensite.control.sensors.channel import AbstractChannel
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("force")
class ForceSensor(AbstractChannel):
    """The force, with errors of gain, offset and linearity."""

    unit = "N"
    sees = ("force",)

    nonlinearity: Scalar = param(
        "1", "largest deviation from a straight line over the range", low=-0.25, high=0.25, default=0.0
    )
    offset: Scalar = param("N", "reading of zero", default=0.0)
    noise: Scalar = param("N", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Scalar = param("N", "least step of a reading", low=0.0, default=50.0 / 2**15)
    range: Scalar = param("N", "largest reading, either way", above=0.0, default=50.0)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        """c(F) [N]; beyond the range it goes on straight."""
        within = xp.clip(felt, -self.range, self.range)
        bow = 4.0 * self.nonlinearity * within * (1.0 - xp.abs(within) / self.range)
        return super().curve(xp, felt) + bow
