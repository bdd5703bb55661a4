"""A sag of the supply: its voltage falls to a share of what it should be.

The parameters of a source that are the voltage of its supply (`supplied_by`) are multiplied: the `supply` of a switch,
the `voltage_limit` of the other sources. A switch delivers less at once, by the square of the share. A source with a
limit feels the sag only as far as it needs the voltage, and not at all if no limit was given. A chamber has no supply.
"""

from __future__ import annotations

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.parameters import param, text
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.faults.plant import change_plant
from martensite.kernels.namespace import Flag, Namespace, Scalar


@FAULTS.register("supply-sag")
class SupplySag(AbstractFault):
    """A supply that gives way."""

    share: Scalar = param("1", "share of the voltage that is left", low=0.0, high=10.0, typical=0.7)
    drive: str = text("name of the drive; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        """The drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """The plant on less voltage."""
        left = xp.where(active, self.share, 1.0)

        def sagged(one: Actuator) -> dict[str, Scalar]:
            source = one.source
            return {f"source.{n}": source.value_of(n) * left for n in source.supplied_by}

        return change_plant(plant, self.drive, sagged)
