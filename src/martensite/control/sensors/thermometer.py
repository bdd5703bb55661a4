"""Thermometers of a wire that also sense the ambient temperature: thermocouple and infrared thermometer."""

import math

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param
from martensite.base.units import DEGREES
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.control.sensors.channel import follow_lag
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("thermocouple")
class ThermocoupleSensor(AbstractSensor):
    """A thermocouple bead attached to the wire.

        T_f = T_a + a (T - T_a),    τ dT_s/dt = T_f - T_s,    reading = round((T_s + b + σ n)/q) q

    The bead loses heat through its leads, so that its steady state T_f is below the wire temperature by the stem error
    (1 - a) (T - T_a). The attachment a is 1 for a bead at the wire temperature. τ is the time constant of the bead, b
    the error of the cold junction. The instrument linearises the voltage. The heat that the bead takes from the wire is
    neglected, which is wrong for a wire as thin as the leads.

    All defaults are assumed.
    """

    unit = "K"
    sees = ("temperature", "ambient")

    attachment: Number = param(
        "1", "temperature rise of the bead over that of the wire", above=0.0, high=1.0, default=0.9
    )
    lag: Number = param("s", "time constant of the bead", low=0.0, default=0.3)
    offset: Number = param(DEGREES, "error of the cold junction", default=0.0)
    noise: Number = param(DEGREES, "standard deviation of a reading", low=0.0, default=0.1)
    resolution: Number = param(DEGREES, "least step of a reading", low=0.0, default=0.25)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return (self._bead(truth),)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        felt = follow_lag(xp, state[0], self._bead(truth), self.lag, dt)
        return felt + self.offset + self.noise * noise, (felt,)

    def _bead(self, truth: Column) -> Scalar:
        wire, around = truth
        return around + self.attachment * (wire - around)


@SENSORS.register("infrared")
class InfraredSensor(AbstractSensor):
    """An infrared thermometer that sees the wire and its background, with a lag.

        T_f = T_a + κ (T - T_a)                    linear mixing
        T_f⁴ = T_a⁴ + κ (T⁴ - T_a⁴)                mixing of radiation
        τ dT_s/dt = T_f - T_s,    reading = round((T_s + σ n)/q) q,  within its range

    The field of view holds the wire at T and a background at T_a. κ = (f + f' t) ε/ε_s is the weight of the wire: f is
    its fraction of the field of view, which drifts if the wire moves; ε is the emissivity of the wire, a grey body that
    reflects the ambient radiation at T_a; ε_s is the emissivity setting. Radiation is the total radiation of a grey
    body: the band of wavelengths, the temperature of the thermometer and its window are neglected.

    The paper states that the reading "is an average between SMA wire temperature and the temperature of the ambient
    around the SMA wire", without the fraction; f, τ and the noise are assumed. By default the wire is black and the
    mixing linear.
    """

    cites = ("copaci2019",)
    unit = "K"
    sees = ("temperature", "ambient")

    mixing: str = option(
        "average over the field of view: of temperature (linear) or radiation", "linear", "radiance", default="linear"
    )
    factor: Number = param("1", "fraction of the wire in the field of view", above=0.0, high=1.0, default=0.6)
    drift: Number = param("1/s", "change of that fraction with time", default=0.0)
    emissivity: Number = param("1", "emissivity of the wire", above=0.0, high=1.0, default=1.0)
    setting: Number = param("1", "emissivity setting of the thermometer", above=0.0, high=1.0, default=1.0)
    lag: Number = param("s", "time constant", above=0.0, default=0.25)
    noise: Number = param(DEGREES, "standard deviation of a reading", low=0.0, default=0.1)
    resolution: Number = param(DEGREES, "least step of a reading", low=0.0, default=0.02)
    lowest: Number = param("K", "lowest reading", default=-math.inf)
    highest: Number = param("K", "highest reading", default=math.inf)

    def check(self) -> None:
        if not self.lowest < self.highest:
            raise ParameterError(
                f"The range of a thermometer must not be empty, but goes from {self.lowest:g} K to {self.highest:g} K."
            )

    def limits(self) -> tuple[Scalar, Scalar]:
        return self.lowest, self.highest

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return self._filtered_temperature(xp, truth, 0.0), 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        time = state[1] + dt
        felt = follow_lag(xp, state[0], self._filtered_temperature(xp, truth, time), self.lag, dt)
        return felt + self.noise * noise, (felt, time)

    def _filtered_temperature(self, xp: Namespace, truth: Column, time: Scalar) -> Scalar:
        wire, behind = truth
        fraction = (self.factor + self.drift * time) * (self.emissivity / self.setting)
        if self.mixing == "linear":
            return behind + fraction * (wire - behind)
        background = _raise_fourth(behind)
        return xp.sqrt(xp.sqrt(background + fraction * (_raise_fourth(wire) - background)))


def _raise_fourth(x: Scalar) -> Scalar:
    return x * x * (x * x)
