"""Names, symbols and units as they are read: `eps_L` is ε_L, `W/m^2/K` is W/(m²·K)."""

from __future__ import annotations

import re

from martensite.app.messages import JsonTable
from martensite.base import units
from martensite.base.errors import UnitError

GREEK = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "delta": "δ",
    "eps": "ε",
    "nu": "ν",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "phi": "φ",
    "xi": "ξ",
    "Theta": "Θ",
    "Delta": "Δ",
    "lambda": "λ",
}
_LETTER = re.compile(r"^([A-Za-z])(\d*|[a-z])$")
_SLOPE = re.compile(r"^d([a-z]+)_d([A-Z])$")
_PRINTED = (("degC", "°C"), ("deg", "°"), ("ohm", "Ω"), ("^2", "²"), ("^3", "³"), ("^0.5", "^½"))


def spell_symbol(name: str) -> str:
    """The symbol that a name spells, with `_` before its index; empty if it is a word.

    `E_A` is E_A, `rho_inf` ρ_∞, `dsigma_dT` dσ/dT, `Kp` K_p; `diameter` has none.
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
    """A name in words: `coil_diameter` is coil diameter."""
    return name.replace("_", " ").replace(".", " ")


def print_unit(unit: str) -> str:
    """A unit as it is read, such as W/(m²·K); empty for 1."""
    text = {"1": "", units.DEGREES: "K"}.get(unit, unit)
    over, *under = text.split("/")
    below = "·".join(under)
    text = f"{over}/({below})" if len(under) > 1 else "/".join([over, *under])
    for spelled, read in _PRINTED:
        text = text.replace(spelled, read)
    return text.replace("*", "·")


def describe_display(unit: str, value: float | None = None) -> JsonTable:
    """How a number in an SI unit is shown: spelling, label, factor and offset.

    shown = SI · factor + offset; the spelling is empty where there is no unit.
    """
    spelling = (
        units.choose_readable_unit(unit)
        if value is None
        else units.choose_familiar_unit(value, unit)
    )
    try:
        size, zero = units.find_conversion(spelling, unit)
    except UnitError:  # of a plug-in: what pint does not know is shown as it is
        spelling, size, zero = unit, 1.0, 0.0
    spelled = "K" if spelling == units.DEGREES else spelling
    return {
        "shown": "" if spelling == "1" else spelled,
        "label": print_unit(spelling),
        "factor": 1.0 / size,
        "offset": -zero / size,
    }


def word_quantity(value: float, unit: str) -> str:
    """A number in SI as a person reads it, such as `75 GPa`."""
    how = describe_display(unit, value)
    return f"{value * how['factor'] + how['offset']:.6g} {how['label']}".strip()
