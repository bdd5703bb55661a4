"""In which unit a column, a parameter or a difference is shown: shown = SI * factor + offset."""

from __future__ import annotations

from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_conversion
from martensite.base import units
from martensite.base.formats import choose_difference_unit


def describe_display(name: str, unit: str) -> JsonTable:
    """How a column or output is shown; strain in percent."""
    return describe_conversion(unit, units.of_column(name, unit))


def shown_number(value: float, unit: str) -> JsonTable:
    """How a parameter of such a size is shown."""
    return describe_conversion(unit, units.choose_familiar_unit(value, unit))


def describe_difference(name: str, unit: str) -> JsonTable:
    """How an error or an offset is shown, which has no zero to be shifted."""
    if units.of_column(name, unit) == "%":
        return describe_conversion(unit, "%")
    spelling, factor = choose_difference_unit(unit)
    return {
        "unit": unit,
        "shown": "" if spelling == "1" else spelling,
        "factor": 1.0 / factor,
        "offset": 0.0,
    }
