"""Numbers with units as people read them."""

from __future__ import annotations

import math

from martensite.base import units

_TYPESET = (("degC", "°C"), ("ohm", "Ω"), ("um", "µm"), ("^2", "²"), ("^3", "³"), ("*", " "))


def write_quantity(value: float, unit: str, digits: int = 6) -> str:
    """A number given in the SI `unit`, in a readable one; `none` for a limit that is none."""
    if math.isinf(value):
        return "none"
    shown = units.choose_readable_unit(unit)
    number = f"{units.from_si(value, shown, unit):.{digits}g}"
    return number if shown == "1" else f"{number} {shown}"


def write_difference(value: float, unit: str) -> str:
    """A difference of two quantities given in the SI `unit`, in a readable one."""
    shown, factor = choose_difference_unit(unit)
    return f"{value / factor:.4g}" + (f" {shown}" if shown != "1" else "")


def choose_difference_unit(unit: str) -> tuple[str, float]:
    """The unit in which a difference is read, and its size in the SI `unit`."""
    shown = units.choose_readable_unit(unit)
    return {"degC": "K"}.get(shown, shown), units.find_conversion(shown, unit)[0]


def write_percent(share: float, digits: int = 0) -> str:
    """A share in percent."""
    return f"{100.0 * share:.{digits}f} %"


def typeset_unit(unit: str, plain: str = "") -> str:
    """A unit as it is printed; `plain` for a number without one."""
    if unit in ("", "1"):
        return plain
    for spelling, printed in _TYPESET:
        unit = unit.replace(spelling, printed)
    return unit
