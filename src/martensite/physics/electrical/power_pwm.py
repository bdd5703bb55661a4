"""Power by pulse-width modulation: the duty is the demanded power over the largest one.

    D = P_demand/P_max,   0 ≤ D ≤ 1,      P = D I_on² R,   I_on = U/(R + R_s)

P_max is measured as voltage times current of the element while the switch is closed. Measured in every period it is
I_on² R, and the element gets what is demanded. Measured once, at a resistance R₀, the power is wrong by the factor
P_max(R)/P_max(R₀): R₀/R without series resistance, R/R₀ where the current limit acts.

Averaged over the periods, which are taken to be short. The loop itself, with its sampling and
its pulses, is `martensite.control.controllers.constant_power`. Source: the power control of the
paper on
a finger prototype (section 5.1), which measures once, "prior to the experimental campaign". It
speaks of the difference of desired and maximum power; a duty is their ratio.
"""

from __future__ import annotations

import math
from typing import ClassVar

from martensite.base.errors import ParameterError
from martensite.base.parameters import option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSwitch, SignalRange


@SOURCES.register("power-pwm")
class PowerPwm(AbstractSwitch):
    """A demanded power, delivered by a switched constant voltage whose duty is computed."""

    cites = ("finger-paper",)
    unit: ClassVar[str] = "W"

    measured: str = option(
        "when the largest power is measured: in `every-period`, or `once` before the run",
        "every-period",
        "once",
        default="every-period",
    )
    reference_resistance: Scalar = param(
        "ohm", "resistance of the element when measured once", above=0.0, default=math.inf, typical="4 ohm"
    )

    def check(self) -> None:
        """Raise `ParameterError` if what was measured once is not given."""
        if self.measured == "once" and not math.isfinite(self.reference_resistance):
            raise ParameterError(
                "`power-pwm` with `measured` = `once` needs `reference_resistance` [ohm] "
                "(resistance of the element when measured once); none given."
            )

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Rms current [A] for a drive in watt."""
        known = self.reference_resistance if self.measured == "once" else resistance
        most = self.closed_current(xp, known)
        duty = xp.clip(drive / (most * most * known), 0.0, 1.0)
        return xp.sqrt(duty) * self.closed_current(xp, resistance)

    def reach(self, resistance: float) -> SignalRange:
        """Demands [W] that lead to a duty of at most 1."""
        known = self.reference_resistance if self.measured == "once" else resistance
        return SignalRange(0.0, self.largest_power(known))
