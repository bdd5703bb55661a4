"""Faults of a plant or of its driver: the plant with parts of its actuators replaced."""

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
    """Yield the part and all parts below it, each with the prefix of its path, including the dot."""
    yield prefix, part
    for name, child in part.children():
        yield from list_placed(child, f"{prefix}{name}.")


class AbstractPlantFault(AbstractFault):
    """Interface of a fault of the actuator of one drive, or of all actuators."""

    drive: str = text("drive of the actuator; all actuators if empty", default="")

    def names(self) -> dict[str, str]:
        return {self.drive: "drive"} if self.drive else {}

    @abstractmethod
    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        """Return the replaced parts of an actuator by path, such as `source.supply`."""

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """Return the plant with the fault; its values may be traced.

        Raises:
            ParameterError: the drive does not belong to an actuator.
        """
        at = {plant.drive_at(port): one for port, one in plant.actuators().items()}
        if self.drive and self.drive not in at:
            raise ParameterError(
                f"A fault of an actuator needs the drive of one, not `{self.drive}`. {suggest_name(self.drive, at)}"
            )
        places = {id(one): prefix for prefix, one in list_placed(plant, "")}
        replaced: dict[str, Any] = {}
        for name, one in at.items():
            if self.drive in ("", name):
                replaced |= {places[id(one)] + path: value for path, value in self.exchange(xp, one, active).items()}
        return plant.rebuilt(replaced)


@FAULTS.register("ambient-step")
class AmbientStep(AbstractPlantFault):
    """Step of the ambient temperature."""

    by: Number = param(DEGREES, "how much warmer; negative if colder", low=-200.0, high=500.0, typical="10 K")

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        return {"environment.temperature": one.environment.temperature + xp.where(active, self.by, 0.0)}


class ScaledCooling(AbstractCooling):
    """A heat-loss model with a multiplied film coefficient."""

    cooling: AbstractCooling = part("the heat-loss model")
    factor: Number = param("1", "factor of the film coefficient", low=0.0)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        return self.factor * self.cooling.film(xp, temperature, ambient, shape)

    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        return self.cooling.pump_heat(xp, temperature, ambient, shape)


@FAULTS.register("draught")
class Draught(AbstractPlantFault):
    """Air that moves faster or slower than in the model.

    A factor above 1 is a draught, a factor below 1 is enclosed air, which is the more dangerous case.
    """

    factor: Number = param("1", "film coefficient over that without the fault", low=0.0, high=1e3, typical=2.0)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        times = ScaledCooling(cooling=one.environment.cooling, factor=1.0)
        return {"environment.cooling": times.rebuilt({"factor": xp.where(active, self.factor, 1.0)})}


class AbstractContact(AbstractSource):
    """Interface of a source behind a contact."""

    source: AbstractSource = part("the source")

    @property
    def sets_temperature(self) -> bool:  # type: ignore[override]
        return self.source.sets_temperature

    @property
    def supplied_by(self) -> tuple[str, ...]:  # type: ignore[override]
        return tuple(f"source.{name}" for name in self.source.supplied_by)


class SwitchingContact(AbstractContact):
    """A source behind a contact that is closed (1) or open (0)."""

    contact: Number = param("1", "1 if it is closed, 0 if it is open", low=0.0, high=1.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self.contact * self.source.current(xp, drive, resistance)

    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self.contact * self.source.supply_current(xp, drive, resistance)


@FAULTS.register("open-circuit")
class OpenCircuit(AbstractPlantFault):
    """A broken electrical circuit, as at a crimp or plug.

    The element gets no power and cools; its force and length are unchanged. A fault that ends is a loose contact.
    """

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        behind = SwitchingContact(source=one.source, contact=1.0)
        return {"source": behind.rebuilt({"contact": xp.where(active, 0.0, 1.0)})}


class ResistiveContact(AbstractContact):
    """A source behind a contact with a resistance."""

    contact: Number = param("ohm", "resistance of the contact", low=0.0)

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self.source.current(xp, drive, resistance + self.contact)

    def supply_current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        return self.source.supply_current(xp, drive, resistance + self.contact)


@FAULTS.register("contact-resistance")
class ContactResistance(AbstractPlantFault):
    """Resistance of a crimp or plug in series with the element.

    A voltage source delivers less power, a current source the same. The heat of the contact does not heat the element.
    The meter measures the element alone, as with separate leads.
    """

    resistance: Number = param("ohm", "resistance of the contact", low=0.0, high=1e6, typical="1 ohm")

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        behind = ResistiveContact(source=one.source, contact=0.0)
        return {"source": behind.rebuilt({"contact": xp.where(active, self.resistance, 0.0)})}


@FAULTS.register("stuck-on")
class StuckOn(AbstractFault):
    """A switch or driver that ignores its command and gives a fixed signal, such as a shorted transistor.

    It acts behind the supervisor: only a second switch in the supply could cut it.
    """

    drive: str = text("drive that does not obey; all drives if empty", default="")
    level: Number = param(DRIVE, "signal that arrives at the source", default=1.0, typical=1.0)

    def names(self) -> dict[str, str]:
        return {self.drive: "drive"} if self.drive else {}

    def signal(self, xp: Namespace, drive: str, signal: Scalar, active: Flag) -> Scalar:
        return xp.where(active, self.level, signal) if self.drive in ("", drive) else signal


@FAULTS.register("supply-sag")
class SupplySag(AbstractPlantFault):
    """A supply voltage that is too low.

    The supply parameters of the source (`supplied_by`) are multiplied: `supply` of a switch, `voltage_limit` of other
    sources. The power of a switch falls with the square of the fraction. A source with a limit is affected only where
    it needs the voltage, and not without a limit. A chamber has no supply.
    """

    share: Number = param("1", "fraction of the voltage that is left", low=0.0, high=10.0, typical=0.7)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        return _scale_supply(xp, one, self.share, active)


@FAULTS.register("supply-surge")
class SupplySurge(AbstractPlantFault):
    """A supply voltage that is too high, for example from a failed regulator.

    It multiplies the same parameters as `supply-sag`. The power of a switch rises with the square of the factor and may
    exceed the power that a `thermal-bound` assumes; only measurements reveal it.
    """

    share: Number = param("1", "voltage over that without the fault", low=1.0, high=10.0, typical=1.3)

    def exchange(self, xp: Namespace, one: Actuator, active: Flag) -> dict[str, Any]:
        return _scale_supply(xp, one, self.share, active)


def _scale_supply(xp: Namespace, one: Actuator, share: Scalar, active: Flag) -> dict[str, Any]:
    left = xp.where(active, share, 1.0)
    return {f"source.{n}": one.source.value_of(n) * left for n in one.source.supplied_by}
