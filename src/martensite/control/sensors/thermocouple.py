"""Thermocouple on a wire: a bead that lags, and leads that cool it.

    T_f = T_a + a (T - T_a),    τ dT_s/dt = T_f - T_s,    reading = round((T_s + b + σ n)/q) q

The bead takes heat from the wire and loses some through its own leads, so that it stays at T_f,
below the wire: the stem error (1 - a) (T - T_a), with the share a of good attachment, 1 for a bead
at the temperature of the wire. It follows with the time constant τ of the bead. b is an error
of the cold junction. The voltage is taken to be linearised by the instrument, and the heat that
the bead takes from a thin wire is not taken from it: on a wire as thin as the leads it should be.

All defaults are assumed.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.base.units import DEGREES
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.control.sensors.lag import follow_lag
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("thermocouple")
class ThermocoupleSensor(AbstractSensor):
    """A bead that is attached to the wire, more or less well."""

    unit = "K"
    sees = ("temperature", "ambient")

    attachment: Scalar = param(
        "1", "share of the rise of the wire that the bead takes", above=0.0, high=1.0, default=0.9
    )
    lag: Scalar = param("s", "time constant of the bead", low=0.0, default=0.3)
    offset: Scalar = param(DEGREES, "error of the cold junction", default=0.0)
    noise: Scalar = param(DEGREES, "standard deviation of a reading", low=0.0, default=0.1)
    resolution: Scalar = param(DEGREES, "least step of a reading", low=0.0, default=0.25)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """The temperature of the bead."""
        return (self._bead(truth),)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """The temperature of the bead with noise [K]."""
        felt = follow_lag(xp, state[0], self._bead(truth), self.lag, dt)
        return felt + self.offset + self.noise * noise, (felt,)

    def _bead(self, truth: Column) -> Scalar:
        """T_f [K]."""
        wire, around = truth
        return around + self.attachment * (wire - around)
