"""Straight wire: stress = force/section, strain = elongation/length.

Geometry enters at its nominal size (no lateral contraction). The lateral surface π d l
loses heat, and so do the ends if they are clamped.
"""

from __future__ import annotations

import math

from martensite.electrical.base import RESISTANCES, AbstractResistance, Conductor
from martensite.elements.base import ELEMENTS, Spring
from martensite.elements.limits import Limits
from martensite.elements.lumped import AbstractLumped
from martensite.errors import ParameterError
from martensite.laws.base import LAWS, AbstractLaw, Fractions
from martensite.parameters import param, part
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.thermal.base import Cylinder, Environment
from martensite.thermal.ends import ENDS, AbstractEnds, AdiabaticEnds


@ELEMENTS.register("wire")
class Wire(AbstractLumped):
    """A straight wire that transforms uniformly along its length."""

    diameter: Scalar = param("m", "wire diameter", above=0.0, high=0.02)
    length: Scalar = param("m", "length at zero strain", above=0.0, high=1e3)
    density: Scalar = param("kg/m^3", "density", above=0.0, high=3e4)
    heat_capacity: Scalar = param("J/kg/K", "specific heat capacity", above=0.0, high=1e4)
    latent_heat: Scalar = param(
        "J/kg", "latent heat of the whole transformation", low=0.0, high=1e6, default=0.0
    )
    initial_fraction: Scalar = param(
        "1", "martensite fraction at the start", low=0.0, high=1.0, default=1.0
    )
    initial_oriented: Scalar = param(
        "1", "share of the initial martensite that is oriented", low=0.0, high=1.0, default=1.0
    )
    law: AbstractLaw = part("stress–strain–temperature law", LAWS)
    resistance: AbstractResistance = part("resistance model", RESISTANCES)
    ends: AbstractEnds = part("what the ends lose", ENDS, default=AdiabaticEnds())
    limits: Limits = part("safety limits", default=Limits())

    def check(self) -> None:
        """Raise `ParameterError` if the law cannot hold the initial state."""
        if self.initial_oriented < 1.0 and not self.law.twins:
            raise ParameterError(
                f"Parameter `initial_oriented` of `wire` must be 1 with law "
                f"`{self.law.registered_name}`, which knows oriented martensite only, but is "
                f"{self.initial_oriented:.6g}; try law `brinson`."
            )

    def initial_fractions(self) -> Fractions:
        """Phase state at the start."""
        return Fractions(self.initial_fraction, self.initial_fraction * self.initial_oriented)

    def section(self) -> Scalar:
        """Cross-section [m²]."""
        return 0.25 * math.pi * self.diameter * self.diameter

    def surface(self) -> Scalar:
        """Lateral surface [m²]."""
        return math.pi * self.diameter * self.length

    def mass(self) -> Scalar:
        """Mass [kg]."""
        return self.density * self.section() * self.length

    def heat_capacity_total(self) -> Scalar:
        """Heat capacity without transformation [J/K]."""
        return self.mass() * self.heat_capacity

    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Heat released by the whole forward transformation [J] at (stress, temperature)."""
        latent = self.density * self.latent_heat
        return self.law.heat(xp, latent, stress, temperature) * self.section() * self.length

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Conductance · (T - T_a) [W]; the conductance is h(T) S unless the ends lose as well."""
        ambient, shape = environment.temperature, Cylinder(self.diameter, self.length)
        film = environment.cooling.film(xp, temperature, ambient, shape)
        return self.ends.conductance(xp, film, shape) * (temperature - ambient)

    def spring(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> Spring:
        """The wire as a linear spring at frozen fractions and temperature [K]."""
        free = self.law.free_strain(xp, fractions, temperature)
        compliance = self.law.compliance(xp, fractions)
        return Spring(free * self.length, compliance * (self.length / self.section()))

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Axial stress [Pa]."""
        return force * (1.0 / self.section())

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Axial strain [-]."""
        return elongation * (1.0 / self.length)

    def ohms(self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar) -> Scalar:
        """Resistance [ohm]."""
        shape = Conductor(self.section(), self.length)
        return self.resistance.resistance(xp, fraction, strain, temperature, shape)
