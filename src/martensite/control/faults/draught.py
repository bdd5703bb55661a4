"""A draught: the film coefficient of an element is multiplied, whatever its model.

A factor above 1 is a draught, one below 1 is air that is shut in: the dangerous one of the two.
"""

from __future__ import annotations

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.parameters import param, part, text
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.faults.plant import change_plant
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.thermal.base import AbstractCooling, Cylinder


class Multiplied(AbstractCooling):
    """A heat-loss model, multiplied."""

    cooling: AbstractCooling = part("the heat-loss model")
    factor: Scalar = param("1", "what it is multiplied by", low=0.0)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)], multiplied."""
        return self.factor * self.cooling.film(xp, temperature, ambient, shape)


@FAULTS.register("draught")
class Draught(AbstractFault):
    """Air that moves more, or less, than it should."""

    factor: Scalar = param("1", "film coefficient over that without the fault", low=0.0, high=1e3, typical=2.0)
    drive: str = text("drive of the actuator; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        """The drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """The plant with its film coefficients multiplied."""
        factor = xp.where(active, self.factor, 1.0)

        def blown(one: Actuator) -> dict[str, AbstractCooling]:
            times = Multiplied(cooling=one.environment.cooling, factor=1.0)
            return {"environment.cooling": times.rebuilt({"factor": factor})}

        return change_plant(plant, self.drive, blown)
