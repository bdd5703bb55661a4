"""Infrared thermometer whose field of view a thin wire does not fill.

    T_f = T_a + κ (T - T_a),    τ dT_s/dt = T_f - T_s,    reading = round((T_s + σ n)/q) q

What it sees is a mixture of the wire, at T, and of what is behind it, at T_a; κ is the share of
the wire. It follows with the lag τ. κ may drift, κ + κ' t, as it does when a wire moves in the
field of view. The paper says of its thermometer that its reading "is an average between SMA wire
temperature and the temperature of the ambient around the SMA wire", without the share; κ, τ and
the noise are assumed.
"""

from __future__ import annotations

from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.sensors.base import SENSORS, AbstractSensor, Column


@SENSORS.register("infrared")
class InfraredSensor(AbstractSensor):
    """A thermometer that sees a share of the wire and follows with a lag."""

    cites = ("copaci2019",)
    unit = "K"
    sees = ("temperature", "ambient")

    factor: float = param(
        "1", "share of the wire in what is seen", above=0.0, high=1.0, default=0.6
    )
    drift: float = param("1/s", "change of that share with time", default=0.0)
    lag: float = param("s", "time constant", above=0.0, default=0.25)
    noise: float = param("K", "standard deviation of a reading", low=0.0, default=0.1)
    resolution: float = param("K", "least step of a reading", low=0.0, default=0.02)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """The temperature seen, and no time gone by."""
        return self._seen(truth, 0.0), 0.0

    def step(
        self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """The lagged temperature with noise [K]; the lag is exact for a truth that is held."""
        felt, time = state
        time = time + dt
        share = 1.0 - xp.exp(-dt / self.lag)
        felt = felt + share * (self._seen(truth, time) - felt)
        return felt + self.noise * noise, (felt, time)

    def _seen(self, truth: Column, time: Scalar) -> Scalar:
        wire, behind = truth
        return behind + (self.factor + self.drift * time) * (wire - behind)
