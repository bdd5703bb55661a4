"""A relay of two levels: full signal far below the target, less signal near it, then none.

    u = u_H   if e ≥ φ
        u_L   if 0 < e < φ
        u_0   if e ≤ 0,            e = r - y

Near the target the lower level brings the element there slowly, so that a relay, whose signal
never settles, swings less about it. The switching is without memory: it chatters at the rate at
which it is sampled. With `sign` = -1 it acts on -e: the second of two elements that pull against
each other gets the same controller with the other sign, and is off while the first is on.

Source: the variable structure control of Grant and Hayward (1997) for two antagonistic groups of
fibres, where u_H and u_L are currents; original not seen.
"""

from __future__ import annotations

from martensite.base.errors import ParameterError
from martensite.base.parameters import option, param
from martensite.base.units import DIFFERENCE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH, MARGIN, NEAR


@CONTROLLERS.register("two-level")
class TwoLevel(AbstractController):
    """A relay with a full and a reduced level."""

    cites = ("grant1997",)

    far: Scalar = param(DIFFERENCE, "error φ from which it is full", above=0.0, typical=MARGIN)
    high: Scalar = param(DRIVE, "signal u_H far from the target", typical=HIGH)
    near: Scalar = param(DRIVE, "signal u_L near it", typical=NEAR)
    low: Scalar = param(DRIVE, "signal u_0 at the target and beyond", default=0.0)
    sign: str = option("sign of the errors that it acts on", "1", "-1", default="1")

    def check(self) -> None:
        """Raise `ParameterError` unless the level near the target lies between the others."""
        least, most = sorted((self.low, self.high))
        if not least <= self.near <= most:
            raise ParameterError(
                f"The level `near` of a two-level relay must be between {least:g} and {most:g}, but is {self.near:g}."
            )

    def answer(
        self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """The signal of this sample."""
        error = reference - readings[self.measured]
        error = error if self.sign == "1" else -error
        on = xp.where(error >= self.far, self.high, self.near)
        return xp.where(error > 0.0, on, self.low), ()
