"""Units of a model description: exponents of SI base units, and what a person would rather read.

In FMI a display unit is a scale: value shown = factor * value + offset.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from martensite.base import units
from martensite.base.errors import UnitError


def unit_of(declared: str) -> str | None:
    """What a declared unit is called in a model description; None where it has none."""
    if declared == units.DEGREES:
        return "K"
    return None if declared in ("", "of the reading", *units.OF_READINGS) else declared


def display_of(declared: str) -> str | None:
    """The unit in which to show a quantity, if that is another one."""
    shown = units.choose_readable_unit(declared)
    return None if declared == units.DEGREES or shown == declared else shown


def add_units(parent: Element, names: list[str]) -> None:
    """The definitions of some units, in their order, below an element."""
    definitions = SubElement(parent, "UnitDefinitions")
    for name in names:
        unit = SubElement(definitions, "Unit", name=name)
        exponents = base_units(name)
        if exponents is not None:
            SubElement(unit, "BaseUnit", {key: str(power) for key, power in exponents.items()})
        shown = display_of(name)
        if shown is not None:
            SubElement(unit, "DisplayUnit", {"name": shown, **_find_scale(shown, name)})


def base_units(name: str) -> dict[str, int] | None:
    """Exponents of base units; None for units of none, and for fractional ones."""
    try:
        exponents = units.find_dimensions(name)
    except UnitError:
        return None
    whole = all(power == int(power) for power in exponents.values())
    return {key: int(power) for key, power in exponents.items()} if whole else None


def _find_scale(shown: str, name: str) -> dict[str, str]:
    factor, offset = units.find_conversion(shown, name)
    scale = {"factor": repr(1.0 / factor)}
    return scale | ({"offset": repr(-offset / factor)} if offset else {})
