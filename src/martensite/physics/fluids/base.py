"""What every fluid answers: its properties at the film temperature.

The film temperature is the mean of the surface's and the ambient temperature. Properties are known over the span of the
fluid; beyond it they are held at the nearer end, so that a solver may try any temperature.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import NamedTuple

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar

FLUIDS: Registry[AbstractFluid] = Registry("fluid", "martensite.physics.fluids", typical="air")


class FluidProperties(NamedTuple):
    """What a correlation needs to know of a fluid at one temperature."""

    conductivity: Scalar
    """Thermal conductivity k [W/(m K)]"""
    viscosity: Scalar
    """Kinematic viscosity ν [m²/s]"""
    prandtl: Scalar
    """Prandtl number Pr = ν/α [-]"""
    expansion: Scalar
    """Volumetric thermal expansion β [1/K]"""

    @property
    def diffusivity(self) -> Scalar:
        """Thermal diffusivity α = ν/Pr [m²/s]."""
        return self.viscosity / self.prandtl


class AbstractFluid(Parametrised):
    """Interface of a fluid."""

    @abstractmethod
    def span(self) -> tuple[float, float]:
        """Lowest and highest film temperature at which the properties are known [K]."""

    def properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        """Properties at the film temperature [K], held beyond the span."""
        return self.film_properties(xp, xp.clip(temperature, *self.span()))

    @abstractmethod
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        """Properties at a temperature [K] within the span."""
