"""Dry air from four textbook formulas, 250 K to 450 K, near atmospheric pressure.

- conductivity k = 0.02624 (T/300 K)^0.8646 W/(m K);
- Sutherland's viscosity μ = 1.458e-6 T^1.5/(T + 110.4 K) kg/(m s), independent of pressure;
- density p/(R T) of an ideal gas with R = 287.05 J/(kg K), so ν = μ/ρ and β = 1/T;
- Prandtl number 0.707.

Kind of the values: textbook, recalled. Compared with `air-table` (20 °C to 100 °C), the conductivity is 2.3 % to 2.4 %
higher, the viscosity ν 0.4 % to 0.7 % lower, and Pr 0.6 % (100 °C) to 3.3 % (20 °C) lower.
"""

from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties, Row, interpolate_rows

GAS_CONSTANT = 287.05
"""R of dry air [J/(kg K)]."""


@FLUIDS.register("air")
class Air(AbstractFluid):
    """Dry air as an ideal gas, from 250 K to 450 K."""

    pressure: Number = param("Pa", "absolute pressure", low=1e3, high=1e6, default=101325.0)

    @override
    def span(self) -> tuple[float, float]:
        return 250.0, 450.0

    @override
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        log = xp.log(temperature * (1.0 / 300.0))
        density = self.pressure / (GAS_CONSTANT * temperature)
        dynamic = 1.458e-6 * temperature * xp.sqrt(temperature) / (temperature + 110.4)
        return FluidProperties(
            conductivity=0.02624 * xp.exp(0.8646 * log),
            viscosity=dynamic / density,
            prandtl=0.707,
            expansion=1.0 / temperature,
        )


ZERO_CELSIUS = 273.15
ROWS: dict[str, tuple[Row, ...]] = {
    "textbook": (
        (20.0, 0.02514, 1.516, 0.7309),
        (25.0, 0.02551, 1.562, 0.7296),
        (30.0, 0.02588, 1.608, 0.7282),
        (35.0, 0.02625, 1.655, 0.7268),
        (40.0, 0.02662, 1.702, 0.7255),
        (45.0, 0.02699, 1.750, 0.7241),
        (50.0, 0.02735, 1.798, 0.7228),
        (60.0, 0.02808, 1.896, 0.7202),
        (70.0, 0.02881, 1.995, 0.7177),
        (80.0, 0.02953, 2.097, 0.7154),
        (90.0, 0.03024, 2.201, 0.7132),
        (100.0, 0.03095, 2.306, 0.7111),
    ),
    "kossoski": (
        (27.5, 0.02551, 1.56, 0.7296),
        (30.5, 0.02588, 1.61, 0.7282),
        (34.0, 0.02625, 1.66, 0.7268),
        (40.0, 0.02662, 1.70, 0.7255),
        (47.5, 0.02730, 1.78, 0.7230),
        (48.5, 0.02734, 1.79, 0.7229),
        (51.0, 0.02738, 1.81, 0.7220),
        (57.5, 0.02800, 1.89, 0.7210),
        (61.5, 0.02820, 1.92, 0.7100),
    ),
}
"""Film temperature [°C], k [W/(m K)], ν [1e-5 m²/s], Pr [-]."""


@FLUIDS.register("air-table")
class AirTable(AbstractFluid):
    """Air at 1 atm from a table, linear between its rows.

    - `textbook`: 20 °C to 100 °C in twelve rows. Kind: textbook, recalled; the rows from 25 °C to 40 °C agree with
      Kossoski (2018).
    - `kossoski`: the nine rows of Kossoski's Table 2, 27.5 °C to 61.5 °C, as printed, for comparison with the thesis.
      It lists surface temperatures; the assumed film temperatures are the means with 22 °C, which fit best. The last
      Prandtl number (0.7100) is a misprint for about 0.7195; it changes h by less than 0.1 %.

    The expansion is β = 1/T of an ideal gas, the diffusivity α = ν/Pr.
    """

    cites = ("kossoski2018",)

    rows: str = option("which table", "textbook", "kossoski", default="textbook")

    @override
    def span(self) -> tuple[float, float]:
        rows = ROWS[self.rows]
        return rows[0][0] + ZERO_CELSIUS, rows[-1][0] + ZERO_CELSIUS

    @override
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        celsius = temperature - ZERO_CELSIUS
        conductivity, viscosity, prandtl = interpolate_rows(xp, celsius, ROWS[self.rows])
        return FluidProperties(conductivity, 1e-5 * viscosity, prandtl, 1.0 / temperature)
