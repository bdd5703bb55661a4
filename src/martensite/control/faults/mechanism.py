"""Faults of a mechanism with one element on a load line: slack in the element, and a slider that is stuck.

A load line sees the remaining elongation since assembly, e₀ - e. Slack s is subtracted from it:

    F = F(e₀ - s - e),   x = x(e₀ - s - e)

A slider that is clamped holds the elongation e_c, and the position, that it had when that began; the element then
pulls on what holds it, and cannot push:

    F = max[(e_c - free)/compliance, 0]
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.elements.base import AbstractElement, Spring
from martensite.actuators.mechanisms.base import Column, Load
from martensite.actuators.mechanisms.load_line import AbstractLoadLine, LoadLineReference
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, part
from martensite.control.faults.base import FAULTS, AbstractFault
from martensite.control.faults.plant import list_placed
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


class ClampReference(NamedTuple):
    """Memory of a load line that may be clamped."""

    elongation: Scalar
    """Elongation of the element at position zero [m]."""
    held: Scalar
    """Elongation when it was last free [m]."""
    position: Scalar
    """Position then [m]."""


class HinderedLoadLine(AbstractLoadLine):
    """A load line with slack in its element, behind a clamp that is open (0) or shut (1)."""

    line: AbstractLoadLine = part("the load line as it should be")
    slack: Number = param("m", "length that is lost", low=0.0)
    shut: Number = param("1", "1 if it is held, else 0", low=0.0, high=1.0)

    def start_force(self, xp: Namespace) -> Scalar:
        """Return the force at assembly without the fault [N]; the fault acts later."""
        return self.line.start_force(xp)

    def init(  # type: ignore[override]
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> ClampReference:
        """Return the memory at assembly, where the position is zero."""
        return ClampReference(elongations[0], elongations[0], 0.0)

    def force(self, xp: Namespace, assembly: Any, spring: Spring) -> Scalar:
        """Return the force [N] of the load line with what slack leaves, or of the clamp."""
        held = xp.maximum((assembly.held - spring.free) / spring.compliance, 0.0)
        return xp.where(self.shut > 0.5, held, self.line.force(xp, self._shorten(assembly), spring))

    def position(self, xp: Namespace, assembly: Any, force: Scalar, elongation: Scalar) -> Scalar:
        """Return the position [m] of the load line with what slack leaves, or where it is clamped."""
        free = self.line.position(xp, self._shorten(assembly), force, elongation)
        return xp.where(self.shut > 0.5, assembly.position, free)

    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], StepReport]:
        """Return a step of the element, and where it would be clamped after it."""
        _, (after,), report = super().advance(xp, memory, loads, signals, dt)
        element = loads[0].element
        force = element.force(after)
        elongation = element.elongation(xp, after, force)
        held = xp.where(self.shut > 0.5, memory.held, elongation)
        place = self.position(xp, memory, force, elongation)
        return ClampReference(memory.elongation, held, place), [after], report

    def _shorten(self, assembly: Any) -> LoadLineReference:
        return LoadLineReference(assembly.elongation - self.slack)


class AbstractMechanismFault(AbstractFault):
    """Interface of a fault of a mechanism that is a load line."""

    @abstractmethod
    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        """Return the parts that are exchanged in the load line."""

    def plant(self, xp: Namespace, plant: AbstractSystem, active: Flag) -> AbstractSystem:
        """Return the plant with the fault in its mechanism.

        Raises:
            ParameterError: the mechanism is not a load line of one element.
        """
        line = plant.mechanism
        if not isinstance(line, AbstractLoadLine):
            raise ParameterError(
                f"Fault `{self.registered_name}` is for a mechanism of one element on a load line, such as "
                f"`bias-spring`, not for `{line.registered_name}`."
            )
        own = line if isinstance(line, HinderedLoadLine) else HinderedLoadLine(line=line, slack=0.0, shut=0.0)
        path = next(path for path, one in list_placed(plant, "") if one is line)
        return plant.rebuilt({path.rstrip("."): own.rebuilt(self.hinder(xp, own, active))})


@FAULTS.register("slack")
class Slack(AbstractMechanismFault):
    """A wire that hangs through by some length, as when a crimp slips or the wire has grown for good."""

    length: Number = param("m", "length that is lost", above=0.0, typical="1 mm")

    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        """Return its slack."""
        return {"slack": line.slack + xp.where(active, self.length, 0.0)}


@FAULTS.register("clamped")
class Clamped(AbstractMechanismFault):
    """A mechanism that is stuck where it was: no stroke, whatever the element does."""

    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        """Return its clamp."""
        return {"shut": xp.maximum(line.shut, xp.where(active, 1.0, 0.0))}
