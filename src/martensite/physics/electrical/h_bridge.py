"""H-bridge: four switches that put the supply across the element in either direction, by pulses.

    I_on = (U - U_d)/(R + R_s + R_1 + R_2),   I = sign(D) √D_e I_on,   D_e = |D| - 2 t_d f

The duty D has a sign, -1 to 1. Two switches conduct at a time, one at either side of the element,
with the on-resistances R_1 and R_2. At each of the two edges of a pulse the time t_d is lost in
which no switch conducts; at |D| = 1 nothing is switched any more and D_e = 1. Averaged over the
periods of the carrier, as in `martensite.physics.electrical.pwm`; between pulses no current flows,
for a
shape-memory element has next to no inductance that would drive it on.

With a diode in its row an element takes one direction only (`conducts`), and loses the forward
voltage U_d of the diode. So one bridge serves an antagonistic pair: both get the same signal, one
with `conducts` = `positive`, the other with `negative`.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.base.parameters import option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSwitch, SignalRange


@SOURCES.register("h-bridge")
class HBridge(AbstractSwitch):
    """A supply behind four switches; the drive is a duty with a sign."""

    unit: ClassVar[str] = "1"

    high_resistance: Scalar = param("ohm", "on-resistance of the switch to the supply", low=0.0, high=1e6, default=0.0)
    low_resistance: Scalar = param("ohm", "on-resistance of the switch to ground", low=0.0, high=1e6, default=0.0)
    frequency: Scalar = param("Hz", "frequency of the carrier", above=0.0, high=1e7, typical="1 kHz")
    dead_time: Scalar = param(
        "s", "time that is lost at each of the two edges of a pulse", low=0.0, high=1.0, default=0.0
    )
    conducts: str = option(
        "directions that reach the element: both, or one through a diode",
        "both",
        "positive",
        "negative",
        default="both",
    )
    diode_voltage: Scalar = param("V", "forward voltage of the diode, if there is one", low=0.0, high=1e3, default=0.0)

    def closed_current(self, xp: Namespace, resistance: Scalar) -> Scalar:
        """Size [A] of the current through `resistance` [ohm] while the switches conduct."""
        diode = 0.0 if self.conducts == "both" else self.diode_voltage
        around = self.series_resistance + self.high_resistance + self.low_resistance
        volts = xp.maximum(self.supply - diode, 0.0)
        return xp.minimum(volts / (resistance + around), self.current_limit)

    def share(self, xp: Namespace, drive: Scalar, frequency: Scalar) -> Scalar:
        """Share of the time for which the element is connected, for a duty of either sign."""
        wanted = self._let_through(xp, drive)
        made = xp.maximum(wanted - 2.0 * self.dead_time * frequency, 0.0)
        return xp.where(wanted < 1.0, made, 1.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Rms current [A] with the sign of the duty."""
        size = xp.sqrt(self.share(xp, drive, self.frequency)) * self.closed_current(xp, resistance)
        return xp.where(drive < 0.0, -size, size)

    def reach(self, resistance: float) -> SignalRange:
        """Duties that are delivered: of either sign, or of the one that the diode lets through."""
        least = 0.0 if self.conducts == "positive" else -1.0
        return SignalRange(least, 0.0 if self.conducts == "negative" else 1.0)

    def _let_through(self, xp: Namespace, drive: Scalar) -> Scalar:
        """Size of a duty, as far as the diode lets it through."""
        if self.conducts == "positive":
            return xp.maximum(drive, 0.0)
        if self.conducts == "negative":
            return xp.maximum(-drive, 0.0)
        return xp.abs(drive)
