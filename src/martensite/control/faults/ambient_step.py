"""A step of the surroundings: the air around an element is suddenly warmer or colder."""

from __future__ import annotations

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.parameters import param, text
from martensite.base.units import DEGREES
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.faults.plant import change_plant
from martensite.kernels.namespace import Flag, Namespace, Scalar


@FAULTS.register("ambient-step")
class AmbientStep(AbstractFault):
    """Surroundings that are warmer by some kelvin."""

    by: Scalar = param(DEGREES, "how much warmer; negative if colder", low=-200.0, high=500.0, typical="10 K")
    drive: str = text("drive of the actuator; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        """The drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """The plant in other surroundings."""
        more = xp.where(active, self.by, 0.0)

        def warmer(one: Actuator) -> dict[str, Scalar]:
            return {"environment.temperature": one.environment.temperature + more}

        return change_plant(plant, self.drive, warmer)
