"""The unit of a declared parameter is one of the quantity that its meaning names.

Source of truth: the dimensions of the quantities in the International System of Units. `params`, forms and the
reference pages show a meaning and a value on one line, so a wrong unit makes a resistance of a temperature.
"""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from pkgutil import walk_packages

import martensite
from martensite.base.parameters import FieldDeclaration, Parametrised
from martensite.base.units import DEGREES, DIFFERENCE

UNITS = {
    "temperature": ("K", DEGREES),
    "surroundings": ("K", DEGREES),
    "time": ("s",),
    "resistance": ("ohm", "ohm/m"),
    "resistivity": ("ohm*m",),
    "voltage": ("V",),
    "current": ("A",),
    "power": ("W",),
    "force": ("N",),
    "stress": ("Pa",),
    "modulus": ("Pa", "Pa/K"),
    "pressure": ("Pa",),
    "length": ("m", "s"),
    "diameter": ("m",),
    "mass": ("kg",),
    "frequency": ("Hz",),
    "angle": ("rad",),
    "inertia": ("kg*m^2",),
}
"""Last word of a quantity -> units that it may have."""
SPREAD = re.compile(r"^(standard deviation|tolerance|shift) of (the )?")
END = re.compile(
    r"[,;:(]| (?:of|at|to|from|in|on|for|by|below|above|up|that|which|when|while|if|as|between|after|between)\b"
)
RATIO = re.compile(r" (?:over|per)\b")
PARTS = ("actuators", "control", "physics", "scenario", "signals", "simulate")
"""Packages whose parameters have physical units; blocks that are identified have those of a record."""


@cache
def list_declared() -> tuple[tuple[str, FieldDeclaration], ...]:
    """Name and declaration of every parameter of the package."""
    for module in walk_packages(martensite.__path__, "martensite."):
        if module.name.split(".")[1] in PARTS:
            import_module(module.name)
    classes, found = [Parametrised], dict[type[Parametrised], None]()
    while classes:
        found[cls := classes.pop()] = None
        classes += cls.__subclasses__()
    ours = tuple(f"martensite.{name}." for name in PARTS)
    return tuple(
        (f"{cls.__name__}.{name}", one)
        for cls in found
        if cls.__module__.startswith(ours) and isinstance(cls.declarations, dict)
        for name, one in cls.declarations.items()
        if one.kind == "parameter" and name in cls.__annotations__
    )


def name_quantity(meaning: str) -> str:
    """The last word of the quantity that a meaning begins with; empty for a ratio."""
    head = END.split(SPREAD.sub("", meaning), maxsplit=1)[0]
    return "" if RATIO.search(head) or not head.split() else head.split()[-1]


def is_wrong(one: FieldDeclaration) -> bool:
    """Return whether the unit does not fit the quantity that the meaning names."""
    quantity = name_quantity(one.doc)
    return quantity in UNITS and one.unit not in UNITS[quantity]


def test_units_are_those_of_the_quantities_that_are_named() -> None:
    assert sum(name_quantity(one.doc) in UNITS for _, one in list_declared()) > 100
    assert [(name, one.unit, one.doc) for name, one in list_declared() if is_wrong(one)] == []


def test_a_meaning_names_its_quantity() -> None:
    """It is read alone, on its line of a table: `its`, `of` and `the same` point to a line that is not there."""
    words = ("its ", "their ", "the same ", "it ", "of ")
    assert [name for name, one in list_declared() if one.doc.lower().startswith(words)] == []


def test_no_default_is_the_absolute_zero() -> None:
    """A temperature of 0 K that stands for `not given` is shown as -273.15 degC."""
    assert [name for name, one in list_declared() if one.unit == "K" and one.default == 0.0] == []


def test_a_spread_of_a_temperature_in_ohm_is_found() -> None:
    assert is_wrong(FieldDeclaration("parameter", "standard deviation of the soak temperature", 7.0, DIFFERENCE))
    assert not is_wrong(FieldDeclaration("parameter", "standard deviation of the soak temperature", 7.0, DEGREES))
