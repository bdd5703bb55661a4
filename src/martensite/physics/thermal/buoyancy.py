"""Free convection: what the correlations for a heated cylinder in a fluid at rest share.

    h = Nu k/s          Ra = g β |T - T_a| s³/(ν α)

with all properties at the film temperature (T + T_a)/2 and s the size on which the correlation is built (diameter or
length). A cylinder colder than the fluid counts by |T - T_a|. Powers of Ra below one have an infinite slope at T = T_a,
so |T - T_a| is never taken smaller than 0.01 K. Nothing is registered here.
"""

from __future__ import annotations

from abc import abstractmethod

from martensite.base.parameters import param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.air import Air
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties
from martensite.physics.thermal.base import AbstractCooling, Cylinder

LEAST_DIFFERENCE = 0.01
"""Smallest |T - T_a| that drives the flow [K]."""


def raise_constant(xp: Namespace, base: Scalar, exponent: Scalar) -> Scalar:
    """`base` to a constant power, for a base that is never negative."""
    return xp.exp(exponent * xp.log(base))


class AbstractFreeConvection(AbstractCooling):
    """A correlation Nu(Ra, Pr) with the fluid and the gravity that go into it."""

    fluid: AbstractFluid = part("fluid around the element", FLUIDS, default=Air())
    gravity: Scalar = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h = Nu k/s [W/(m² K)] from the properties at the film temperature."""
        found = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        size = self.size(shape)
        rayleigh = self.rayleigh(xp, found, xp.abs(temperature - ambient), size)
        return self.nusselt(xp, rayleigh, found.prandtl, shape) * found.conductivity / size

    def rayleigh(self, xp: Namespace, found: FluidProperties, difference: Scalar, size: Scalar) -> Scalar:
        """Ra [-] of a body of this size [m] that is `difference` [K] off the fluid."""
        driving = self.gravity * found.expansion * xp.maximum(difference, LEAST_DIFFERENCE)
        return driving * size * size * size / (found.viscosity * found.diffusivity)

    def size(self, shape: Cylinder) -> Scalar:
        """The size s [m] on which Nu and Ra are built."""
        return shape.diameter

    @abstractmethod
    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        """Mean Nusselt number h s/k [-]."""
