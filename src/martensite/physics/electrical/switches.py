"""Constant supply behind switches with a duty cycle, averaged over the carrier periods.

While the switch is closed, the element takes the power I_on² R. For a duty cycle D, the mean over a period and the
equivalent current are

    P = D I_on² R,    I = √D I_on,    I_on = U/(R + R_s).

A voltage D U would heat with D² instead: less than a third of the power at D = 0.3. Current, voltage and power of a run
are therefore rms current, rms voltage and mean power.
"""

import math

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSwitch, SignalRange


@SOURCES.register("pwm-voltage")
class PwmVoltage(AbstractSwitch):
    """Constant voltage behind a switch; the drive is the duty cycle, limited to [0, 1].

    At 0 or 1 this is the switch itself: the waveform `carrier` drives it pulse by pulse.
    """

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return xp.sqrt(xp.clip(drive, 0.0, 1.0)) * self.closed_current(xp, resistance)


@SOURCES.register("mosfet")
class Mosfet(AbstractSwitch):
    """Supply, element and transistor to ground in series, driven by pulses; the drive is a duty cycle.

        I_on = U/(R + R_s + R_i + R_on),   I = √D_e I_on,   P = D_e I_on² R

    with the internal resistance R_i of the supply and the constant on-resistance R_on of the transistor. Each pulse of
    a carrier of frequency f loses the time t_d before the transistor conducts; pulses shorter than t_p do not occur:

        D_e = D - t_d f,   0 if D_e < t_p f,   1 at D = 1 (no switching)

    Edges are steep: losses in the transistor heat the transistor, not the element.
    """

    supply_resistance: Number = param("ohm", "internal resistance of the supply", low=0.0, high=1e6, default=0.0)
    on_resistance: Number = param("ohm", "resistance of the closed transistor", low=0.0, high=1e6, default=0.0)
    frequency: Number = param("Hz", "frequency of the carrier", above=0.0, high=1e7, typical="1 kHz")
    dead_time: Number = param(
        "s", "time of every pulse that is lost before the transistor conducts", low=0.0, high=1.0, default=0.0
    )
    smallest_pulse: Number = param("s", "shortest time that the transistor conducts", low=0.0, high=1.0, default=0.0)

    @override
    def closed_current(self, xp: Namespace, resistance: Scalar) -> Scalar:
        around = self.series_resistance + self.supply_resistance + self.on_resistance
        return xp.minimum(self.supply / (resistance + around), self.current_limit)

    @override
    def share(self, xp: Namespace, drive: Scalar, frequency: Scalar) -> Scalar:
        left = drive - self.dead_time * frequency
        pulse_share = xp.where(left < self.smallest_pulse * frequency, 0.0, xp.maximum(left, 0.0))
        return xp.where(drive < 1.0, pulse_share, 1.0)

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        share = self.share(xp, drive, self.frequency)
        return xp.sqrt(share) * self.closed_current(xp, resistance)


@SOURCES.register("h-bridge")
class HBridge(AbstractSwitch):
    """Supply behind four switches; the drive is a signed duty cycle.

        I_on = (U - U_d)/(R + R_s + R_1 + R_2),   I = sign(D) √D_e I_on,   D_e = |D| - 2 t_d f

    with the duty cycle D from -1 to 1. Two switches conduct at a time, with on-resistances R_1 and R_2. Each of the two
    edges of a pulse loses the time t_d; at |D| = 1 nothing switches and D_e = 1. No current flows between pulses
    because the inductance of the element is negligible.

    With a diode in series an element conducts in one direction only (`conducts`) and loses the forward voltage U_d. One
    bridge thus serves an antagonistic pair: both elements get the same signal, one with `conducts` = `positive`, the
    other with `negative`.
    """

    high_resistance: Number = param("ohm", "on-resistance of the switch to the supply", low=0.0, high=1e6, default=0.0)
    low_resistance: Number = param("ohm", "on-resistance of the switch to ground", low=0.0, high=1e6, default=0.0)
    frequency: Number = param("Hz", "frequency of the carrier", above=0.0, high=1e7, typical="1 kHz")
    dead_time: Number = param("s", "time that is lost at each edge of a pulse", low=0.0, high=1.0, default=0.0)
    conducts: str = option(
        "directions that reach the element: both, or one through a diode",
        "both",
        "positive",
        "negative",
        default="both",
    )
    diode_voltage: Number = param("V", "forward voltage of the diode, if there is one", low=0.0, high=1e3, default=0.0)

    @override
    def closed_current(self, xp: Namespace, resistance: Scalar) -> Scalar:
        diode = 0.0 if self.conducts == "both" else self.diode_voltage
        around = self.series_resistance + self.high_resistance + self.low_resistance
        volts = xp.maximum(self.supply - diode, 0.0)
        return xp.minimum(volts / (resistance + around), self.current_limit)

    @override
    def share(self, xp: Namespace, drive: Scalar, frequency: Scalar) -> Scalar:
        wanted = self._let_through(xp, drive)
        pulse_share = xp.maximum(wanted - 2.0 * self.dead_time * frequency, 0.0)
        return xp.where(wanted < 1.0, pulse_share, 1.0)

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        size = xp.sqrt(self.share(xp, drive, self.frequency)) * self.closed_current(xp, resistance)
        return xp.where(drive < 0.0, -size, size)

    @override
    def reach(self, resistance: float) -> SignalRange:
        least = 0.0 if self.conducts == "positive" else -1.0
        return SignalRange(least, 0.0 if self.conducts == "negative" else 1.0)

    def _let_through(self, xp: Namespace, drive: Scalar) -> Scalar:
        """Return |D| as far as the diode conducts."""
        if self.conducts == "positive":
            return xp.maximum(drive, 0.0)
        if self.conducts == "negative":
            return xp.maximum(-drive, 0.0)
        return xp.abs(drive)


@SOURCES.register("power-pwm")
class PowerPwm(AbstractSwitch):
    """Demanded power, delivered by a switched constant voltage with a computed duty cycle.

        D = P_demand/P_max,   0 ≤ D ≤ 1

    P_max is the measured voltage times current of the element while the switch is closed. Measured in every period it
    is I_on² R, and the power is as demanded. Measured once, at a resistance R₀, the power is wrong by the factor
    P_max(R)/P_max(R₀): R₀/R without series resistance, R/R₀ at the current limit.

    The power is averaged over short periods; `martensite.control.controllers.constant_power` has the sampled loop.
    Source: the power control of the paper on a finger prototype (section 5.1), which measures once, "prior to the
    experimental campaign". The paper speaks of the difference of desired and maximum power; a duty cycle is their
    ratio.
    """

    cites = ("finger-paper",)
    unit = "W"

    measured: str = option(
        "when the largest power is measured: in `every-period`, or `once` before the run",
        "every-period",
        "once",
        default="every-period",
    )
    reference_resistance: Number = param(
        "ohm", "resistance of the element when measured once", above=0.0, default=math.inf, typical="4 ohm"
    )

    def check(self) -> None:
        """Raise `ParameterError` if the reference resistance is missing."""
        if self.measured == "once" and not math.isfinite(self.reference_resistance):
            raise ParameterError(
                "`power-pwm` with `measured` = `once` needs `reference_resistance` [ohm] "
                "(resistance of the element when measured once); none given."
            )

    @override
    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return xp.sqrt(self._duty(xp, drive, resistance)) * self.closed_current(xp, resistance)

    @override
    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self._duty(xp, drive, resistance) * self.closed_current(xp, resistance)

    def _duty(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        reference = self._choose_reference(resistance)
        most = self.closed_current(xp, reference)
        return xp.clip(drive / (most * most * reference), 0.0, 1.0)

    @override
    def reach(self, resistance: float) -> SignalRange:
        return SignalRange(0.0, self.largest_power(self._choose_reference(resistance)))

    def _choose_reference(self, resistance: Scalar) -> Scalar:
        return self.reference_resistance if self.measured == "once" else resistance
