"""Products and quotients of common units, such as `mW/mm^2`, without pint.

A unit is a factor and the exponents of the base units m, kg, s, A, K and rad. Unknown symbols are left to pint.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

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
    "%": ("1", 1e-2),
    "degC": ("K", 1.0),
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "um": ("m", 1e-6),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "min": ("s", 60.0),
    "kHz": ("Hz", 1e3),
    "g": ("kg", 1e-3),
    "mg": ("kg", 1e-6),
    "mN": ("N", 1e-3),
    "kN": ("N", 1e3),
    "kPa": ("Pa", 1e3),
    "MPa": ("Pa", 1e6),
    "GPa": ("Pa", 1e9),
    "mJ": ("J", 1e-3),
    "kJ": ("J", 1e3),
    "mW": ("W", 1e-3),
    "mV": ("V", 1e-3),
    "mA": ("A", 1e-3),
    "kohm": ("ohm", 1e3),
    "mohm": ("ohm", 1e-3),
    "deg": ("rad", 0.017453292519943295),
    "rpm": ("rad/s", 0.10471975511965977),
    "mH": ("H", 1e-3),
}
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
        known = _find_symbol(symbol)
        if known is None or bool(sign) != bool(place):
            return None
        times = int(power or 1) * (-1 if sign == "/" else 1)
        factor *= known.factor**times
        exponents = [a + times * b for a, b in zip(exponents, known.exponents, strict=True)]
    return UnitProduct(factor, tuple(exponents))


@cache
def _find_symbol(symbol: str) -> UnitProduct | None:
    if symbol in _BASES:
        return UnitProduct(1.0, tuple(int(symbol == base) for base in _BASES))
    if symbol in _DERIVED:
        return read_product(_DERIVED[symbol])
    if symbol not in _SCALED:
        return None
    unit, factor = _SCALED[symbol]
    known = read_product(unit)
    return known and UnitProduct(factor * known.factor, known.exponents)
