"""Controls of single entries for the page: numbers, options, texts, lists.

A slider covers a range about the value within the declared bounds, logarithmic for positive bounds over decades. A
value of 0 or without limit uses a typical size of its unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from martensite.app.forms.form_types import (
    DisplayUnit,
    EntryControl,
    MaterialValue,
    NumberNode,
    OptionNode,
    Origin,
    RowNode,
    SliderRange,
    TextNode,
)
from martensite.base import units
from martensite.base.errors import UnitError
from martensite.base.parameters import REQUIRED, FieldDeclaration
from martensite.physics.materials.base import DOUBTFUL, Material, MaterialNumber
from martensite.scenario.catalogue import describe_entry

ROUNDING = 1e-9
"""Relative rounding tolerance."""
_PRINTED = (("degC", "°C"), ("deg", "°"), ("ohm", "Ω"), ("^2", "²"), ("^3", "³"), ("^0.5", "^½"))
ORIGIN_WORDS = {
    "scenario": "written in the scenario",
    "default": "the default",
    "plant": "worked out from the plant",
    "start": "written in the scenario; the same as an assumed start value of this form, so no data",
    "none": "not given yet",
}
SIZES = {
    "1": 1.0,
    "N": 5.0,
    "V": 5.0,
    "A": 1.0,
    "W": 1.0,
    "m": 0.01,
    "s": 10.0,
    "ohm": 5.0,
    "Pa": 1e8,
    "kg": 0.5,
    "Hz": 10.0,
    "rad": 1.0,
    "delta_degC": 20.0,
    "J/kg": 3e4,
    "N/m": 500.0,
    "m/s": 1.0,
    "N*m": 0.05,
    "N*m/rad": 0.05,
    "N*m*s/rad": 1e-4,
    "W/m^2/K": 100.0,
    "Pa/K": 1e6,
    "m/s^2": 20.0,
}
"""Typical size by unit, for values of 0."""
KELVINS = 60.0
"""Half range of temperatures [K]."""
DECADES = 100.0
"""Smallest ratio of the ends of a logarithmic range."""
LARGEST = 1e6
"""Smallest default that means "without limit" if it is the largest allowed value."""
_COUNTS = re.compile(r"\bnumber of|how many|whole number|^spans\b|^steps of")


@dataclass(frozen=True)
class EntrySpot:
    """Place of an entry, and its data."""

    path: str
    """Path in the document."""
    name: str
    declared: FieldDeclaration
    origin: str
    """Origin of the value, as in `Scenario.origins`."""
    material: Material | None = None
    """Material that can provide the value."""

    def common(self, changed: bool = False) -> EntryControl:
        """Return the common data of all controls."""
        return {
            **describe_entry(self.name, self.declared),
            "path": self.path,
            "origin": describe_origin(self.origin, self.name, self.material),
            "changed": changed,
        }


def describe_number(spot: EntrySpot, value: float | None, unit: str) -> NumberNode:
    """Return the control of a number in an SI unit; None for a missing one."""
    declared = replace(spot.declared, unit=unit)
    default = None if declared.default is REQUIRED else declared.default
    size = None if value is None or is_unlimited(value, declared) else value
    own = spot.origin in ("scenario", "start")
    material = find_material_number(spot.material, spot.name) if own else None
    usual = default if material is None else material["value"]
    words = None if default is None else word_quantity(default, unit)
    changed = own and usual is not None and value is not None and not _is_same(value, usual)
    return {
        **spot.common(changed),
        "unit": unit,
        "allowed": word_range(declared),
        **describe_display(unit, size),
        "sort": "number",
        "value": value,
        "unlimited": value is not None and size is None,
        "usual": "no limit" if default is not None and is_unlimited(default, declared) else words,
        "slider": None if size is None else build_slider(size, declared),
        "material": material,
    }


def word_range(declared: FieldDeclaration) -> str:
    """Return the allowed range in words."""
    low, high = (word_quantity(bound, declared.unit) for bound in declared.bounds)
    least, most = f"{'above' if declared.open_low else 'at least'} {low}", f"at most {high}"
    if math.isinf(declared.low):
        return "any number" if math.isinf(declared.high) else most
    if math.isinf(declared.high):
        return least
    return f"{least} and {most}" if declared.open_low else f"between {low} and {high}"


def _is_same(one: float, other: float) -> bool:
    return one == other or abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def describe_option(spot: EntrySpot, value: str) -> OptionNode:
    """Return the control of a choice between words."""
    changed = spot.declared.default not in (REQUIRED, value)
    return {**spot.common(changed), "sort": "option", "value": value}


def describe_text(spot: EntrySpot, value: str | Sequence[str]) -> TextNode:
    """Return the control of one or several texts."""
    default = spot.declared.default
    return {
        **spot.common(default not in (REQUIRED, value)),
        "sort": "text",
        "several": isinstance(default, tuple) or not isinstance(value, str),
        "value": value if isinstance(value, str) else ", ".join(value),
    }


def describe_row(spot: EntrySpot, value: Any) -> RowNode:
    """Return the control of a list of numbers or quantities, or of an integer."""
    several = isinstance(value, (list, tuple))
    items = list(value) if several else [value]
    return {
        **spot.common(),
        "sort": "row",
        "several": several,
        "value": ", ".join("" if item is None else str(item) for item in items),
        "quantities": any(isinstance(item, str) for item in items),
    }


def print_unit(unit: str) -> str:
    """Return a readable unit, such as W/(m²·K); empty for 1."""
    text = {"1": "", units.DEGREES: "K"}.get(unit, unit)
    over, *under = text.split("/")
    below = "·".join(under)
    text = f"{over}/({below})" if len(under) > 1 else "/".join([over, *under])
    for spelled, read in _PRINTED:
        text = text.replace(spelled, read)
    return text.replace("*", "·")


def describe_display(unit: str, value: float | None = None) -> DisplayUnit:
    """Return the display of a number in an SI unit: spelling, label, factor and offset.

    displayed number = SI · factor + offset; the spelling is empty without a unit.
    """
    spelling = units.choose_readable_unit(unit) if value is None else units.choose_familiar_unit(value, unit)
    try:
        size, zero = units.find_conversion(spelling, unit)
    except UnitError:  # unknown unit of a plug-in: shown as written
        spelling, size, zero = unit, 1.0, 0.0
    spelled = "K" if spelling == units.DEGREES else spelling
    return {
        "display_unit": "" if spelling == "1" else spelled,
        "label": print_unit(spelling),
        "factor": 1.0 / size,
        "offset": -zero / size,
    }


def word_quantity(value: float, unit: str) -> str:
    """Return a number in SI as text, such as `75 GPa`."""
    how = describe_display(unit, value)
    return f"{value * how['factor'] + how['offset']:.6g} {how['label']}".strip()


def describe_origin(origin: str, name: str, material: Material | None) -> Origin:
    """Return the full origin of a value from its note in `Scenario.origins`.

    Its sort is scenario, default, plant, start, none, law or material; a material value also has kind, source and
    place.
    """
    kind, _, owner = origin.partition(", ")
    if not owner:
        return {"sort": kind, "words": ORIGIN_WORDS.get(kind, kind)}
    if kind == "law":
        return {"sort": "law", "words": f"of the law that material {owner} holds for"}
    if material is not None and material.name == owner and name in material.values:
        return describe_source(material, material.values[name])
    return {"sort": "material", "words": f"{kind}, material {owner}", "kind": kind}


def describe_source(material: Material, number: MaterialNumber) -> Origin:
    """Return the origin of a material value."""
    source = material.sources[number.source]
    return {
        "sort": "material",
        "words": f"{number.kind}, material {material.name}",
        "kind": number.kind,
        "doubtful": number.kind in DOUBTFUL,
        "source": source.text,
        "cite": source.cite,
        "where": number.where,
        "note": number.note,
    }


def find_material_number(material: Material | None, name: str) -> MaterialValue | None:
    """Return the material value of a parameter that the scenario sets, or None."""
    if material is None or name not in material.values:
        return None
    number = material.values[name]
    return {**describe_source(material, number), "text": number.text, "value": number.value}


def is_whole(value: float, declared: FieldDeclaration) -> bool:
    """Return whether a parameter is a count, by its description."""
    return declared.unit == "1" and value == int(value) and bool(_COUNTS.search(declared.doc))


def is_unlimited(value: float, declared: FieldDeclaration) -> bool:
    """Return whether a value means "without limit": infinite, or the largest by default."""
    largest = value == declared.high == declared.default and value >= LARGEST
    return not math.isfinite(value) or largest


def build_slider(value: float, declared: FieldDeclaration) -> SliderRange | None:
    """Return the ends of a slider in SI; None without a slider, as for a value without limit."""
    if is_unlimited(value, declared):
        return None
    low, high, log = _choose_ends(value, declared)
    low, high = max(low, declared.low), min(high, declared.high)
    if declared.open_low and low <= declared.low:
        low = declared.low + (high - declared.low) / 200.0
    if not low < high:
        return None
    whole = is_whole(value, declared)
    if whole:
        low, high = math.ceil(low), math.floor(high)
    return {"low": min(low, value), "high": max(high, value), "log": log, "whole": whole}


def _choose_ends(value: float, declared: FieldDeclaration) -> tuple[float, float, bool]:
    (low, high), unit = declared.bounds, declared.unit
    if unit == "K":
        return value - KELVINS, value + KELVINS, False
    if low < 0.0:
        return _choose_signed_ends(value, unit, low, high)
    if unit == "1" and high <= 1.0 and (not declared.open_low or value > high / 50.0):
        return low, high, False
    decades = declared.open_low if low == 0.0 else high >= DECADES * low
    if decades and value > 0.0:
        return value / 10.0, value * 10.0, True
    if math.isfinite(high) and high <= 20.0 * max(value, low):
        return low, high, False
    size = 3.0 * value if value > 0.0 else SIZES.get(unit, 1.0)
    return low, size, False


def _choose_signed_ends(value: float, unit: str, low: float, high: float) -> tuple[float, float, bool]:
    """Return the ends for a parameter that can be negative."""
    if math.isfinite(low) and math.isfinite(high) and high - low <= 20.0 * abs(value):
        return low, high, False
    size = 3.0 * abs(value) if value else SIZES.get(unit, 1.0)
    if math.isinf(low) and value >= 0.0:
        return 0.0, size, False
    return -size, size, False
