"""Controls of single entries, as the page takes them: numbers, options, texts, lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.app.forms import origins, ranges, wording
from martensite.app.messages import JsonTable
from martensite.base.parameters import REQUIRED, Declared
from martensite.physics.materials.base import Material

Control = JsonTable
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

    def common(self, sort: str) -> Control:
        """What all controls have."""
        declared = self.declared
        return {
            "sort": sort,
            "path": self.path,
            "name": self.name,
            "title": wording.spell_title(self.name),
            "symbol": wording.spell_symbol(self.name),
            "meaning": declared.doc,
            "required": declared.default is REQUIRED,
            "origin": origins.describe_origin(self.noted, self.name, self.material),
        }


def describe_number(spot: EntrySpot, value: float | None, unit: str) -> Control:
    """A number in an SI unit, with its range; None for one that is not given yet."""
    declared, material = spot.declared, origins.find_material_number(spot.material, spot.name)
    default = None if declared.default is REQUIRED else declared.default
    endless = value is not None and ranges.is_unlimited(value, declared)
    size = None if endless else value
    own = spot.noted in ("scenario", "start")
    usual = material["value"] if material else default
    low, high = (b if math.isfinite(b) else None for b in declared.bounds)
    return {
        **spot.common("number"),
        **wording.describe_display(unit, size),
        "unit": unit,
        "value": value,
        "low": low,
        "high": high,
        "allowed": word_range(declared, unit),
        "default": default,
        "unlimited": endless,
        "usual": None if default is None else _word_default(default, declared, unit),
        "slider": None if size is None else ranges.build_slider(size, unit, declared),
        "material": material if own else None,
        "own": own,
        "changed": own and usual is not None and value is not None and not _is_same(value, usual),
    }


def _word_default(default: float, declared: Declared, unit: str) -> str:
    return (
        "no limit"
        if ranges.is_unlimited(default, declared)
        else wording.word_quantity(default, unit)
    )


def word_range(declared: Declared, unit: str) -> str:
    """The allowed range in words."""
    low, high = declared.bounds
    least = f"{'above' if declared.open_low else 'at least'} {wording.word_quantity(low, unit)}"
    most = f"at most {wording.word_quantity(high, unit)}"
    if math.isinf(low):
        return "any number" if math.isinf(high) else most
    if math.isinf(high):
        return least
    if declared.open_low:
        return f"{least} and {most}"
    return f"between {wording.word_quantity(low, unit)} and {wording.word_quantity(high, unit)}"


def _is_same(one: float, other: float) -> bool:
    return one == other or abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def describe_option(spot: EntrySpot, value: str) -> Control:
    """A choice between words."""
    default = None if spot.declared.default is REQUIRED else spot.declared.default
    return {
        **spot.common("option"),
        "value": value,
        "choices": list(spot.declared.choices),
        "default": default,
        "changed": default is not None and value != default,
    }


def describe_text(spot: EntrySpot, value: str | Sequence[str]) -> Control:
    """A free text, or several."""
    default = spot.declared.default
    several = isinstance(default, tuple) or not isinstance(value, str)
    return {
        **spot.common("text"),
        "several": several,
        "value": value if isinstance(value, str) else ", ".join(value),
        "changed": default is not REQUIRED and value != default,
    }


def describe_row(spot: EntrySpot, value: Any) -> Control:
    """A list of numbers or quantities, or a whole number, as the document holds it."""
    several = isinstance(value, (list, tuple))
    items = list(value) if several else [value]
    return {
        **spot.common("row"),
        "several": several,
        "changed": False,
        "value": ", ".join("" if item is None else str(item) for item in items),
        "quantities": any(isinstance(item, str) for item in items),
    }
