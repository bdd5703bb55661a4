"""Dry air from four textbook formulas, 250 K to 450 K, near atmospheric pressure.

- conductivity k = 0.02624 (T/300 K)^0.8646 W/(m K);
- Sutherland's viscosity μ = 1.458e-6 T^1.5/(T + 110.4 K) kg/(m s), which no pressure changes;
- density p/(R T) of an ideal gas with R = 287.05 J/(kg K), so ν = μ/ρ and β = 1/T;
- Prandtl number 0.707.

Kind of the numbers: textbook, recalled. Against the rows of `air-table` (20 °C to 100 °C) the
conductivity is 2.3 % to 2.4 % higher, the viscosity ν 0.4 % to 0.7 % lower, and Pr 0.6 % lower
at 100 °C but 3.3 % lower at 20 °C, the largest deviation.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties

GAS_CONSTANT = 287.05
"""R of dry air [J/(kg K)]"""


@FLUIDS.register("air")
class Air(AbstractFluid):
    """Dry air as an ideal gas, from 250 K to 450 K."""

    pressure: Scalar = param("Pa", "absolute pressure", low=1e3, high=1e6, default=101325.0)

    def span(self) -> tuple[float, float]:
        """250 K to 450 K."""
        return 250.0, 450.0

    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        """k, ν, Pr and β at the film temperature [K]."""
        log = xp.log(temperature * (1.0 / 300.0))
        density = self.pressure / (GAS_CONSTANT * temperature)
        dynamic = 1.458e-6 * temperature * xp.sqrt(temperature) / (temperature + 110.4)
        return FluidProperties(
            conductivity=0.02624 * xp.exp(0.8646 * log),
            viscosity=dynamic / density,
            prandtl=0.707,
            expansion=1.0 / temperature,
        )
