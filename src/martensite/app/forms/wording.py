"""How numbers of a form are shown: their units, and quantities in words."""

from __future__ import annotations

from martensite.app.forms.form_types import DisplayUnit
from martensite.base import units
from martensite.base.errors import UnitError

_PRINTED = (("degC", "°C"), ("deg", "°"), ("ohm", "Ω"), ("^2", "²"), ("^3", "³"), ("^0.5", "^½"))


def print_unit(unit: str) -> str:
    """A unit as it is read, such as W/(m²·K); empty for 1."""
    text = {"1": "", units.DEGREES: "K"}.get(unit, unit)
    over, *under = text.split("/")
    below = "·".join(under)
    text = f"{over}/({below})" if len(under) > 1 else "/".join([over, *under])
    for spelled, read in _PRINTED:
        text = text.replace(spelled, read)
    return text.replace("*", "·")


def describe_display(unit: str, value: float | None = None) -> DisplayUnit:
    """How a number in an SI unit is shown: spelling, label, factor and offset.

    shown = SI · factor + offset; the spelling is empty where there is no unit.
    """
    spelling = units.choose_readable_unit(unit) if value is None else units.choose_familiar_unit(value, unit)
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
