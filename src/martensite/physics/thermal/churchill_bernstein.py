"""Forced convection from a cylinder across a stream, after Churchill and Bernstein.

    Nu = 0.3 + 0.62 √Re Pr^(1/3)/[1 + (0.4/Pr)^(2/3)]^(1/4) · [1 + (Re/282000)^(5/8)]^(4/5)

on the diameter, Re = u d/ν, for Re Pr above 0.2; properties at the film temperature. The stream
is at the ambient temperature and at right angles to the wire. Buoyancy is left out: when a wire
in still air would lose as much by free convection, the stream is too slow for this formula.

Source: Churchill and Bernstein (1977); the equation is that of textbooks, recalled.
"""

from __future__ import annotations

from martensite.base.parameters import param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.air import Air
from martensite.physics.fluids.base import FLUIDS, AbstractFluid
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder
from martensite.physics.thermal.buoyancy import raise_constant


@COOLING.register("churchill-bernstein")
class ChurchillBernstein(AbstractCooling):
    """Forced convection from a wire across a stream."""

    cites = ("churchill1977",)

    speed: Scalar = param("m/s", "speed of the stream across the wire", above=0.0, high=100.0, typical="1 m/s")
    fluid: AbstractFluid = part("fluid around the element", FLUIDS, default=Air())

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h = Nu k/d [W/(m² K)] from the properties at the film temperature."""
        found = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        reynolds = self.speed * shape.diameter / found.viscosity
        return self.nusselt(xp, reynolds, found.prandtl) * found.conductivity / shape.diameter

    def nusselt(self, xp: Namespace, reynolds: Scalar, prandtl: Scalar) -> Scalar:
        """Mean Nusselt number on the diameter [-]."""
        damping = raise_constant(xp, 1.0 + raise_constant(xp, 0.4 / prandtl, 2.0 / 3.0), 0.25)
        laminar = 0.62 * xp.sqrt(reynolds) * raise_constant(xp, prandtl, 1.0 / 3.0) / damping
        turbulent = raise_constant(xp, 1.0 + raise_constant(xp, reynolds * (1.0 / 282000.0), 5.0 / 8.0), 0.8)
        return 0.3 + laminar * turbulent
