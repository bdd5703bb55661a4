"""Constant power: in every period the duty cycle is the demanded power over the largest power.

    D_k = P(t_k)/P_max,    P_max = U I/u

U and I are the voltage and current of the element while the switch is closed (u = 1; under an averaged duty cycle u
both scale with √u). `every-period` uses the last measurement, so that changes of resistance act a period late. `once`
uses the first measurement, as in the paper on a finger prototype; the power is then wrong by P_max(R)/P_max(R₀).

An open switch allows no measurement: before the first measurement a demanded power gives the duty cycle `probe`, and
after a period without a pulse the last measurement stays. The duty cycle is not limited: above 1 the demand is out of
reach.

For pulses use `simulate_loop(system, ConstantPower(...), ..., pulses=True)` with the drive `pwm-voltage`, or a bench
with `switching="pulses"`. The drive `power-pwm` is the average.
"""

from collections.abc import Mapping

from martensite.base.parameters import Number, option, param, text
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CONTROLLERS.register("constant-power")
class ConstantPower(AbstractController):
    """Duty cycle of a switch from a demanded power [W], its reference."""

    cites = ("finger-paper",)
    holds = False

    measured: str = text("name of the controlled power; it is not read", default="power")
    voltage: str = text("name of the reading of the voltage", default="voltage")
    current: str = text("name of the reading of the current", default="current")
    drive: str = text("name of the reading of the duty cycle of the measurement", default="drive")
    updated: str = option(
        "when the largest power is measured: in `every-period`, or `once` before the run",
        "every-period",
        "once",
        default="every-period",
    )
    largest: Number = param(
        "W", "largest power, if it was measured once before the run; 0 otherwise", low=0.0, default=0.0
    )
    probe: Number = param(DRIVE, "duty cycle before the first measurement", above=0.0, high=1.0, default=0.01)

    def reads(self) -> tuple[str, ...]:
        return self.voltage, self.current, self.drive

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        return "W"

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        return (self.largest if self.updated == "once" else 0.0,)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        (largest,), duty = memory, readings[self.drive]
        closed = duty > 0.0
        power = readings[self.voltage] * readings[self.current] / xp.where(closed, duty, 1.0)
        due = closed if self.updated == "every-period" else xp.both(closed, largest <= 0.0)
        largest = xp.where(due, power, largest)
        measured = largest > 0.0
        demand = reference / xp.where(measured, largest, 1.0)
        probe = xp.where(reference > 0.0, self.probe, 0.0)
        return xp.where(measured, demand, probe), (largest,)
