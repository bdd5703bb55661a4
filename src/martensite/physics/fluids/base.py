"""Interface of a fluid: its properties at the film temperature.

The film temperature is the mean of surface and ambient temperature. Beyond the span of the fluid, the properties at the
nearest end are used, so that a solver may try any temperature.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar

FLUIDS: Registry[AbstractFluid] = Registry("fluid", "martensite.physics.fluids", typical="air")


class FluidProperties(NamedTuple):
    """Properties of a fluid at one temperature."""

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
        """Return the thermal diffusivity α = ν/Pr [m²/s]."""
        return self.viscosity / self.prandtl


class AbstractFluid(Parametrised):
    """Interface of a fluid."""

    @abstractmethod
    def span(self) -> tuple[float, float]:
        """Return the lowest and highest film temperature [K] of the data."""

    def properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        """Return the properties at the film temperature [K], constant beyond the span."""
        return self.film_properties(xp, xp.clip(temperature, *self.span()))

    @abstractmethod
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        """Return the properties at a temperature [K] within the span."""


Row = tuple[float, ...]


def interpolate_rows(xp: Namespace, x: Scalar, rows: Sequence[Row]) -> list[Scalar]:
    """Return all columns of a table at `x`; each row begins with its x, ascending.

    y(x) = y₀ + Σ (yₖ₊₁ - yₖ)/(xₖ₊₁ - xₖ) · clip(x - xₖ, 0, xₖ₊₁ - xₖ) interpolates without branches, constant beyond
    the ends.
    """
    values: list[Scalar] = list(rows[0][1:])
    for (left, *before), (right, *after) in pairwise(rows):
        share = xp.clip(x - left, 0.0, right - left) * (1.0 / (right - left))
        columns = zip(values, before, after, strict=True)
        values = [value + (b - a) * share for value, a, b in columns]
    return values
