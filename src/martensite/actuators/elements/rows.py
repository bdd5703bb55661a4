"""Equal elements in a row: `count` of them, side by side or end to end.

All are alike and heated alike, so one phase state and one temperature stand for all. With n side by side each carries
the n-th part of the force; with n end to end each gives the n-th part of the elongation. How they are wired is another
matter: a wire led there and back pulls twice and is electrically one.
"""

from abc import abstractmethod
from typing import Any, Self

from martensite.actuators.elements.base import ELEMENTS, AbstractElement, Spring
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import Environment


class AbstractRow(AbstractLumped):
    """Equal elements; a subclass names one of them and says how they share the load."""

    count: Number = param("1", "number of elements", low=1.0, high=1e4, typical=2.0)
    wiring: str = option("how they are wired", "series", "parallel", default="series")

    @property
    @abstractmethod
    def one(self) -> AbstractElement:
        """One of them."""

    def beside(self) -> Scalar:
        """Return the number of elements that share the force."""
        return 1.0

    def behind(self) -> Scalar:
        """Return the number of elements that share the elongation."""
        return 1.0

    def check(self) -> None:
        """Raise `ParameterError` unless a whole number of lumped elements is meant."""
        owner = self.registered_name
        if self.count != round(self.count):
            raise ParameterError(f"Parameter `count` of `{owner}` must be a whole number, but is {self.count:g}.")
        if not (isinstance(self.one, AbstractLumped) and self.one.uniform):
            raise ParameterError(
                f"A `{owner}` takes elements of one phase state, such as `wire`, but "
                f"`{self.one.registered_name}` has many."
            )

    @property
    def _lumped(self) -> AbstractLumped:
        if not isinstance(self.one, AbstractLumped):
            raise TypeError(type(self.one).__name__)
        return self.one

    @property
    def law(self) -> AbstractLaw:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the law of one."""
        return self.one.law

    @property
    def limits(self) -> ElementLimits:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the limits of one."""
        return self.one.limits

    @property
    def wear(self) -> Wear | None:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the wear of one."""
        return self._lumped.wear

    def apply_wear(self, xp: Namespace, worn: Any) -> Self:
        """With each as it is worn."""
        name = next(name for name, child in self.children() if child is self.one)
        return self if self.wear is None else self.rebuilt({name: self._lumped.apply_wear(xp, worn)})

    @property
    def straight(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return whether one element is a straight wire."""
        return self.one.straight

    @property
    def passes(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the turns in which the force is fitted, of one."""
        return self.one.passes

    def initial_fractions(self, xp: Namespace, stress: Scalar) -> Fractions:
        """Return the phase state at the start, under a stress [Pa]."""
        return self._lumped.initial_fractions(xp, stress)

    def heat_capacity_total(self) -> Scalar:
        """Return the heat capacity without transformation [J/K]."""
        return self.count * self.one.heat_capacity_total()

    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the heat released by the whole forward transformation [J] at (stress, temperature)."""
        return self.count * self._lumped.latent_heat_total(xp, stress, temperature)

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Return the heat flow to the environment [W]; each loses as if it were alone."""
        return self.count * self.one.heat_loss(xp, temperature, environment)

    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        """Return all together as a spring, near a force [N]."""
        share = force * (1.0 / self.beside())
        one = self._lumped.spring(xp, fractions, temperature, share)
        return Spring(self.behind() * one.free, one.compliance * (self.behind() / self.beside()))

    def elastic_energy_at(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> Scalar | None:
        """Return the elastic energy of all [J] under a force [N]."""
        share = force * (1.0 / self.beside())
        one = self._lumped.elastic_energy_at(xp, fractions, temperature, share)
        return None if one is None else self.count * one

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Return the stress [Pa] in each."""
        return self._lumped.stress(xp, force * (1.0 / self.beside()))

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Return the strain [-] of each."""
        return self._lumped.strain(xp, elongation * (1.0 / self.behind()))

    def ohms(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, rphase: Scalar = 0.0
    ) -> Scalar:
        """Return the resistance [ohm] of all as wired."""
        one = self._lumped.ohms(xp, fraction, strain, temperature, rphase)
        return one * self.count if self.wiring == "series" else one * (1.0 / self.count)


@ELEMENTS.register("bundle")
class Bundle(AbstractRow):
    """Equal strands side by side.

        F = n F₁,   x = x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

    A wire led through a pulley and back is a bundle of two in series. Strands that stand so close that they warm each
    other are no bundle but a `ribbon`.
    """

    strand: AbstractElement = part("one of the strands", ELEMENTS)

    @property
    def one(self) -> AbstractElement:
        """Return the strand."""
        return self.strand

    def beside(self) -> Scalar:
        """Return every strand carries its part of the force."""
        return self.count


@ELEMENTS.register("chain")
class LinkChain(AbstractRow):
    """Equal links end to end.

        F = F₁,   x = n x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

    Links wired in parallel need the n-th part of the voltage and n times the current.
    """

    link: AbstractElement = part("one of the links", ELEMENTS)

    @property
    def one(self) -> AbstractElement:
        """Return the link."""
        return self.link

    def behind(self) -> Scalar:
        """Every link gives its part of the elongation."""
        return self.count
