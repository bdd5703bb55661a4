"""Values as text with a unit and as JSON, in all digits or a few."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast

from martensite.base import units
from martensite.base.units import choose_familiar_unit


def exact_text(value: float, unit: str, digits: int | None = None) -> str:
    """Return a quantity such as `66.8 degC`, from which `base.units.parse_quantity` reads the same value.

    Args:
        value: number in the SI `unit`.
        unit: SI unit.
        digits: significant digits of the written unit, by default as many as the value needs.
    """
    spelling = choose_familiar_unit(value, unit)
    if digits is not None:
        return _format_number(f"{float(f'{units.from_si(value, spelling, unit):.{digits}g}')!r}", spelling)
    near = units.from_si(value, spelling, unit)
    short = (float(f"{near:.{most}g}") for most in (6, 12, 15, 16))
    beside = (near, math.nextafter(near, math.inf), math.nextafter(near, -math.inf))
    for number in (*short, *beside):
        text = _format_number(repr(number), spelling)
        if units.parse_quantity(text, unit) == value:
            return text
    return _format_number(repr(value), unit)


def format_quantity(value: float, unit: str, digits: int = 4) -> str:
    """Return a quantity in a few digits, such as `66.8 degC`."""
    return shown_in(value, unit, choose_familiar_unit(value, unit), digits)


def shown_range(ends: tuple[float, float], unit: str) -> str:
    """Return two quantities in one unit, such as `62.5 to 63.9 degC`."""
    spelling = choose_familiar_unit(max(map(abs, ends)), unit)
    low, high = (shown_in(end, unit, spelling) for end in ends)
    return high if low == high else f"{low.removesuffix(f' {spelling}')} to {high}"


def shown_in(value: float, unit: str, spelling: str, digits: int = 4) -> str:
    """Return a quantity in a few digits of a unit."""
    number = float(f"{units.from_si(value, spelling, unit):.{digits}g}")
    return _format_number(f"{number:.{max(digits, 6)}g}", spelling)


def _format_number(number: str, spelling: str) -> str:
    number = number.removesuffix(".0")
    return number if spelling == "1" else f"{number} {spelling}"


def convert_to_plain(value: Any) -> Any:
    """Return a value as JSON types: tables, lists, texts, finite numbers and null."""
    if isinstance(value, Mapping):
        return {str(k): convert_to_plain(v) for k, v in cast("Mapping[Any, Any]", value).items()}
    if hasattr(value, "tolist"):  # of NumPy
        return convert_to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [convert_to_plain(item) for item in cast("Sequence[Any]", value)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (str, int)) else str(value)
