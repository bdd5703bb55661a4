"""Descriptions of registered parts: what `laws`, `mechanisms` and `params` print."""

from __future__ import annotations

import inspect
import math
import sys
from typing import Any

from martensite.cli import show
from martensite.errors import UnknownNameError
from martensite.parameters import REQUIRED, Declared, Parametrised
from martensite.registry import Registry
from martensite.signals.base import DRIVE
from martensite.units import OF_READINGS


def registries(blocks: bool = False) -> dict[str, Registry[Any]]:
    """Every registry of parts, by the word for one of its entries, and that of blocks if wanted.

    Blocks of identified models are no parts of a scenario, and load NumPy, which takes longer than
    all the rest.
    """
    from martensite.bench.faults.base import FAULTS
    from martensite.bench.supervisor import SUPERVISORS
    from martensite.bench.supervisors.checks.base import CHECKS
    from martensite.controllers.base import CONTROLLERS
    from martensite.electrical.base import RESISTANCES, SOURCES
    from martensite.elements.base import ELEMENTS
    from martensite.laws.base import LAWS
    from martensite.mechanisms.base import MECHANISMS
    from martensite.observers.base import OBSERVERS
    from martensite.sensors.base import SENSORS
    from martensite.signals.base import WAVEFORMS
    from martensite.thermal.base import COOLING
    from martensite.thermal.ends import ENDS
    from martensite.thermal.fluids.base import FLUIDS

    found: list[Registry[Any]] = [
        ELEMENTS, ENDS, LAWS, RESISTANCES, COOLING, FLUIDS, MECHANISMS, SOURCES, WAVEFORMS, SENSORS,
        OBSERVERS, CONTROLLERS, SUPERVISORS, CHECKS, FAULTS,
    ]  # fmt: skip
    if blocks:
        from martensite.identify.blocks.base import BLOCKS

        found.append(BLOCKS)
    return {registry.kind: registry for registry in found}


def summary(cls: type[Parametrised]) -> str:
    """First line of the class's description."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def described(kind: str, cls: type[Parametrised]) -> dict[str, Any]:
    """Everything about a registered class, ready for JSON."""
    return {
        "name": cls.registered_name,
        "kind": kind,
        "summary": summary(cls),
        "description": inspect.getdoc(sys.modules[cls.__module__]) or "",
        "cites": list(cls.cites),
        "parameters": [_declared(name, d) for name, d in cls.declarations.items()],
    }


def _declared(name: str, declared: Declared) -> dict[str, Any]:
    required = declared.default is REQUIRED
    default = None if required else declared.default
    if isinstance(default, Parametrised):
        default = default.registered_name or type(default).__name__
    low, high = (v if math.isfinite(v) else None for v in declared.bounds)
    return {
        "name": name,
        "unit": declared.unit if declared.kind == "parameter" else None,
        "meaning": declared.doc,
        "allowed": _allowed(declared),
        "low": low,
        "high": high,
        "required": required,
        "default": default,
    }


def _allowed(declared: Declared) -> str:
    if declared.unit == DRIVE:
        return "any level in the unit of the source"
    if declared.unit in OF_READINGS:
        return f"{declared.allowed()}, in the unit of the reading"
    if declared.kind == "parameter":
        return declared.allowed()
    if declared.kind == "option":
        return " | ".join(declared.choices)
    if declared.kind == "text":
        return "text, or a list of texts" if isinstance(declared.default, tuple) else "text"
    if declared.registry is None:
        return "table" if isinstance(declared.default, Parametrised) else "list"
    return " | ".join(declared.registry.names())


def one(registry: Registry[Any], name: str) -> dict[str, Any]:
    """The description of one entry of a registry."""
    return described(registry.kind, registry[name])


def anywhere(name: str) -> list[dict[str, Any]]:
    """Descriptions of all entries of that name, in whichever registry; at least one."""
    known = registries(blocks=True).values()
    found = [one(registry, name) for registry in known if name in registry.names()]
    if not found:
        every = {entry for registry in known for entry in registry.names()}
        raise UnknownNameError("part", name, every)
    return found


def print_part(part: dict[str, Any]) -> None:
    """Print a description with its table of parameters and the works it rests on."""
    from martensite.io import citations

    show.text(f"{part['kind']} {part['name']}: {part['summary']}", "bold")
    show.text()
    show.text(str(part["description"]))
    rows = [_row(entry) for entry in part["parameters"]]
    show.table(("parameter", "unit", "meaning", "allowed", "default"), rows)
    for key in part["cites"]:
        known = key in citations.bibliography()
        show.text(f"Source: {citations.title(key) if known else 'not in the bibliography'} [{key}]")


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
    rows = [(name, summary(registry[name])) for name in registry.names()]
    show.table((registry.kind, "what it is"), rows)


def listed(registry: Registry[Any]) -> list[dict[str, str]]:
    """Names and summaries of a registry, ready for JSON."""
    return [{"name": name, "summary": summary(registry[name])} for name in registry.names()]
