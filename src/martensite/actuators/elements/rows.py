"""Equal elements in a row: `count` of them, side by side or end to end.

One phase state and one temperature represent all. Of n side by side each carries 1/n of the force; of n end to end each
gives 1/n of the elongation. The wiring is independent: a wire led there and back pulls twice and is electrically one.
"""

from abc import abstractmethod
from typing import Any, Self

from martensite.actuators.elements.base import ELEMENTS, AbstractElement, Spring
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import Environment


class AbstractRow(AbstractLumped):
    """Equal elements; subclasses define the element and how the load is shared."""

    count: Number = param("1", "number of elements", low=1.0, high=1e4, typical=2.0)
    wiring: str = option("how they are wired", "series", "parallel", default="series")

    @property
    @abstractmethod
    def one(self) -> AbstractElement:
        """Return the repeated element."""

    def beside(self) -> Scalar:
        """Return the number of elements that share the force."""
        return 1.0

    def behind(self) -> Scalar:
        """Return the number of elements that share the elongation."""
        return 1.0

    @override
    def check(self) -> None:
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
    def law(self) -> AbstractLaw:  # pyrefly: ignore[bad-override]
        """Return the law of one."""
        return self.one.law

    @property
    def limits(self) -> ElementLimits:  # pyrefly: ignore[bad-override]
        """Return the limits of one."""
        return self.one.limits

    @property
    def wear(self) -> Wear | None:  # pyrefly: ignore[bad-override]
        """Return the wear of one."""
        return self._lumped.wear

    @override
    def apply_wear(self, xp: Namespace, worn: Any) -> Self:
        name = next(name for name, child in self.children() if child is self.one)
        return self if self.wear is None else self.rebuilt({name: self._lumped.apply_wear(xp, worn)})

    @property
    def straight(self) -> bool:  # pyrefly: ignore[bad-override]
        """Return whether one element is a straight wire."""
        return self.one.straight

    @property
    def passes(self) -> int:  # pyrefly: ignore[bad-override]
        """Return the iterations for force and tangent of one."""
        return self.one.passes

    @override
    def initial_fractions(self, xp: Namespace, stress: Scalar) -> Fractions:
        return self._lumped.initial_fractions(xp, stress)

    @override
    def heat_capacity_total(self) -> Scalar:
        return self.count * self.one.heat_capacity_total()

    @override
    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        return self.count * self._lumped.latent_heat_total(xp, stress, temperature)

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Return the heat flow to the environment [W]; each loses heat as if it were alone."""
        return self.count * self.one.heat_loss(xp, temperature, environment)

    @override
    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        share = force * (1.0 / self.beside())
        one = self._lumped.spring(xp, fractions, temperature, share)
        return Spring(self.behind() * one.free, one.compliance * (self.behind() / self.beside()))

    @override
    def elastic_energy_at(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> Scalar | None:
        share = force * (1.0 / self.beside())
        one = self._lumped.elastic_energy_at(xp, fractions, temperature, share)
        return None if one is None else self.count * one

    @override
    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        return self._lumped.stress(xp, force * (1.0 / self.beside()))

    @override
    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        return self._lumped.strain(xp, elongation * (1.0 / self.behind()))

    @override
    def ohms(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, rphase: Scalar = 0.0
    ) -> Scalar:
        one = self._lumped.ohms(xp, fraction, strain, temperature, rphase)
        return one * self.count if self.wiring == "series" else one * (1.0 / self.count)


@ELEMENTS.register("bundle")
class Bundle(AbstractRow):
    """Equal strands side by side.

        F = n F₁,   x = x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

    A wire led through a pulley and back is a bundle of two in series. Use `ribbon` for strands that warm each other.
    """

    strand: AbstractElement = part("one of the strands", ELEMENTS)

    @property
    @override
    def one(self) -> AbstractElement:
        return self.strand

    @override
    def beside(self) -> Scalar:
        return self.count


@ELEMENTS.register("chain")
class LinkChain(AbstractRow):
    """Equal links end to end.

        F = F₁,   x = n x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

    Links wired in parallel need 1/n of the voltage and n times the current.
    """

    link: AbstractElement = part("one of the links", ELEMENTS)

    @property
    @override
    def one(self) -> AbstractElement:
        return self.link

    @override
    def behind(self) -> Scalar:
        return self.count
