"""A measuring channel: a converter with its amplifier, whatever it converts.

    τ dx/dt = y - x,    reading = round((c(x) + b + σ n)/q) q,  within ±range

y is the truth, c the curve of the channel, which for all but some is (1 + g) x with an error g of
the gain. b is the offset, q the least step of the converter.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.control.sensors.base import AbstractSensor, Column
from martensite.control.sensors.lag import follow_lag
from martensite.kernels.namespace import Namespace, Scalar


class AbstractChannel(AbstractSensor):
    """One truth with lag, gain, offset and noise; a subclass declares these in its own unit."""

    offset: Scalar
    """Reading of nothing."""
    range: Scalar
    """Largest reading, either way."""
    gain_error: Scalar = param("1", "error of the gain", above=-1.0, default=0.0)
    lag: Scalar = param("s", "time constant; 0 for none", low=0.0, default=0.0)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """The truth."""
        return (truth[0],)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """What is felt, through the curve, with offset and noise."""
        felt = follow_lag(xp, state[0], truth[0], self.lag, dt)
        return self.curve(xp, felt) + self.offset + self.noise * noise, (felt,)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        """What the channel makes of what it feels."""
        return (1.0 + self.gain_error) * felt

    def limits(self) -> tuple[Scalar, Scalar]:
        """As far either way."""
        return -self.range, self.range
