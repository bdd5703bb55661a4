"""An elastic element that a temperature shortens, and machines of it: for closed forms.

Elongation = free + compliance · force, with the free elongation -contraction · (T - 300 K). With a
source that sets the temperature, a drive of 300 K + x shortens it by `contraction · x`.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

from martensite.actuators.assembly import AbstractSystem, Actuator, Group, Machine
from martensite.actuators.elements.base import AbstractElement, Condition, Heating, Pull, Spring
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.laws.coupling import StepReport
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.table import Table

REST = 300.0
"""Temperature [K] at which nothing is shortened."""
SURROUNDINGS = Environment(temperature=REST, cooling=ConstantCooling(h=10.0))


class Warm(NamedTuple):
    """State of an elastic element."""

    temperature: Scalar
    pull: Scalar


class Elastic(AbstractElement):
    """A spring whose free length falls with temperature; not registered."""

    straight: ClassVar[bool] = False
    limits: ClassVar[ElementLimits] = ElementLimits()
    compliance: Number = param("m/N", "elongation per force", above=0.0, default=1e-4)
    contraction: Number = param("m/K", "shortening per temperature", low=0.0, default=1e-3)

    def tangent(self, xp: Namespace, state: Warm, force: Scalar) -> Spring:
        return Spring(-self.contraction * (state.temperature - REST), self.compliance)

    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Warm:
        return Warm(temperature, force)

    def force(self, state: Warm) -> Scalar:
        return state.pull

    def advance(self, xp: Namespace, state: Warm, heating: Heating, pull: Pull, dt: Scalar) -> tuple[Warm, StepReport]:
        drive: Any = heating.drive
        warm = state._replace(temperature=drive)
        return warm._replace(pull=pull(xp, self.tangent(xp, warm, 0.0))), StepReport(0.0, 0.0)

    def condition(self, xp: Namespace, state: Warm, force: Scalar, environment: Environment) -> Condition:
        elongation = self.elongation(xp, state, force)
        rest = (0.0, 0.0, force, elongation, 1.0, 0.0)
        return Condition(state.temperature, state.temperature, *rest)

    def heat_capacity_total(self) -> Scalar:
        return 1.0

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        return 0.1 * (temperature - environment.temperature)


def actuator(**changes: Any) -> Actuator:
    """An elastic element whose temperature is given."""
    element = Elastic(**changes)
    return Actuator(element=element, environment=SURROUNDINGS, source=PrescribedTemperature())


def machine(mechanism: AbstractMechanism, **changes: Any) -> Machine:
    """A mechanism with equal elastic elements at all of its ports."""
    members = {port: actuator(**changes) for port in mechanism.ports()}
    return Machine(mechanism=mechanism, group=Group(**members))


def kelvins(system: AbstractSystem, **shortened: float) -> dict[str, Table]:
    """Drives of elastic elements: within 1 s, those named get warmer by so many kelvin."""
    names = [drive.name for drive in system.drives() if drive.unit == "K"]
    return {
        name: Table(times=(0.0, 1.0, 1e3), values=(REST, *2 * (REST + shortened.get(name, 0.0),))) for name in names
    }
