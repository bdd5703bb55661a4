"""Film coefficient as a parabola of temperature: h = h₀ + h₁ θ + h₂ θ².

θ = T - `reference`; the default reference of 0 °C makes θ the temperature in degrees Celsius, the form fitted to step
responses in the MigaOne paper. A reference at the ambient temperature makes θ the overtemperature.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder


@COOLING.register("polynomial")
class PolynomialCooling(AbstractCooling):
    """A film coefficient of second degree in temperature."""

    cites = ("migaone-paper",)

    h0: Scalar = param("W/m^2/K", "film coefficient at the reference", low=0.0, high=1e5, typical="60 W/m^2/K")
    h1: Scalar = param("W/m^2/K^2", "linear coefficient", low=-1e3, high=1e3, default=0.0, typical="0.1 W/m^2/K^2")
    h2: Scalar = param(
        "W/m^2/K^3", "quadratic coefficient", low=-10.0, high=10.0, default=0.0, typical="1e-4 W/m^2/K^3"
    )
    reference: Scalar = param("K", "temperature at which θ is zero", low=0.0, high=1000.0, default=273.15)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h(T) [W/(m² K)], never below zero."""
        theta = temperature - self.reference
        return xp.maximum(self.h0 + theta * (self.h1 + theta * self.h2), 0.0)
