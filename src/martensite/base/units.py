"""Unit conversion: text with a unit becomes an SI float, and back for labels.

pint is the authority. A table of common spellings and their products (`base.unit_products`), tested against pint,
avoids loading pint in short runs. The library uses SI floats in the declared unit.
"""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any, Protocol, TypeAlias, TypeGuard, runtime_checkable

from martensite.base.errors import UnitError
from martensite.base.unit_products import EVERYDAY, read_product

DEGREES = "delta_degC"
"""Unit of a temperature difference [K], which has no offset."""

LEVEL = "reading"
"""Declared unit of a level of a reading; depends on the place."""
DIFFERENCE = "reading difference"
"""Declared unit of a difference of two readings."""
RATE = "reading difference/s"
"""Declared unit of a rate of a reading."""
GAIN, INTEGRAL_GAIN, DERIVATIVE_GAIN = "signal/reading", "signal/reading/s", "signal*s/reading"
"""Declared units of controller gains, signal over reading; depend on the place."""
OF_GAINS = (GAIN, INTEGRAL_GAIN, DERIVATIVE_GAIN)
SIGNAL_RATE, REFERENCE_RATE, REFERENCE_ACCELERATION = "signal/s", "reference/s", "reference/s^2"
"""Declared units of rates of a signal and of a reference; depend on the place."""
OF_LOOPS = (*OF_GAINS, SIGNAL_RATE, REFERENCE_RATE, REFERENCE_ACCELERATION)
OF_READINGS = (LEVEL, DIFFERENCE, RATE, *OF_LOOPS)
DRIVE = "drive"
"""Declared unit of a waveform level; the driven source gives the unit."""
OF_PLACE = (DRIVE, *OF_READINGS)
"""Declared units that depend on the place."""

# declared SI unit -> readable unit
READABLE = {
    "K": "degC",
    "Pa": "MPa",
    "m": "mm",
    "Pa/K": "MPa/K",
    "K/Pa": "K/MPa",
    "K/Pa^2": "K/MPa^2",
    "kg": "g",
    "W/kg": "W/g",
    "rad": "deg",
    "rad/s": "deg/s",
    DEGREES: "K",
}

COLUMNS = {("strain", "1"): "%", ("rotor_speed", "rad/s"): "rpm", ("rotor_speed_2", "rad/s"): "rpm"}
"""Readable units of columns that differ from those of their SI unit."""

# declared SI unit -> (unit for large values, smallest such value)
_LARGER = {"Pa": ("GPa", 1e9), "J/kg": ("kJ/kg", 1e3)}

_QUANTITY = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")
_GAUGE = re.compile(r"(?i)^\s*(?:awg\s*#?(\d{1,2})|(\d{1,2})\s*awg)\s*$")
_SPELLINGS = str.maketrans(
    {"°": "deg", "\u03a9": "ohm", "\u2126": "ohm", "\u00b5": "u", "\u03bc": "u", "\u2212": "-"}
    | {"·": "*", "²": "^2", "³": "^3", "\u0394": "delta_"}
)


def parse_quantity(text: str, unit: str) -> float:
    """Return a quantity such as `"0.381 mm"` as a float in the SI `unit`.

    Raises:
        UnitError: the text is not a number with a unit, or the unit has another dimension.
    """
    if unit == "m" and (gauge := _GAUGE.match(text)):
        diameter = 0.127 * 92.0 ** ((36 - int(gauge[1] or gauge[2])) / 39.0)
        raise UnitError(f"`{text}` is a gauge of copper wire, {diameter:.3g} mm; write the diameter of yours.")
    match = _QUANTITY.match(text.translate(_SPELLINGS))
    if match is not None and match[2][:1] == ",":
        raise UnitError(f"`{text}` has a comma; write a decimal point, and nothing between thousands.")
    if match is None:
        raise UnitError(f"`{text}` is not a number with a unit; write for example `1.5 {unit}`.")
    if not match[2] and unit != "1":
        raise UnitError(f"`{text}` has no unit; write for example `{text.strip()} {unit}`.")
    return to_si(float(match[1]), match[2] or "1", unit)


@runtime_checkable
class AbstractQuantity(Protocol):
    """Quantity of pint, from any registry."""

    @property
    def magnitude(self) -> Any:
        """Return the number."""

    @property
    def units(self) -> Any:
        """Return the unit."""


Numeric: TypeAlias = float | str | AbstractQuantity
"""Number in SI, text with a unit, or pint quantity."""


def is_quantity(value: Any) -> TypeGuard[AbstractQuantity]:
    """Return whether a value is a pint quantity."""
    return hasattr(value, "magnitude") and hasattr(value, "units")


def write_pint(value: AbstractQuantity) -> str:
    """Return a pint quantity as text, such as `22.0 degC`.

    Raises:
        UnitError: the quantity is an array.
    """
    try:
        number = float(value.magnitude)
    except (TypeError, ValueError):
        raise UnitError(f"A quantity must be one number, but is `{value}`.") from None
    return f"{number!r} {value.units:~}".translate(_SPELLINGS).strip()


def convert_number(value: Numeric, unit: str) -> float:
    """Return a number in SI, a text with a unit or a pint quantity as a float in the SI `unit`.

    Raises:
        UnitError: the text is not a number with a unit, or the unit has another dimension.
        TypeError: the value has another type.
        ValueError: the text is not a number.
    """
    if is_quantity(value):
        value = write_pint(value)
    return parse_quantity(value, unit) if isinstance(value, str) else float(value)  # type: ignore[arg-type]


def to_si(value: float, spelling: str, unit: str) -> float:
    """Convert `value` from the unit `spelling` to the declared SI `unit`."""
    factor, offset = find_conversion(spelling.translate(_SPELLINGS), unit)
    return value * factor + offset


def from_si(value: float, spelling: str, unit: str) -> float:
    """Convert `value` from the declared SI `unit` to the unit `spelling`."""
    factor, offset = find_conversion(spelling.translate(_SPELLINGS), unit)
    return (value - offset) / factor


def find_conversion(spelling: str, unit: str) -> tuple[float, float]:
    """Return (factor, offset) with value in `unit` = value in `spelling` * factor + offset."""
    if spelling == unit or (spelling, unit) == ("K", DEGREES):
        return 1.0, 0.0
    declared, factor, offset = EVERYDAY.get(spelling, ("", 1.0, 0.0))
    if declared == unit:
        return factor, offset
    one, other = read_product(spelling), read_product(unit)
    if one is None or other is None or offset:
        return _ask_pint(spelling, unit)
    if one.exponents == other.exponents and "degC" not in (spelling, unit):  # which has an offset
        return one.factor / other.factor, 0.0
    if one.without_angle == other.without_angle:  # 1 Hz is not 1 rad/s, but pint decides
        return _ask_pint(spelling, unit)
    raise UnitError(_describe_mismatch(spelling, unit))


def _describe_mismatch(spelling: str, unit: str) -> str:
    return f"The unit `{spelling}` cannot be converted to `{unit}`.{_suggest_unit(spelling, unit)}"


def require_unit(unit: str) -> None:
    """Raise `UnitError` unless a declared unit is valid."""
    if unit not in ("1", *OF_READINGS) and read_product(unit) is None:
        _ask_pint(unit, unit)


def choose_readable_unit(unit: str) -> str:
    """Return the readable unit of a quantity declared in `unit`."""
    return READABLE.get(unit, unit)


def of_column(name: str, unit: str) -> str:
    """Return the readable unit of a column: percent for strains, revolutions per minute for rotors."""
    return COLUMNS.get((name.rpartition(".")[2], unit), choose_readable_unit(unit))


def choose_familiar_unit(value: float, unit: str) -> str:
    """Return the readable unit of a value in SI, such as GPa for a modulus."""
    larger = _LARGER.get(unit)
    return larger[0] if larger and abs(value) >= larger[1] else choose_readable_unit(unit)


def of_reading(unit: str, reading: str) -> str:
    """Return the SI unit of a value declared in `unit`, for a reading in the SI unit `reading`."""
    if unit == RATE:
        return f"{reading}/s"
    if unit == DIFFERENCE:
        return DEGREES if reading == "K" else reading
    return reading if unit == LEVEL else unit


def of_loop(unit: str, signal: str, reading: str) -> str:
    """Return the SI unit of a gain or rate declared in `unit`, for the SI units of signal and reading."""
    if unit not in OF_GAINS:
        return f"{signal if unit == SIGNAL_RATE else reading}/{unit.partition('/')[2]}"
    above = f"{'' if signal == '1' else signal + '*'}s" if unit == DERIVATIVE_GAIN else signal
    below = f"({reading})" if re.search(r"[*/]", reading) else reading
    gain = above if reading == "1" else f"{above}/{below}"
    return f"{gain}/s" if unit == INTEGRAL_GAIN else gain


_BASES = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}


@cache
def find_dimensions(unit: str) -> dict[str, float]:
    """Return the exponents of the SI base units, and of rad, in a declared unit: `{"kg": 1, "s": -3}`.

    Raises:
        UnitError: the unit is unknown, or not a coherent SI unit, such as `mm`.
    """
    import pint

    try:
        ureg = _pint_registry()
        one = ureg.Quantity(1.0, ureg.parse_units("" if unit == "1" else unit)).to_base_units()
    except (pint.PintError, ValueError, TypeError, AssertionError):
        raise UnitError(f"`{unit}` is not a known unit.") from None
    if abs(one.magnitude - 1.0) > 1e-12:
        raise UnitError(f"`{unit}` is no coherent unit of SI.")
    return {_BASES[name]: float(power) for name, power in one.unit_items()}


_SAME = {
    "degC": "c celsius centigrade degree degrees deg",
    "degF": "f fahrenheit degf",
    "gf": "g gm gr gram grams gram-force",
    "kgf": "kg kgs kilo kilos kilogram kilograms kp",
    "lbf": "lb lbs pound pounds",
    "ozf": "oz ounce ounces",
    "g": "gf",
    "kg": "n kgf",
    "thou": "mil mils",
    "in": "\" '' inch inches",
    "V": "volt volts vdc vac",
    "A": "amp amps ampere amperes",
    "W": "watt watts",
    "ohm": "ohms r",
    "kohm": "k kohms",
    "N": "newton newtons",
    "1/min": "rpm cpm bpm",
    "%": "pct",
    "gf/mm": "g/mm",
    "lbf/in": "lb/in lbs/in",
}
MEANT = {other: name for name, others in _SAME.items() for other in others.split()}
"""Common lower-case spelling -> known spelling."""


def _suggest_unit(spelling: str, unit: str) -> str:
    """Return a sentence with the probable spelling; may be empty."""
    small = spelling.lower().strip(". ").removesuffix(" dc").removeprefix("deg ").removeprefix("degree ")
    spellings = {name.lower(): name for name, (declared, _, _) in EVERYDAY.items() if declared == unit}
    for meant in filter(None, (MEANT.get(small), spellings.get(small))):
        with suppress(ValueError, TypeError, AssertionError, AttributeError):  # an invalid unit
            ureg = _pint_registry()
            if ureg.Unit(meant).is_compatible_with(ureg.Unit("" if unit == "1" else unit)):
                return f" Did you mean `{meant}`?"
    return ""


def _is_turning(spelling: str) -> bool:
    """Return whether a unit contains an angle: 1 rad/s is not 1 Hz, though both are 1/s."""
    return "radian" in {name for name, _ in _pint_registry().Quantity(1.0, spelling).to_base_units().unit_items()}


@cache
def _ask_pint(spelling: str, unit: str) -> tuple[float, float]:
    from tokenize import TokenError

    import pint

    ureg = _pint_registry()
    spelling = "ampere" if spelling == "amps" else spelling  # pint reads attometres per second
    try:
        zero = ureg.Quantity(0.0, _spell_difference(spelling)).to(_spell_difference(unit)).magnitude
        one = ureg.Quantity(1.0, _spell_difference(spelling)).to(_spell_difference(unit)).magnitude
        if unit in ("Hz", "rad/s") and _is_turning(spelling) != _is_turning(unit):
            hint = _suggest_unit(spelling, unit) if unit == "Hz" else " Did you mean `rpm`?"
            raise UnitError(f"The unit `{spelling}` is not `{unit}`: a cycle has an angle of 2 pi rad.{hint}")
    except pint.DimensionalityError:
        raise UnitError(_describe_mismatch(spelling, unit)) from None
    except (pint.PintError, ValueError, TypeError, AssertionError, TokenError):
        hint = _suggest_unit(spelling, unit)
        raise UnitError(f"`{spelling}` is not a known unit; `{unit}` is expected.{hint}") from None
    return float(one - zero), float(zero)


def _spell_difference(spelling: str) -> str:
    """Return the spelling in which degrees within a compound unit are differences."""
    if spelling in ("degC", "degF"):
        return spelling
    return re.sub(r"\bdeg([CF])\b", r"delta_deg\1", spelling)


@cache
def _pint_registry() -> Any:
    pint: Any = import_module("pint")
    return pint.UnitRegistry()
