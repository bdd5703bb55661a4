"""Interface of an element to the system.

At frozen phase fractions and temperature an element is a spring with the tangent

    elongation = free + compliance · force

This is all a mechanism needs, for any law, shape or number of cells. An element advances through a step given its
heating and the force that the mechanism exerts on such a spring.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import InitVar, dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from martensite.actuators.elements.from_material import complete_from_material
from martensite.actuators.elements.limits import ElementLimits
from martensite.base.errors import ParameterError
from martensite.base.interfaces import make_missing_error
from martensite.base.parameters import Given, Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import map_tuples
from martensite.physics.electrical.base import AbstractSource, Heat
from martensite.physics.laws.base import AbstractLaw, Fork, Fractions
from martensite.physics.laws.coupling import StepReport
from martensite.physics.laws.surface_steps import SurfaceStep
from martensite.physics.materials.base import Material
from martensite.physics.thermal.base import Environment
from martensite.signals.moments import Moments

ELEMENTS: Registry[AbstractElement] = Registry("element", "martensite.actuators.elements", typical="wire")


class Spring(NamedTuple):
    """elongation = free + compliance · force, from the length at zero strain."""

    free: Scalar
    """Elongation at zero force [m]."""
    compliance: Scalar
    """Elongation per force [m/N]."""


class Effort(NamedTuple):
    """Force along a path: ∫ force d(way) is an energy [J]."""

    force: Scalar
    """[N], [N m], [V], or heat [J]."""
    way: Scalar
    """[m], [rad], [A s], or a fraction."""


class StoredHeat(NamedTuple):
    """Heat stored in an element."""

    sensible: Scalar
    """[J], up to a constant."""
    latent: tuple[Effort, ...]
    """Negative latent heat of the forward transformation [J] along the martensite fraction, for each part of the
    element.
    """


Pull = Callable[[Namespace, Spring], Scalar]
"""Force [N] at which a spring and the mechanism are in equilibrium."""


@dataclass(frozen=True)
class Heating:
    """Heating and cooling of an element during a step."""

    environment: Environment
    source: AbstractSource
    drive: Scalar | Moments
    """Constant signal of the source in its unit, or its moments in the step."""
    owed: Scalar = 0.0
    """Heat missing from the previous step [J]."""

    def heat(self, xp: Namespace, resistance: Scalar) -> Heat:
        """Return the power [W] in a resistance [ohm]."""
        if isinstance(self.drive, Moments):
            return self.source.heat(xp, self.drive, resistance)
        power = self.power_at(xp, self.drive, resistance)
        return Heat(power, 0.0, power)

    def power_at(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Return the power [W] in a resistance [ohm] under a constant drive signal."""
        return self.source.power(xp, drive, resistance)

    def ripple(self, xp: Namespace, resistance: Scalar, capacity: Scalar, dt: Scalar) -> Scalar:
        """Return the temperature [K] that mean heating over a step of dt [s] neglects."""
        if not isinstance(self.drive, Moments):
            return 0.0
        heat = self.heat(xp, resistance)
        return (heat.doubt * dt + heat.peak * self.drive.lapse) / capacity

    @property
    def temperature(self) -> Scalar | None:
        """Return the imposed temperature of the element [K]; None with a heat balance."""
        if not self.source.sets_temperature:
            return None
        return self.drive.mean if isinstance(self.drive, Moments) else self.drive


class Condition(NamedTuple):
    """Measurable condition of an element."""

    temperature: Scalar
    """Mean [K]."""
    hottest: Scalar
    """Maximum in the element [K]."""
    martensite_fraction: Scalar
    oriented_fraction: Scalar
    stress: Scalar
    """[Pa]"""
    strain: Scalar
    resistance: Scalar
    """[ohm]"""
    heat_loss: Scalar
    """[W]"""
    rphase_fraction: Scalar = 0.0


class CellProfile(NamedTuple):
    """Quantities along or across an element, one value per cell."""

    cell_temperature: Sequence[Scalar]
    """[K]"""
    cell_fraction: Sequence[Scalar]
    """Martensite fraction."""


class MaterialPoint(NamedTuple):
    """Load and phase state at a place in an element."""

    temperature: Scalar
    """[K]"""
    stress: Scalar
    """[Pa]"""
    martensite_fraction: Scalar
    oriented_fraction: Scalar
    kinks: tuple[Scalar, ...]
    """See `AbstractLaw.kinks`."""
    forks: tuple[Fork, ...] = ()
    """See `AbstractLaw.forks`."""


class AbstractElement(Parametrised):
    """Interface of an element: its `law`, its safety `limits`, and its state."""

    straight: ClassVar[bool] = True
    """False if its strain is not that of a straight wire."""
    passes: ClassVar[int] = 1
    """Iterations for force and tangent; 1 for an element that is linear in force."""

    law: Given[AbstractLaw] = NotImplemented
    """Stress–strain–temperature law."""
    limits: ElementLimits = NotImplemented
    """Limits of warnings."""

    material: InitVar[Material | str | Path | None] = None
    """Argument of every element, not a field: source of omitted values."""

    def __init__(self, *unnamed: Any, material: Material | str | Path | None = None, **values: Any) -> None:
        """Create an element from values in SI or texts with a unit.

        Args:
            unnamed: refused with a sentence.
            material: name or file of a material that supplies omitted values.
            values: declared fields by name; components can be given by name.
        """
        if material is not None:
            values = complete_from_material(type(self), material, values)
        super().__init__(*unnamed, **values)

    @abstractmethod
    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Any:
        """Return the initial state under `force` [N] and at `temperature` [K]."""

    @abstractmethod
    def tangent(self, xp: Namespace, state: Any, force: Scalar) -> Spring:
        """Return the element as a spring in a state, near a force [N]."""

    @abstractmethod
    def advance(self, xp: Namespace, state: Any, heating: Heating, pull: Pull, dt: Scalar) -> tuple[Any, StepReport]:
        """Return the state after a step of dt [s], and the report of the step."""

    @property
    def exchanges(self) -> bool:
        """Return True if it offers `advance_rosenbrock`, for a rate-dependent law."""
        return False

    @property
    def has_surface(self) -> bool:
        """Return True if it offers `advance_on_surface`, for a rate-independent law."""
        return False

    def advance_on_surface(
        self, xp: Namespace, state: Any, halves: Sequence[Heating], pull: Pull, dt: Scalar
    ) -> SurfaceStep:
        """Return the states of a step of order five of dt [s], from the heating of both halves."""
        raise make_missing_error(type(self), ["advance_on_surface"])

    def find_events(self, xp: Namespace, state: Any, temperature: Scalar, stress: Scalar) -> list[Scalar]:
        """Return the numbers of `AbstractLaw.kinks` at another temperature [K] and stress [Pa]."""
        raise make_missing_error(type(self), ["find_events"])

    def advance_rosenbrock(
        self, xp: Namespace, state: Any, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[Any, Any, Any]:
        """Return the states after a step of dt [s], in its middle, and after it to a lower order."""
        raise make_missing_error(type(self), ["advance_rosenbrock"])

    def warm_start(self, state: Any, solved: Any) -> Any:
        """Return the state with first guesses from `found`, the end of a previous step from it."""
        return state

    def rates(self, state: Any) -> list[Scalar]:
        """Return the state variables that are first guesses only: rates of the last step."""
        return []

    @abstractmethod
    def force(self, state: Any) -> Scalar:
        """Return the force at the end of the last step [N]."""

    def in_state(self, xp: Namespace, state: Any, fractions: Fractions, temperature: Scalar, force: Scalar) -> Any:
        """Return a state moved to other fractions, as an observer corrects it, under a force [N].

        Raises:
            ParameterError: the element has no single phase state and temperature [K].
        """
        raise ParameterError(
            f"Element `{self.registered_name}` is not the same all over: it cannot be put into "
            f"one phase state; use a lumped one, such as `wire`."
        )

    def elongation(self, xp: Namespace, state: Any, force: Scalar) -> Scalar:
        """Return the elongation [m] in a state under a force [N]."""
        spring = self.tangent(xp, state, force)
        return spring.free + spring.compliance * force

    @abstractmethod
    def condition(self, xp: Namespace, state: Any, force: Scalar, environment: Environment) -> Condition:
        """Return the measurable condition under a force [N]."""

    def profile(self, state: Any) -> CellProfile:
        """Return temperature and martensite fraction along the element; empty for a uniform element."""
        return CellProfile((), ())

    def places(self) -> list[float]:
        """Return the places of the profile [m]."""
        return []

    def points(self, xp: Namespace, state: Any) -> list[MaterialPoint]:
        """Return material points of about equal weight; empty for a rate-dependent law."""
        return []

    def heat_content(self, xp: Namespace, state: Any) -> Scalar | None:
        """Return the stored heat [J], up to a constant; None if it is not a function of the state."""
        return None

    def stored_heat(self, xp: Namespace, state: Any) -> StoredHeat | None:
        """Return the stored heat for any latent heat; None if not available."""
        return None

    def elastic_energy(self, xp: Namespace, state: Any) -> Scalar | None:
        """Return the energy [J] recovered by unloading at frozen fractions and temperature; None if not available."""
        return None

    @abstractmethod
    def heat_capacity_total(self) -> Scalar:
        """Return the heat capacity without transformation [J/K]."""

    @abstractmethod
    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Return the heat flow to the environment [W] at a uniform temperature."""


def points_of(xp: Namespace, law: AbstractLaw, memories: Sequence[Any]) -> list[MaterialPoint]:
    """Return material points from the memories of a law; empty for a rate-dependent law."""
    if law.rate_dependent:
        return []

    def point(m: Any) -> MaterialPoint:
        kinks, forks = tuple(law.kinks(xp, m)), tuple(law.forks(xp, m))
        return MaterialPoint(m.temperature, m.stress, *law.fractions(m)[:2], kinks, forks)

    return map_tuples(point, xp, memories)


def equilibrium_force(
    xp: Namespace, tangent: Callable[[Namespace, Scalar], Spring], pull: Pull, force: Scalar, passes: int
) -> Scalar:
    """Return the equilibrium force [N] of element and mechanism, from a force nearby by Newton's method."""
    for _ in range(passes):
        force = pull(xp, tangent(xp, force))
    return force
