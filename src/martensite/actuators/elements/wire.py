"""Straight wire at nominal size: stress = force/section, strain = elongation/length."""

import math
from abc import abstractmethod
from typing import Any, Self

from martensite.actuators.elements.base import ELEMENTS, AbstractElement, Spring
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import FROM_MATERIAL, Given, Number, option, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import RESISTANCES, AbstractResistance, Conductor
from martensite.physics.electrical.resistances import RESISTIVITY, PerLengthResistance, describe_contradiction
from martensite.physics.laws.base import LAWS, AbstractLaw, Fractions
from martensite.physics.laws.wear import Wear
from martensite.physics.thermal.base import Cylinder, Environment
from martensite.physics.thermal.ends import ENDS, AbstractEnds, AdiabaticEnds


class AbstractRoundWire(AbstractElement):
    """Element made of a round wire; subclasses define its length.

    Mass, heat capacity, latent heat, resistance and heat loss are those of the wire of diameter d and length l at
    nominal size. The lateral surface π d l loses heat, and clamped ends as well.
    """

    diameter: Number = param("m", "wire diameter", above=0.0, high=0.02, typical="0.2 mm")
    density: Number = param("kg/m^3", "density", above=0.0, high=3e4, default=FROM_MATERIAL, typical="6450 kg/m^3")
    heat_capacity: Number = param(
        "J/kg/K", "specific heat capacity", above=0.0, high=1e4, default=FROM_MATERIAL, typical="500 J/kg/K"
    )
    latent_heat: Number = param(
        "J/kg", "latent heat of the whole transformation", low=0.0, high=1e6, default=0.0, typical="24 J/g"
    )
    initial_fraction: Number = param(
        "1", "martensite fraction at the start, or less if the law keeps less there", low=0.0, high=1.0, default=1.0
    )
    initial_oriented: Number = param("1", "oriented share of the initial martensite", low=0.0, high=1.0, default=1.0)
    initial: str = option(
        "how its martensite is oriented: as in a wire that was cooled under the force at the start "
        "before, or wholly; of that `initial_oriented` is a share",
        "trained",
        "oriented",
        default="trained",
    )
    law: Given[AbstractLaw] = part("stress–strain–temperature law", LAWS, default=FROM_MATERIAL)
    resistance: Given[AbstractResistance] = part("resistance model", RESISTANCES, default=FROM_MATERIAL)
    ends: AbstractEnds = part("what the ends lose", ENDS, default=AdiabaticEnds())
    limits: ElementLimits = part("safety limits", default=ElementLimits())
    wear: Wear | None = part("what cycles change in it; nothing if left out", default=None)

    @abstractmethod
    def wire_length(self) -> Scalar:
        """Return the length of the wire [m]."""

    @override
    def check(self) -> None:
        if self.initial_oriented < 1.0 and not self.law.has_twins:
            raise ParameterError(
                f"Parameter `initial_oriented` of `{self.registered_name}` must be 1 with law "
                f"`{self.law.registered_name}`, which knows oriented martensite only, but is "
                f"{self.initial_oriented:.6g}; try law `brinson`."
            )
        if self.wear is not None:
            self.wear.check_law(self.law)

    def apply_wear(self, xp: Namespace, worn: Any) -> Self:
        """Return the worn element."""
        if self.wear is None:
            return self
        return self.rebuilt({"wear": None, "law": self.wear.apply(xp, self.law, worn)})

    def initial_fractions(self, xp: Namespace, stress: Scalar) -> Fractions:
        """Return the initial phase state under a stress [Pa]."""
        oriented = self.initial_fraction * self.initial_oriented
        if self.initial == "trained":
            oriented = oriented * self.law.trained_share(xp, stress)
        return Fractions(self.initial_fraction, oriented)

    def section(self) -> Scalar:
        """Return the cross-section of the wire [m²]."""
        return 0.25 * math.pi * self.diameter * self.diameter

    def cylinder(self) -> Cylinder:
        """Return the cylinder that loses heat through its lateral surface."""
        return Cylinder(self.diameter, self.wire_length())

    def surface(self) -> Scalar:
        """Return the lateral surface of the wire [m²]."""
        return math.pi * self.cylinder().diameter * self.wire_length()

    def mass(self) -> Scalar:
        """Return the mass [kg]."""
        return self.density * self.section() * self.wire_length()

    @override
    def heat_capacity_total(self) -> Scalar:
        return self.mass() * self.heat_capacity

    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the heat of the whole forward transformation [J] at (stress, temperature)."""
        latent = self.density * self.latent_heat
        heat = self.law.heat(xp, latent, stress, temperature)
        return heat * self.section() * self.wire_length()

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Return conductance · (T - T_a) plus pumped heat [W]; the conductance is h(T) S with adiabatic ends."""
        ambient, shape = environment.temperature, self.cylinder()
        film = environment.cooling.film(xp, temperature, ambient, shape)
        lost = self.ends.conductance(xp, film, shape) * (temperature - ambient)
        pumped = environment.cooling.pump_heat(xp, temperature, ambient, shape)
        return lost if pumped is None else lost + pumped

    def ohms(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, rphase: Scalar = 0.0
    ) -> Scalar:
        """Return the resistance [ohm]."""
        shape = Conductor(self.section(), self.wire_length())
        if self.law.has_rphase:
            return self.resistance.mix_phases(xp, fraction, rphase, strain, temperature, shape)
        return self.resistance.resistance(xp, fraction, strain, temperature, shape)

    @override
    def cautions(self) -> list[str]:
        cautions, model = super().cautions(), self.resistance
        if isinstance(model, PerLengthResistance):
            expected, source = RESISTIVITY / self.section(), "its diameter and NiTi's 0.84 µΩ m give"
            texts = (describe_contradiction(r, expected, self.wire_length(), source) for r in (model.r_M, model.r_A))
            cautions += [f"{words}." for words in list(filter(None, texts))[:1]]
        return cautions


@ELEMENTS.register("wire")
class Wire(AbstractRoundWire, AbstractLumped):
    """Straight wire that transforms uniformly along its length."""

    length: Number = param("m", "length at zero strain", above=0.0, high=1e3, typical="200 mm")

    @override
    def wire_length(self) -> Scalar:
        return self.length

    @override
    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        free = self.law.free_strain(xp, fractions, temperature)
        compliance = self.law.compliance(xp, fractions)
        return Spring(free * self.length, compliance * (self.length / self.section()))

    @override
    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        return force * (1.0 / self.section())

    @override
    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        return elongation * (1.0 / self.length)
