"""ON/OFF control: full signal until a measured quantity reaches its target, then none.

    off if y ≥ r,     on if y < r - band,     else as before

with the target r, the reference, which may move. A late reading overshoots: with a delay t_d of
its sensor and a period T of sampling, what moves at the rate v does so by about v (t_d + T).

A quantity that falls when the signal is on is controlled with `high` below `low`.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.base.units import DIFFERENCE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH, MARGIN


@CONTROLLERS.register("on-off")
class OnOff(AbstractController):
    """A switch that keeps a measured quantity near its target."""

    band: Scalar = param(
        DIFFERENCE, "how far below the target it is switched on again", low=0.0, default=0.0, typical=MARGIN
    )
    high: Scalar = param(DRIVE, "signal while it is on", typical=HIGH)
    low: Scalar = param(DRIVE, "signal while it is off", default=0.0)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Off."""
        return (0.0,)

    def answer(
        self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """Signal of this sample, and whether it is on (1) or off (0)."""
        value, (before,) = readings[self.measured], memory
        kept = xp.where(value < reference, before, 0.0)
        on = xp.where(value < reference - self.band, 1.0, kept)
        return xp.where(on > 0.5, self.high, self.low), (on,)
