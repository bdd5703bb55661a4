"""An open circuit: the wire or its crimp is broken, and no current flows.

What the source does is as before; the element gets nothing of it and cools. Its force and length are left as they are:
it is the electrical circuit that is open, as at a crimp or a plug. A fault that ends is a loose contact.
"""

from __future__ import annotations

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.parameters import param, part, text
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.faults.plant import change_plant
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.electrical.base import AbstractSource


class Interrupted(AbstractSource):
    """A source behind a contact that is closed (1) or open (0)."""

    source: AbstractSource = part("the source")
    contact: Scalar = param("1", "1 if it is closed, 0 if it is open", low=0.0, high=1.0)

    @property
    def sets_temperature(self) -> bool:  # type: ignore[override]
        """As the source: a chamber has no circuit."""
        return self.source.sets_temperature

    @property
    def supplied_by(self) -> tuple[str, ...]:  # type: ignore[override]
        """Parameters of the source that are its supply: a fault of that still finds them."""
        return tuple(f"source.{name}" for name in self.source.supplied_by)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Current [A] of the source, if the contact is closed."""
        return self.contact * self.source.current(xp, drive, resistance)


@FAULTS.register("open-circuit")
class OpenCircuit(AbstractFault):
    """A broken circuit."""

    drive: str = text("name of the drive; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        """The drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """The plant with an open contact."""
        contact = xp.where(active, 0.0, 1.0)

        def opened(one: Actuator) -> dict[str, AbstractSource]:
            behind = Interrupted(source=one.source, contact=1.0)
            return {"source": behind.rebuilt({"contact": contact})}

        return change_plant(plant, self.drive, opened)
