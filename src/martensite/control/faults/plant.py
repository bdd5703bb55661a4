"""Faults of a plant, or of the driver before it: its twin in which parts of actuators are exchanged."""

from abc import abstractmethod
from collections.abc import Iterator
from typing import Any

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, Parametrised, param, part, text
from martensite.base.units import DEGREES
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.thermal.base import AbstractCooling, Cylinder
from martensite.signals.base import DRIVE


def list_placed(part: Parametrised, prefix: str) -> Iterator[tuple[str, Parametrised]]:
    """List the parts below a part with the prefix of their paths, including the dot; the whole first."""
    yield prefix, part
    for name, child in part.children():
        yield from list_placed(child, f"{prefix}{name}.")


class AbstractPlantFault(AbstractFault):
    """Interface of a fault of the actuator of one drive, or of all of them."""

    drive: str = text("drive of the actuator; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        """Return the drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    @abstractmethod
    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the parts that are exchanged in an actuator, by path, such as `source.supply`."""

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """Return the plant with the fault in it; its numbers may be traced.

        Raises:
            ParameterError: the drive is that of a mechanism, not of an actuator.
        """
        at = {plant.drive_at(port): one for port, one in plant.actuators().items()}
        if self.drive and self.drive not in at:
            raise ParameterError(
                f"A fault of an actuator needs the drive of one, not `{self.drive}`. {suggest_name(self.drive, at)}"
            )
        places = {id(one): prefix for prefix, one in list_placed(plant, "")}
        found: dict[str, Any] = {}
        for name, one in at.items():
            if self.drive in ("", name):
                found |= {places[id(one)] + path: value for path, value in self.exchange(xp, one, active).items()}
        return plant.rebuilt(found)


@FAULTS.register("ambient-step")
class AmbientStep(AbstractPlantFault):
    """Surroundings that are warmer by some kelvin."""

    by: Number = param(DEGREES, "how much warmer; negative if colder", low=-200.0, high=500.0, typical="10 K")

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the temperature around it."""
        return {"environment.temperature": one.environment.temperature + xp.where(active, self.by, 0.0)}


class Multiplied(AbstractCooling):
    """A heat-loss model, multiplied."""

    cooling: AbstractCooling = part("the heat-loss model")
    factor: Number = param("1", "what it is multiplied by", low=0.0)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)], multiplied."""
        return self.factor * self.cooling.film(xp, temperature, ambient, shape)

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        """Return the pumped heat [W] as without the fault: a draught does not change it."""
        return self.cooling.pump_heat(xp, temperature, ambient, shape)


@FAULTS.register("draught")
class Draught(AbstractPlantFault):
    """Air that moves more, or less, than it should.

    A factor above 1 is a draught, one below 1 is air that is shut in: the dangerous one of the two.
    """

    factor: Number = param("1", "film coefficient over that without the fault", low=0.0, high=1e3, typical=2.0)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return its film coefficient, multiplied."""
        times = Multiplied(cooling=one.environment.cooling, factor=1.0)
        return {"environment.cooling": times.rebuilt({"factor": xp.where(active, self.factor, 1.0)})}


class AbstractContact(AbstractSource):
    """Interface of a source behind a contact."""

    source: AbstractSource = part("the source")

    @property
    def sets_temperature(self) -> bool:  # type: ignore[override]
        """Return whether the source sets the temperature; a chamber has no circuit."""
        return self.source.sets_temperature

    @property
    def supplied_by(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the parameters of the source that are its supply: a fault of that still finds them."""
        return tuple(f"source.{name}" for name in self.source.supplied_by)


class Interrupted(AbstractContact):
    """A source behind a contact that is closed (1) or open (0)."""

    contact: Number = param("1", "1 if it is closed, 0 if it is open", low=0.0, high=1.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the current [A] of the source, if the contact is closed."""
        return self.contact * self.source.current(xp, drive, resistance)

    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the current of the supply [A]."""
        return self.contact * self.source.supply_current(xp, drive, resistance)


@FAULTS.register("open-circuit")
class OpenCircuit(AbstractPlantFault):
    """A broken circuit.

    What the source does is as before; the element gets nothing of it and cools. Its force and length are left as they
    are: it is the electrical circuit that is open, as at a crimp or a plug. A fault that ends is a loose contact.
    """

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the source, behind an open contact."""
        behind = Interrupted(source=one.source, contact=1.0)
        return {"source": behind.rebuilt({"contact": xp.where(active, 0.0, 1.0)})}


class Resisted(AbstractContact):
    """A source behind a contact that has a resistance."""

    contact: Number = param("ohm", "resistance of the contact", low=0.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the current [A] through the element and the contact in a row."""
        return self.source.current(xp, drive, resistance + self.contact)

    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the current of the supply [A]."""
        return self.source.supply_current(xp, drive, resistance + self.contact)


@FAULTS.register("contact-resistance")
class ContactResistance(AbstractPlantFault):
    """A crimp or a plug that has got a resistance, in a row with the element.

    A source of voltage delivers less, one of current the same; what the contact takes does not heat the element. The
    meter measures only the element, as with separate leads.
    """

    resistance: Number = param("ohm", "resistance of the contact", low=0.0, high=1e6, typical="1 ohm")

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the source, behind a contact with a resistance."""
        behind = Resisted(source=one.source, contact=0.0)
        return {"source": behind.rebuilt({"contact": xp.where(active, self.resistance, 0.0)})}


@FAULTS.register("stuck-on")
class StuckOn(AbstractFault):
    """A switch or a driver that ignores its command and gives a fixed signal.

    Such as a transistor that has failed closed. It stands behind the supervisor: what a guard decides does not arrive,
    and only a second switch in the supply can cut.
    """

    drive: str = text("drive that does not obey; all drives if empty", default="")
    level: Number = param(DRIVE, "signal that arrives whatever is wanted", default=1.0, typical=1.0)

    def names(self) -> dict[str, str]:
        """Return the drive, if one is named."""
        return {self.drive: "drive"} if self.drive else {}

    def signal(self, xp: Namespace, drive: str, signal: Scalar, active: Flag) -> Scalar:
        """Return the fixed signal of the fault."""
        return xp.where(active, self.level, signal) if self.drive in ("", drive) else signal


@FAULTS.register("supply-sag")
class SupplySag(AbstractPlantFault):
    """A supply that gives way.

    The parameters of a source that are the voltage of its supply (`supplied_by`) are multiplied: the `supply` of a
    switch, the `voltage_limit` of the other sources. A switch delivers less at once, by the square of the share. A
    source with a limit feels the sag only as far as it needs the voltage, and not at all if no limit was given. A
    chamber has no supply.
    """

    share: Number = param("1", "share of the voltage that is left", low=0.0, high=10.0, typical=0.7)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the voltage of its supply."""
        return _scale_supply(xp, one, self.share, active)


@FAULTS.register("supply-surge")
class SupplySurge(AbstractPlantFault):
    """A supply whose voltage is too high, as from a charger or a regulator that has failed.

    The same parameters as of a sag are multiplied. A switch delivers the square of the share: more than a bound on the
    temperature was told (`martensite.control.checks.thermal_bound`), so that only what is measured reveals it.
    """

    share: Number = param("1", "voltage over that without the fault", low=1.0, high=10.0, typical=1.3)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the voltage of its supply."""
        return _scale_supply(xp, one, self.share, active)


def _scale_supply(xp: Namespace, one: Actuator, share: Scalar, active: Flag) -> dict[str, Any]:
    """Return the parameters that are the voltage of a supply, multiplied."""
    left = xp.where(active, share, 1.0)
    return {f"source.{n}": one.source.value_of(n) * left for n in one.source.supplied_by}
