"""Readable names and quantities: `eps_L` is ε_L, `W/m^2/K` is W/m²/K."""

from __future__ import annotations

import math
import re

from martensite.base import units

_TYPESET = (("degC", "°C"), ("ohm", "Ω"), ("um", "µm"), ("^2", "²"), ("^3", "³"), ("*", " "))
_NAMES = "alpha beta gamma delta eps nu rho sigma tau phi xi Theta Delta lambda"
GREEK: dict[str, str] = dict(zip(_NAMES.split(), "αβγδενρστφξΘΔλ", strict=True))
_LETTER = re.compile(r"^([A-Za-z])(\d*|[a-z])$")
_SLOPE = re.compile(r"^d([a-z]+)_d([A-Z])$")


def write_quantity(value: float, unit: str, digits: int = 6) -> str:
    """Return a value given in the SI `unit` as text in a readable unit; `none` for an infinite limit."""
    if math.isinf(value):
        return "none"
    display_unit = units.choose_readable_unit(unit)
    number = f"{units.from_si(value, display_unit, unit):.{digits}g}"
    return number if display_unit == "1" else f"{number} {display_unit}"


def show_quantity(value: float, unit: str, digits: int = 4, display_unit: str = "") -> str:
    """Return a value given in the SI `unit` as screens show it, such as `93.94 °C`.

    Args:
        value: value in the SI `unit`.
        unit: SI unit.
        digits: significant digits.
        display_unit: unit to convert to; by default the readable one.
    """
    if math.isinf(value):
        return "none"
    display_unit = display_unit or units.choose_readable_unit(unit)
    number = f"{units.from_si(value, display_unit, unit):.{digits}g}"
    return f"{number} {typeset_unit(display_unit)}".rstrip()


def write_difference(value: float, unit: str, digits: int = 4, name: str = "") -> str:
    """Return a difference given in the SI `unit` as text in a readable unit, of a column if it has a name."""
    display_unit, factor = choose_difference_unit(unit, name)
    return f"{value / factor:.{digits}g}" + (f" {display_unit}" if display_unit != "1" else "")


def choose_difference_unit(unit: str, name: str = "") -> tuple[str, float]:
    """Return the readable unit of a difference, of a column if it has a name, and its size in the SI `unit`."""
    display_unit = units.of_column(name, unit)
    return {"degC": "K"}.get(display_unit, display_unit), units.find_conversion(display_unit, unit)[0]


def write_percent(share: float, digits: int = 0) -> str:
    """Return a fraction as text in percent."""
    return f"{100.0 * share:.{digits}f} %"


def typeset_unit(unit: str, plain: str = "") -> str:
    """Return a typeset unit; `plain` if there is no unit."""
    if unit in ("", "1"):
        return plain
    for spelling, printed in _TYPESET:
        unit = unit.replace(spelling, printed)
    return unit


def spell_symbol(name: str) -> str:
    """Return the symbol of a name, with `_` before its index; empty for a word.

    `E_A` is E_A, `rho_inf` ρ_∞, `dsigma_dT` dσ/dT, `Kp` K_p; `diameter` has no symbol.
    """
    slope = _SLOPE.match(name)
    if slope:
        return f"d{GREEK.get(slope[1], slope[1])}/d{slope[2]}"
    head, *rest = name.split("_")
    if head == "Delta" and rest:
        return "Δ" + "_".join(GREEK.get(word, word) for word in rest)
    letter = _LETTER.match(head)
    if head not in GREEK and letter is None:
        return ""
    if letter is not None and letter[2]:
        if letter[2].isalpha() and not letter[1].isupper():  # a short word, such as `at`
            return ""
        head, rest = letter[1], [letter[2], *rest]
    below = ",".join({"inf": "∞"}.get(word, GREEK.get(word, word)) for word in rest)
    return GREEK.get(head, head) + (f"_{below}" if below else "")


def spell_title(name: str) -> str:
    """Return a name as words: `coil_diameter` is coil diameter."""
    return name.replace("_", " ").replace(".", " ")
