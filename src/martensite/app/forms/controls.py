"""Controls of single entries, as the page takes them: numbers, options, texts, lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from martensite.app.forms import wording
from martensite.app.forms.form_types import EntryControl, NumberNode, OptionNode, RowNode, TextNode
from martensite.app.forms.origins import describe_origin, find_material_number
from martensite.app.forms.ranges import build_slider, is_unlimited
from martensite.base.parameters import REQUIRED, Declared
from martensite.physics.materials.base import Material
from martensite.scenario.catalogue import describe_entry

ROUNDING = 1e-9
"""Relative difference that is rounding."""


@dataclass(frozen=True)
class EntrySpot:
    """Where an entry stands, and what is known of it there."""

    path: str
    """In the document."""
    name: str
    declared: Declared
    noted: str
    """Its origin, as `Scenario.origins` notes it."""
    material: Material | None = None
    """What it may draw on."""

    def common(self, changed: bool = False) -> EntryControl:
        """What all controls have."""
        return {
            **describe_entry(self.name, self.declared),
            "path": self.path,
            "origin": describe_origin(self.noted, self.name, self.material),
            "changed": changed,
        }


def describe_number(spot: EntrySpot, value: float | None, unit: str) -> NumberNode:
    """A number in an SI unit, with its range; None for one that is not given yet."""
    declared = replace(spot.declared, unit=unit)
    default = None if declared.default is REQUIRED else declared.default
    size = None if value is None or is_unlimited(value, declared) else value
    own = spot.noted in ("scenario", "start")
    material = find_material_number(spot.material, spot.name) if own else None
    usual = default if material is None else material["value"]
    changed = own and usual is not None and value is not None and not _is_same(value, usual)
    return {
        **spot.common(changed),
        "unit": unit,
        "allowed": word_range(declared),
        **wording.describe_display(unit, size),
        "sort": "number",
        "value": value,
        "unlimited": value is not None and size is None,
        "usual": None if default is None else _word_default(default, declared),
        "slider": None if size is None else build_slider(size, declared),
        "material": material,
    }


def _word_default(default: float, declared: Declared) -> str:
    unlimited = is_unlimited(default, declared)
    return "no limit" if unlimited else wording.word_quantity(default, declared.unit)


def word_range(declared: Declared) -> str:
    """The allowed range in words."""
    low, high = (wording.word_quantity(bound, declared.unit) for bound in declared.bounds)
    least, most = f"{'above' if declared.open_low else 'at least'} {low}", f"at most {high}"
    if math.isinf(declared.low):
        return "any number" if math.isinf(declared.high) else most
    if math.isinf(declared.high):
        return least
    return f"{least} and {most}" if declared.open_low else f"between {low} and {high}"


def _is_same(one: float, other: float) -> bool:
    return one == other or abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def describe_option(spot: EntrySpot, value: str) -> OptionNode:
    """A choice between words."""
    changed = spot.declared.default not in (REQUIRED, value)
    return {**spot.common(changed), "sort": "option", "value": value}


def describe_text(spot: EntrySpot, value: str | Sequence[str]) -> TextNode:
    """A free text, or several."""
    default = spot.declared.default
    return {
        **spot.common(default not in (REQUIRED, value)),
        "sort": "text",
        "several": isinstance(default, tuple) or not isinstance(value, str),
        "value": value if isinstance(value, str) else ", ".join(value),
    }


def describe_row(spot: EntrySpot, value: Any) -> RowNode:
    """A list of numbers or quantities, or a whole number, as the document holds it."""
    several = isinstance(value, (list, tuple))
    items = list(value) if several else [value]
    return {
        **spot.common(),
        "sort": "row",
        "several": several,
        "value": ", ".join("" if item is None else str(item) for item in items),
        "quantities": any(isinstance(item, str) for item in items),
    }
