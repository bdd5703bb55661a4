"""Descriptions of registered parts: what `laws`, `mechanisms` and `params` print."""

from __future__ import annotations

import math
from typing import Any

from martensite.base.errors import UnknownNameError
from martensite.base.registry import Registry
from martensite.base.units import OF_READINGS
from martensite.cli import show
from martensite.scenario.catalogue import describe_class, list_registries, summarise_class
from martensite.signals.base import DRIVE


def one(registry: Registry[Any], name: str) -> dict[str, Any]:
    """The description of one entry of a registry."""
    return describe_class(registry.kind, registry[name])


def anywhere(name: str) -> list[dict[str, Any]]:
    """Descriptions of all entries of that name, in whichever registry; at least one."""
    known = list_registries(blocks=True).values()
    found = [one(registry, name) for registry in known if name in registry.names()]
    if not found:
        every = {entry for registry in known for entry in registry.names()}
        raise UnknownNameError("part", name, every)
    return found


def print_part(part: dict[str, Any]) -> None:
    """Print a description with its table of parameters and the works it rests on."""
    from martensite.scenario import citations

    show.text(f"{part['kind']} {part['name']}: {part['summary']}", "bold")
    show.text()
    show.text(str(part["description"]))
    rows = [_row(entry) for entry in part["parameters"]]
    show.table(("parameter", "unit", "meaning", "allowed", "default"), rows)
    for key in part["cites"]:
        known = key in citations.read_bibliography()
        show.text(
            f"Source: {citations.read_title(key) if known else 'not in the bibliography'} [{key}]"
        )


def _row(entry: dict[str, Any]) -> tuple[str, ...]:
    unit = entry["unit"] or ""
    return entry["name"], unit, entry["meaning"], entry["allowed"], default_of(entry)


def default_of(entry: dict[str, Any]) -> str:
    """The default of a described parameter, in a readable unit if it is known."""
    default = entry["default"]
    if not isinstance(default, float):
        return "required" if entry["required"] else str(default)
    if entry["unit"] in OF_READINGS and default and math.isfinite(default):
        return f"{default:g} in SI"
    placed = entry["unit"] in (DRIVE, *OF_READINGS)
    return show.quantity(default, "1" if placed else entry["unit"])


def print_list(registry: Registry[Any]) -> None:
    """Print the names of a registry with one line each."""
    rows = [(name, summarise_class(registry[name])) for name in registry.names()]
    show.table((registry.kind, "what it is"), rows)


def listed(registry: Registry[Any]) -> list[dict[str, str]]:
    """Names and summaries of a registry, ready for JSON."""
    return [{"name": name, "summary": summarise_class(registry[name])} for name in registry.names()]
