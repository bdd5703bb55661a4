"""Constant power: in every period the duty is the demanded power over the largest one.

    D_k = P(t_k)/P_max,    P_max = U I/u

with voltage U and current I of the element, measured while the switch is closed (u = 1; under an averaged duty u both
go with √u). `every-period` takes the last measurement, so that the power is late by one period of change in
resistance. `once` always uses the first one, as in the paper on a finger prototype; the power is then wrong by
P_max(R)/P_max(R₀).

Nothing can be measured on an open switch: as long as there was no measurement the duty is
`probe` if any power is demanded, and after a period without a pulse the last measurement stays.
The duty is not limited: above 1 the demand is out of reach.

A loop over pulses: `simulate_loop(system, ConstantPower(...), ..., pulses=True)` with the drive
`pwm-voltage`, or a bench with `switching="pulses"`. Its average is the drive `power-pwm`.
"""

from collections.abc import Mapping

from martensite.base.parameters import Number, option, param, text
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CONTROLLERS.register("constant-power")
class ConstantPower(AbstractController):
    """Duty of a switch from a demanded power [W], its reference."""

    cites = ("finger-paper",)
    holds = False

    measured: str = text("name of the power that shall follow; it is not read", default="power")
    voltage: str = text("name of the reading of the voltage", default="voltage")
    current: str = text("name of the reading of the current", default="current")
    drive: str = text("name of the reading of the duty at which they are read", default="drive")
    updated: str = option(
        "when the largest power is measured: in `every-period`, or `once` before the run",
        "every-period",
        "once",
        default="every-period",
    )
    largest: Number = param(
        "W", "largest power, if it is measured once and that was done before; 0: it was not", low=0.0, default=0.0
    )
    probe: Number = param(DRIVE, "duty as long as nothing was measured", above=0.0, high=1.0, default=0.01)

    def reads(self) -> tuple[str, ...]:
        """Return the voltage, current and duty."""
        return self.voltage, self.current, self.drive

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        """Watt."""
        return "W"

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Return the largest power [W] as far as it is known; else 0."""
        return (self.largest if self.updated == "once" else 0.0,)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the duty of this sample, above 1 where the demand is out of reach; the largest power [W]."""
        (largest,), duty = memory, readings[self.drive]
        closed = duty > 0.0
        found = readings[self.voltage] * readings[self.current] / xp.where(closed, duty, 1.0)
        due = closed if self.updated == "every-period" else xp.both(closed, largest <= 0.0)
        largest = xp.where(due, found, largest)
        known = largest > 0.0
        asked = reference / xp.where(known, largest, 1.0)
        probe = xp.where(reference > 0.0, self.probe, 0.0)
        return xp.where(known, asked, probe), (largest,)
