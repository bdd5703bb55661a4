"""Sources that follow their signal within limits: current, voltage, power, amplifier; and a temperature bath."""

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp
from martensite.physics.electrical.base import SOURCES, AbstractSource, AbstractSupply, SignalRange


@SOURCES.register("current")
class CurrentSource(AbstractSupply):
    """Imposed current I = u within the current and voltage limits of the supply."""

    unit = "A"

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        most = self.most(xp, resistance)
        return xp.clip(drive, -most, most)

    @override
    def reach(self, resistance: float) -> SignalRange:
        most = self.most(xp, resistance)
        return SignalRange(-most, most)


@SOURCES.register("voltage")
class VoltageSource(AbstractSupply):
    """Voltage with series resistance R_s, I = u/(R + R_s), within the limits of the supply."""

    unit = "V"

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        most = self.most(xp, resistance)
        return xp.clip(drive / (resistance + self.series_resistance), -most, most)

    @override
    def reach(self, resistance: float) -> SignalRange:
        most = self.most(xp, resistance) * (resistance + self.series_resistance)
        return SignalRange(-most, most)


@SOURCES.register("power")
class PowerSource(AbstractSupply):
    """Imposed power P = u in the element, within the limits of the supply; negative demands count as 0."""

    unit = "W"
    linear = "power"

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        wanted = xp.sqrt(xp.maximum(drive, 0.0) / resistance)
        return xp.minimum(wanted, self.most(xp, resistance))

    @override
    def power(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        most = self.most(xp, resistance)
        return xp.minimum(xp.maximum(drive, 0.0), most * most * resistance)

    @override
    def reach(self, resistance: float) -> SignalRange:
        most = self.most(xp, resistance)
        return SignalRange(0.0, most * most * resistance)


@SOURCES.register("temperature")
class PrescribedTemperature(AbstractSource):
    """Temperature of the element [K] as the drive signal, as a chamber or bath imposes it.

    For isobaric and isothermal tests. There is no current and no heat balance.
    """

    unit = "K"
    sets_temperature = True

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return 0.0 * resistance


@SOURCES.register("linear-amplifier")
class LinearAmplifier(AbstractSupply):
    """Power transistor that follows a signal voltage; `voltage_limit` is its supply voltage.

        U = k u + U_0,   U_low ≤ U ≤ U_supply - U_h,   I = U/(R + R_o + R_s),   |I| ≤ I_lim

    with gain k, offset U_0, output resistance R_o, and headroom U_h across the transistor at full output. U_low is 0
    for a single supply and negative for two supplies. The remaining supply power heats the transistor.

    The MigaOne paper uses gain 1, a 5 V supply, up to 3 A and TIP power transistors as followers. It states neither
    offset, headroom nor output resistance, which default to 0; a follower usually has one or two base-emitter voltages
    of headroom.
    """

    cites = ("migaone-paper",)
    unit = "V"

    gain: Number = param("1", "gain k", above=0.0, high=1e4, default=1.0)
    offset: Number = param("V", "output at no signal", low=-1e3, high=1e3, default=0.0)
    lowest: Number = param(
        "V", "lowest output; below 0 with a second supply, as strong as the first", low=-1e4, high=0.0, default=0.0
    )
    headroom: Number = param("V", "voltage that the transistor needs at most output", low=0.0, high=1e3, default=0.0)
    output_resistance: Number = param("ohm", "output resistance of the amplifier", low=0.0, high=1e6, default=0.0)

    @override
    def check(self) -> None:
        if not self.headroom < self.voltage_limit:
            raise ParameterError(
                f"`headroom` of `linear-amplifier` must be below its `voltage_limit` of "
                f"{self.voltage_limit:g} V, but is {self.headroom:g} V."
            )

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        highest = xp.maximum(self.voltage_limit - self.headroom, 0.0)
        volts = xp.clip(self.gain * drive + self.offset, self.lowest, highest)
        behind = resistance + self.output_resistance
        most = self.most(xp, behind)
        return xp.clip(volts / (behind + self.series_resistance), -most, most)

    @override
    def reach(self, resistance: float) -> SignalRange:
        behind = resistance + self.output_resistance
        most = self.most(xp, behind) * (behind + self.series_resistance)
        high = xp.minimum(self.voltage_limit - self.headroom, most)
        low = xp.maximum(self.lowest, -most)
        return SignalRange((low - self.offset) / self.gain, (high - self.offset) / self.gain)
