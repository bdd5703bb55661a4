"""In which unit a column, a parameter or a difference is shown: shown = SI * factor + offset."""

from __future__ import annotations

from typing import Any

from martensite.app.views.columns import converted
from martensite.base import units
from martensite.search.quantity_text import find_difference_unit


def shown(name: str, unit: str) -> dict[str, Any]:
    """How a column or output is shown; strain in percent."""
    return converted(unit, units.of_column(name, unit))


def shown_number(value: float, unit: str) -> dict[str, Any]:
    """How a parameter of such a size is shown."""
    return converted(unit, units.choose_familiar_unit(value, unit))


def shown_difference(name: str, unit: str) -> dict[str, Any]:
    """How an error or an offset is shown, which has no zero to be shifted."""
    if units.of_column(name, unit) == "%":
        return converted(unit, "%")
    factor, spelling = find_difference_unit(unit)
    return {
        "unit": unit,
        "shown": "" if spelling == "1" else spelling,
        "factor": 1.0 / factor,
        "offset": 0.0,
    }
