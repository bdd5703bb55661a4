"""Common units, and their products and quotients, such as `mW/mm^2`, without pint.

A unit is a factor and the exponents of the base units m, kg, s, A, K and rad. Unknown symbols are left to pint.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

_DECLARED = (
    "1 K K/Pa K/Pa^2 m m^3 s Hz kg N N/m Pa Pa/K V A W ohm ohm/m ohm*m kg/m^3 J/kg J/kg/K W/m/K W/m^2/K W/m^2/K^2 "
    "W/m^2/K^3 1/K 1/Pa m/s^2 m/s rad rad/s N*m N*m/rad N*m*s/rad N*s/m kg*m^2 N*m/A V*s/rad H W/kg"
)
"""Units in which parameters are declared."""
EVERYDAY: dict[str, tuple[str, float, float]] = {unit: (unit, 1.0, 0.0) for unit in _DECLARED.split()} | {
    "%": ("1", 0.01, 0.0),
    "degC": ("K", 1.0, 273.15),
    "mm": ("m", 1e-3, 0.0),
    "cm": ("m", 1e-2, 0.0),
    "um": ("m", 1e-6, 0.0),
    "ms": ("s", 1e-3, 0.0),
    "us": ("s", 1e-6, 0.0),
    "min": ("s", 60.0, 0.0),
    "kHz": ("Hz", 1e3, 0.0),
    "g": ("kg", 1e-3, 0.0),
    "N/mm": ("N/m", 1e3, 0.0),
    "kPa": ("Pa", 1e3, 0.0),
    "MPa": ("Pa", 1e6, 0.0),
    "GPa": ("Pa", 1e9, 0.0),
    "MPa/K": ("Pa/K", 1e6, 0.0),
    "K/MPa": ("K/Pa", 1e-6, 0.0),
    "K/MPa^2": ("K/Pa^2", 1e-12, 0.0),
    "mV": ("V", 1e-3, 0.0),
    "mA": ("A", 1e-3, 0.0),
    "mW": ("W", 1e-3, 0.0),
    "ohm m": ("ohm*m", 1.0, 0.0),
    "kJ/kg": ("J/kg", 1e3, 0.0),
    "deg": ("rad", 0.017453292519943295, 0.0),
    "deg/s": ("rad/s", 0.017453292519943295, 0.0),
    "mN*m": ("N*m", 1e-3, 0.0),
    "mH": ("H", 1e-3, 0.0),
    "mm^2": ("m^2", 1e-6, 0.0),
    "J/g": ("J/kg", 1e3, 0.0),
    "W/g": ("W/kg", 1e3, 0.0),
    "mW/mg": ("W/kg", 1e3, 0.0),
    "kohm": ("ohm", 1e3, 0.0),
    "uohm m": ("ohm*m", 1e-6, 0.0),
    "uohm*cm": ("ohm*m", 1e-8, 0.0),
    "nF": ("F", 1e-9, 0.0),
    "uF": ("F", 1e-6, 0.0),
    "mN/V": ("N/V", 1e-3, 0.0),
}
"""Spelling -> (declared SI unit, factor, offset): value_SI = value * factor + offset."""

_BASES = ("m", "kg", "s", "A", "K", "rad")
_DERIVED = {
    "1": "m/m",
    "N": "kg*m/s^2",
    "J": "N*m",
    "Pa": "N/m^2",
    "W": "J/s",
    "V": "W/A",
    "ohm": "V/A",
    "Hz": "1/s",
    "H": "V*s/A",
    "F": "A*s/V",
}
_SCALED = {
    "mg": ("kg", 1e-6),
    "mN": ("N", 1e-3),
    "kN": ("N", 1e3),
    "mJ": ("J", 1e-3),
    "kJ": ("J", 1e3),
    "mohm": ("ohm", 1e-3),
    "rpm": ("rad/s", 0.10471975511965977),
}
"""Further units: SI unit and factor."""
_FACTOR = re.compile(r"([*/]?)([A-Za-z%]+|1)(?:\^(\d))?")


class UnitProduct(NamedTuple):
    """Factor to SI, and the exponents of the base units."""

    factor: float
    exponents: tuple[int, ...]

    @property
    def without_angle(self) -> tuple[int, ...]:
        """Return the exponents of the dimensions; an angle has none."""
        return self.exponents[:-1]


@cache
def read_product(spelling: str) -> UnitProduct | None:
    """Return a unit as a product of common units; None for other units, and for degC within a product."""
    parts = [match.groups() for match in _FACTOR.finditer(spelling)]
    written = "".join(f"{sign}{symbol}{'^' + power if power else ''}" for sign, symbol, power in parts)
    if not parts or written != spelling or (len(parts) > 1 and "degC" in spelling):
        return None
    factor, exponents = 1.0, [0] * len(_BASES)
    for place, (sign, symbol, power) in enumerate(parts):
        product = _find_symbol(symbol)
        if product is None or bool(sign) != bool(place):
            return None
        times = int(power or 1) * (-1 if sign == "/" else 1)
        factor *= product.factor**times
        exponents = [a + times * b for a, b in zip(exponents, product.exponents, strict=True)]
    return UnitProduct(factor, tuple(exponents))


@cache
def _find_symbol(symbol: str) -> UnitProduct | None:
    if symbol in _BASES:
        return UnitProduct(1.0, tuple(int(symbol == base) for base in _BASES))
    if symbol in _DERIVED:
        return read_product(_DERIVED[symbol])
    if symbol not in EVERYDAY and symbol not in _SCALED:
        return None
    unit, factor = EVERYDAY[symbol][:2] if symbol in EVERYDAY else _SCALED[symbol]
    product = read_product(unit)
    return product and UnitProduct(factor * product.factor, product.exponents)
