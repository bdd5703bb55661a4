"""Variables of an FMU: inputs, outputs and parameters, with permanent value references.

A value reference is its kind times 100000 plus the index within the kind: inputs from 0, outputs from 100000,
parameters from 200000, time 300000, the inner step 300001.
The index of a parameter counts all parameters of the system, including hidden ones.

A unit has exponents of SI base units, and a display unit: displayed value = factor * value + offset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from martensite.base import units
from martensite.base.errors import UnitError
from martensite.export.fmu.plan import CONSTANT, HIDDEN, FmuPlan, ModelNumber

KIND = 100_000
TIME, INNER = 3 * KIND, 3 * KIND + 1


@dataclass(frozen=True)
class FmuVariable:
    """One variable of a model description."""

    name: str
    reference: int
    causality: str
    """Input, output, parameter, or local for a constant."""
    variability: str
    words: str
    declared: str
    """Declared unit."""
    start: float | None = None
    """None if calculated."""
    low: float = -math.inf
    high: float = math.inf

    @property
    def unit(self) -> str | None:
        """Return the SI unit, or None."""
        return unit_of(self.declared)

    @property
    def display(self) -> str | None:
        """Return the display unit if it differs from the unit, else None."""
        return display_of(self.declared)


def list_variables(plan: FmuPlan) -> tuple[FmuVariable, ...]:
    """Return inputs, outputs, parameters and the inner step."""
    pace = "discrete" if plan.period else "continuous"
    variables = [
        FmuVariable(one.name, one.index, "input", pace, one.words, one.unit, start)
        for one, start in zip(plan.core.inputs, plan.first, strict=True)
    ]
    taken = {one.name for one in variables}
    for one in plan.core.outputs:
        name = _free_name(one.name, "echo", taken)
        variables.append(FmuVariable(name, KIND + one.index, "output", pace, one.words, one.unit))
    for place, number in enumerate(plan.numbers):
        if number.kind != HIDDEN:
            name = _free_name(number.name, "parameter", taken)
            variables.append(_describe_parameter(name, 2 * KIND + place, number))
    if not plan.period:
        name = _free_name("inner_step", "parameter", taken)
        words = "longest step of the model within a step of the co-simulation (above 0)"
        variables.append(FmuVariable(name, INNER, "parameter", "fixed", words, "s", plan.step, 0.0))
    return tuple(variables)


def _describe_parameter(name: str, reference: int, number: ModelNumber) -> FmuVariable:
    declared, value = number.leaf.declared, float(number.leaf.value)
    if number.kind == CONSTANT:
        words = f"{declared.doc}; constant, for it decides what the program is"
        return FmuVariable(name, reference, "local", "constant", words, number.unit, value)
    low, high = declared.bounds
    words = f"{declared.doc} (above {low:g})" if declared.open_low else declared.doc
    return FmuVariable(name, reference, "parameter", "fixed", words, number.unit, value, low, high)


def _free_name(name: str, suffix: str, taken: set[str]) -> str:
    """Return a free name, and add it to `taken`: `drive_echo` for an output with the name of an input."""
    while name in taken:
        name = f"{name}_{suffix}"
    taken.add(name)
    return name


def unit_of(declared: str) -> str | None:
    """Return the unit's name in a model description, or None without a unit."""
    if declared == units.DEGREES:
        return "K"
    return None if declared in ("", "of the reading", *units.OF_READINGS) else declared


def display_of(declared: str) -> str | None:
    """Return the readable unit of a quantity if it differs, else None."""
    display_unit = units.choose_readable_unit(declared)
    return None if declared == units.DEGREES or display_unit == declared else display_unit


def add_units(parent: Element, names: list[str]) -> None:
    """Add the definitions of units to an element."""
    definitions = SubElement(parent, "UnitDefinitions")
    for name in names:
        unit = SubElement(definitions, "Unit", name=name)
        exponents = base_units(name)
        if exponents is not None:
            SubElement(unit, "BaseUnit", {key: str(power) for key, power in exponents.items()})
        display_unit = display_of(name)
        if display_unit is not None:
            SubElement(unit, "DisplayUnit", {"name": display_unit, **_find_scale(display_unit, name)})


def base_units(name: str) -> dict[str, int] | None:
    """Return the exponents of base units; None if unknown or fractional."""
    try:
        exponents = units.find_dimensions(name)
    except UnitError:
        return None
    whole = all(power == int(power) for power in exponents.values())
    return {key: int(power) for key, power in exponents.items()} if whole else None


def _find_scale(display_unit: str, name: str) -> dict[str, str]:
    factor, offset = units.find_conversion(display_unit, name)
    scale = {"factor": repr(1.0 / factor)}
    return scale | ({"offset": repr(-offset / factor)} if offset else {})
