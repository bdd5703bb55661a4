"""Thermometers of a wire, which see what is around it as well: a thermocouple, an infrared thermometer."""

import math

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param
from martensite.base.units import DEGREES
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.control.sensors.channel import follow_lag
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("thermocouple")
class ThermocoupleSensor(AbstractSensor):
    """A bead that is attached to the wire, more or less well.

        T_f = T_a + a (T - T_a),    τ dT_s/dt = T_f - T_s,    reading = round((T_s + b + σ n)/q) q

    The bead takes heat from the wire and loses some through its own leads, so that it stays at T_f, below the wire: the
    stem error (1 - a) (T - T_a), with the share a of good attachment, 1 for a bead at the temperature of the wire. It
    follows with the time constant τ of the bead. b is an error of the cold junction. The voltage is taken to be
    linearised by the instrument, and the heat that the bead takes from a thin wire is not taken from it: on a wire as
    thin as the leads it should be.

    All defaults are assumed.
    """

    unit = "K"
    sees = ("temperature", "ambient")

    attachment: Number = param("1", "share of the wire's rise that the bead takes", above=0.0, high=1.0, default=0.9)
    lag: Number = param("s", "time constant of the bead", low=0.0, default=0.3)
    offset: Number = param(DEGREES, "error of the cold junction", default=0.0)
    noise: Number = param(DEGREES, "standard deviation of a reading", low=0.0, default=0.1)
    resolution: Number = param(DEGREES, "least step of a reading", low=0.0, default=0.25)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the temperature of the bead."""
        return (self._bead(truth),)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the temperature of the bead with noise [K]."""
        felt = follow_lag(xp, state[0], self._bead(truth), self.lag, dt)
        return felt + self.offset + self.noise * noise, (felt,)

    def _bead(self, truth: Column) -> Scalar:
        """T_f [K]."""
        wire, around = truth
        return around + self.attachment * (wire - around)


@SENSORS.register("infrared")
class InfraredSensor(AbstractSensor):
    """A thermometer that sees a share of the wire and follows with a lag.

        T_f = T_a + κ (T - T_a)                    mixed linearly
        T_f⁴ = T_a⁴ + κ (T⁴ - T_a⁴)                mixed as radiation
        τ dT_s/dt = T_f - T_s,    reading = round((T_s + σ n)/q) q,  within its range

    What it sees is a mixture of the wire, at T, and of what is behind it, at T_a. κ = (f + f' t) ε/ε_s is what counts
    of the wire: f is its share of the field of view, which may drift with time, as it does when a wire moves in it; ε
    is the emissivity of the wire, a grey body that reflects the rest from surroundings at T_a; ε_s is the emissivity
    that the thermometer is set to. It follows with the lag τ. Radiation is total radiation of a grey body: that a
    thermometer sees a band of wavelengths only is left out, and so are its own temperature and the window.

    The paper says of its thermometer that its reading "is an average between SMA wire temperature and the temperature
    of the ambient around the SMA wire", without the share; f, τ and the noise are assumed. By default the wire is black
    and the mixture linear.
    """

    cites = ("copaci2019",)
    unit = "K"
    sees = ("temperature", "ambient")

    mixing: str = option(
        "what is averaged over the field of view: temperature, or radiation", "linear", "radiance", default="linear"
    )
    factor: Number = param("1", "share of the wire in what is seen", above=0.0, high=1.0, default=0.6)
    drift: Number = param("1/s", "change of that share with time", default=0.0)
    emissivity: Number = param("1", "emissivity of the wire", above=0.0, high=1.0, default=1.0)
    setting: Number = param("1", "emissivity that it is set to", above=0.0, high=1.0, default=1.0)
    lag: Number = param("s", "time constant", above=0.0, default=0.25)
    noise: Number = param(DEGREES, "standard deviation of a reading", low=0.0, default=0.1)
    resolution: Number = param(DEGREES, "least step of a reading", low=0.0, default=0.02)
    lowest: Number = param("K", "lowest reading", default=-math.inf)
    highest: Number = param("K", "highest reading", default=math.inf)

    def check(self) -> None:
        """Raise `ParameterError` unless there is a range."""
        if not self.lowest < self.highest:
            raise ParameterError(
                f"The range of a thermometer must not be empty, but goes from {self.lowest:g} K to {self.highest:g} K."
            )

    def limits(self) -> tuple[Scalar, Scalar]:
        """Return its range."""
        return self.lowest, self.highest

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the temperature seen, and no time gone by."""
        return self._filtered_temperature(xp, truth, 0.0), 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the lagged temperature with noise [K]; the lag is exact for a truth that is held."""
        time = state[1] + dt
        felt = follow_lag(xp, state[0], self._filtered_temperature(xp, truth, time), self.lag, dt)
        return felt + self.noise * noise, (felt, time)

    def _filtered_temperature(self, xp: Namespace, truth: Column, time: Scalar) -> Scalar:
        """T_f [K]."""
        wire, behind = truth
        share = (self.factor + self.drift * time) * (self.emissivity / self.setting)
        if self.mixing == "linear":
            return behind + share * (wire - behind)
        back = _raise_fourth(behind)
        return xp.sqrt(xp.sqrt(back + share * (_raise_fourth(wire) - back)))


def _raise_fourth(x: Scalar) -> Scalar:
    return x * x * (x * x)
