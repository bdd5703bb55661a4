"""Unused engine oil, 273 K to 430 K, from a textbook table.

Conductivity is linear between the rows. Viscosity falls by a factor of 700, and Pr with it: their logarithms are linear
between the rows (linear ν would be up to 8 % higher, near 285 K).

Kind of the values: textbook (Bergman, Lavine, Incropera and DeWitt, table A.5), recalled, and identical in a publicly
posted copy. The oil has no grade. Viscosities of oils differ by factors: use it as an example.
"""

import math

from martensite.base.interfaces import override
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties, Row, interpolate_rows

ROWS: tuple[Row, ...] = (
    (273.0, 0.147, 4280.0, 47000.0),
    (280.0, 0.144, 2430.0, 27500.0),
    (290.0, 0.145, 1120.0, 12900.0),
    (300.0, 0.145, 550.0, 6400.0),
    (310.0, 0.145, 288.0, 3400.0),
    (320.0, 0.143, 161.0, 1965.0),
    (330.0, 0.141, 96.6, 1205.0),
    (340.0, 0.139, 61.7, 793.0),
    (350.0, 0.138, 41.7, 546.0),
    (360.0, 0.138, 29.7, 395.0),
    (370.0, 0.137, 22.0, 300.0),
    (380.0, 0.136, 16.9, 233.0),
    (390.0, 0.135, 13.3, 187.0),
    (400.0, 0.134, 10.6, 152.0),
    (410.0, 0.133, 8.52, 125.0),
    (420.0, 0.133, 6.94, 103.0),
    (430.0, 0.132, 5.83, 88.0),
)
"""Temperature [K], k [W/(m K)], ν [1e-6 m²/s], Pr [-]."""

LOGARITHMIC = tuple((t, k, math.log(1e-6 * nu), math.log(pr)) for t, k, nu, pr in ROWS)
EXPANSION = 0.70e-3
"""β for all temperatures [1/K]."""


@FLUIDS.register("oil")
class Oil(AbstractFluid):
    """Unused engine oil, from 273 K to 430 K."""

    cites = ("bergman2011",)

    @override
    def span(self) -> tuple[float, float]:
        return ROWS[0][0], ROWS[-1][0]

    @override
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        conductivity, viscosity, prandtl = interpolate_rows(xp, temperature, LOGARITHMIC)
        return FluidProperties(conductivity, xp.exp(viscosity), xp.exp(prandtl), EXPANSION)
