"""Faults of a mechanism with one element on a load line: slack in the element, and a stuck slider.

A load line sees the remaining elongation since assembly, e₀ - e. Slack s is subtracted from it:

    F = F(e₀ - s - e),   x = x(e₀ - s - e)

A clamped slider holds its position and the elongation e_c of the time when it was clamped; the element then pulls on
the clamp and cannot push:

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
    """Last elongation before the clamp shut [m]."""
    position: Scalar
    """Position at this elongation [m]."""


class HinderedLoadLine(AbstractLoadLine):
    """A load line with slack in its element, and a clamp that is open (0) or shut (1)."""

    line: AbstractLoadLine = part("the load line as it should be")
    slack: Number = param("m", "length that is lost", low=0.0)
    shut: Number = param("1", "1 if it is held, else 0", low=0.0, high=1.0)

    def start_force(self, xp: Namespace) -> Scalar:
        return self.line.start_force(xp)

    def init(  # type: ignore[override]
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> ClampReference:
        return ClampReference(elongations[0], elongations[0], 0.0)

    def force(self, xp: Namespace, assembly: Any, spring: Spring) -> Scalar:
        clamped = xp.maximum((assembly.held - spring.free) / spring.compliance, 0.0)
        return xp.where(self.shut > 0.5, clamped, self.line.force(xp, self._shorten(assembly), spring))

    def position(self, xp: Namespace, assembly: Any, force: Scalar, elongation: Scalar) -> Scalar:
        free = self.line.position(xp, self._shorten(assembly), force, elongation)
        return xp.where(self.shut > 0.5, assembly.position, free)

    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], StepReport]:
        _, (after,), report = super().advance(xp, memory, loads, signals, dt)
        element = loads[0].element
        force = element.force(after)
        elongation = element.elongation(xp, after, force)
        clamped = xp.where(self.shut > 0.5, memory.held, elongation)
        place = self.position(xp, memory, force, elongation)
        return ClampReference(memory.elongation, clamped, place), [after], report

    def _shorten(self, assembly: Any) -> LoadLineReference:
        return LoadLineReference(assembly.elongation - self.slack)


class AbstractMechanismFault(AbstractFault):
    """Interface of a fault of a mechanism that is a load line."""

    @abstractmethod
    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        """Return the parts of the load line that the fault replaces."""

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
        hindered = line if isinstance(line, HinderedLoadLine) else HinderedLoadLine(line=line, slack=0.0, shut=0.0)
        path = next(path for path, one in list_placed(plant, "") if one is line)
        return plant.rebuilt({path.rstrip("."): hindered.rebuilt(self.hinder(xp, hindered, active))})


@FAULTS.register("slack")
class Slack(AbstractMechanismFault):
    """Slack of a wire, for example after a crimp slips or the wire creeps."""

    length: Number = param("m", "length that is lost", above=0.0, typical="1 mm")

    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        return {"slack": line.slack + xp.where(active, self.length, 0.0)}


@FAULTS.register("clamped")
class Clamped(AbstractMechanismFault):
    """A stuck mechanism without stroke."""

    def hinder(self, xp: Namespace, line: HinderedLoadLine, active: Flag) -> dict[str, Scalar]:
        return {"shut": xp.maximum(line.shut, xp.where(active, 1.0, 0.0))}
