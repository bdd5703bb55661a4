"""Low-side switch: a transistor between the element and ground, driven by pulses.

    I_on = U/(R + R_s + R_i + R_on),   I = √D_e I_on,   P = D_e I_on² R

with the supply U behind its internal resistance R_i, and the on-resistance R_on of the transistor
at any temperature of it. Of every pulse of a carrier of frequency f the time t_d is lost before
the transistor conducts, and what is then shorter than the smallest pulse t_p does not come:

    D_e = D - t_d f,   0 if D_e < t_p f,   1 at a duty of 1, for nothing is switched any more

Averaged over the periods of the carrier, as in `martensite.physics.electrical.pwm`: currents and
voltages
are rms values, powers are means. Edges are steep: what is lost in the transistor itself, R_on I²
and at every edge, heats the transistor and not the element.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSwitch, SignalRange


@SOURCES.register("mosfet")
class Mosfet(AbstractSwitch):
    """A supply, an element and a transistor in a row; the drive is a duty."""

    unit: ClassVar[str] = "1"

    supply_resistance: Scalar = param("ohm", "internal resistance of the supply", low=0.0, high=1e6, default=0.0)
    on_resistance: Scalar = param(
        "ohm", "resistance of the transistor while it conducts", low=0.0, high=1e6, default=0.0
    )
    frequency: Scalar = param("Hz", "frequency of the carrier", above=0.0, high=1e7, typical="1 kHz")
    dead_time: Scalar = param(
        "s", "time of every pulse that is lost before the transistor conducts", low=0.0, high=1.0, default=0.0
    )
    smallest_pulse: Scalar = param(
        "s", "shortest time for which the transistor conducts", low=0.0, high=1.0, default=0.0
    )

    def closed_current(self, xp: Namespace, resistance: Scalar) -> Scalar:
        """Current [A] through an element of `resistance` [ohm] while the transistor conducts."""
        around = self.series_resistance + self.supply_resistance + self.on_resistance
        return xp.minimum(self.supply / (resistance + around), self.current_limit)

    def share(self, xp: Namespace, drive: Scalar, frequency: Scalar) -> Scalar:
        """Share of the time for which the transistor conducts, for a duty."""
        left = drive - self.dead_time * frequency
        made = xp.where(left < self.smallest_pulse * frequency, 0.0, xp.maximum(left, 0.0))
        return xp.where(drive < 1.0, made, 1.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Rms current [A] for a duty."""
        share = self.share(xp, drive, self.frequency)
        return xp.sqrt(share) * self.closed_current(xp, resistance)

    def reach(self, resistance: float) -> SignalRange:
        """A transistor conducts all the time at most."""
        return SignalRange(0.0, 1.0)
