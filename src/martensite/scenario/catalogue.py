"""Catalogue of registered parts and their declarations, for the command line, the web bench and the reference pages."""

from __future__ import annotations

import inspect
import math
import sys
from typing import Any, TypedDict

from martensite.base.errors import UnknownNameError
from martensite.base.formats import spell_symbol, spell_title
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised
from martensite.base.registry import Registry
from martensite.base.units import OF_LOOPS, OF_READINGS
from martensite.signals.base import DRIVE


class EntryDescription(TypedDict):
    """Declaration of an entry of a part."""

    name: str
    declares: str
    """parameter, option, text or part."""
    title: str
    """Name in words."""
    symbol: str
    """Symbol with `_` before its index; empty for a word."""
    meaning: str
    unit: str | None
    """SI unit of a parameter."""
    low: float | None
    high: float | None
    """Bounds in SI; null for none."""
    allowed: str
    choices: list[str]
    """Allowed names of an option or registered part."""
    required: bool
    default: Any
    """Default value; null for a required entry or an unlimited value."""
    typical: Any
    """Assumed typical value as files write it, or null."""


class NamedPart(TypedDict):
    """Name and summary of a registered part."""

    name: str
    summary: str


class PartDescription(NamedPart):
    """Full declaration of a registered part."""

    kind: str
    description: str
    cites: list[str]
    parameters: list[EntryDescription]


LISTS = "`martensite list` lists them by kind"
"""Hint for messages about unknown names."""


def list_registries(blocks: bool = False) -> dict[str, Registry[Any]]:
    """Return every registry by the word for one of its entries.

    `blocks` adds blocks and measures, which are no parts of a scenario and load NumPy.
    """
    from martensite.actuators.elements.base import ELEMENTS
    from martensite.actuators.mechanisms.base import MECHANISMS
    from martensite.control.checks.base import CHECKS
    from martensite.control.controllers.base import CONTROLLERS
    from martensite.control.faults.base import FAULTS
    from martensite.control.loop.parts import SUPERVISORS
    from martensite.control.observers.base import OBSERVERS
    from martensite.control.sensors.base import SENSORS
    from martensite.physics.electrical.base import RESISTANCES, SOURCES
    from martensite.physics.fluids.base import FLUIDS
    from martensite.physics.laws.base import LAWS
    from martensite.physics.thermal.base import COOLING
    from martensite.physics.thermal.ends import ENDS
    from martensite.signals.base import WAVEFORMS

    registries: list[Registry[Any]] = [
        ELEMENTS,
        ENDS,
        LAWS,
        RESISTANCES,
        COOLING,
        FLUIDS,
        MECHANISMS,
        SOURCES,
        WAVEFORMS,
        SENSORS,
        OBSERVERS,
        CONTROLLERS,
        SUPERVISORS,
        CHECKS,
        FAULTS,
    ]
    if blocks:
        from martensite.identify.blocks.base import BLOCKS
        from martensite.simulate.measures.base import MEASURES

        registries += [BLOCKS, MEASURES]
    return {registry.kind: registry for registry in registries}


def find_registry(kind: str) -> Registry[Any]:
    """Return the registry of a kind of parts; the kind may be a plural.

    Raises:
        UnknownNameError: the kind does not exist.
    """
    registries = list_registries(blocks=True)
    for one in (kind, kind.removesuffix("s")):
        if one in registries:
            return registries[one]
    raise UnknownNameError("kind of part", kind, registries)


def summarise_class(cls: type[Any]) -> str:
    """Return the first line of the description of a class."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def describe_words(cls: type[Any]) -> str:
    """Return the description of the module of a class, then the details of the class."""
    own = (inspect.getdoc(cls) or "").partition("\n\n")[2]
    return "\n\n".join(filter(None, (inspect.getdoc(sys.modules[cls.__module__]), own)))


def list_named(registry: Registry[Any]) -> list[NamedPart]:
    """Return the names and summaries of the parts of a registry."""
    return [{"name": name, "summary": summarise_class(registry[name])} for name in registry.names()]


def describe_class(kind: str, cls: type[Parametrised]) -> PartDescription:
    """Return the declaration of a registered class as plain values."""
    return {
        "name": cls.registered_name,
        "kind": kind,
        "summary": summarise_class(cls),
        "description": describe_words(cls),
        "cites": list(cls.cites),
        "parameters": [describe_entry(name, d) for name, d in cls.declarations.items()],
    }


def describe_entry(name: str, declared: FieldDeclaration) -> EntryDescription:
    """Return the declaration of one entry as plain values."""
    required = declared.default is REQUIRED
    default = None if required else declared.default
    if isinstance(default, Parametrised):
        default = default.registered_name or type(default).__name__
    low, high = (v if math.isfinite(v) else None for v in declared.bounds)
    registry = declared.registry
    return {
        "name": name,
        "declares": declared.kind,
        "title": spell_title(name),
        "symbol": spell_symbol(name),
        "meaning": declared.doc,
        "unit": declared.unit if declared.kind == "parameter" else None,
        "low": low,
        "high": high,
        "allowed": _describe_allowed(declared),
        "choices": list(declared.choices) if registry is None else registry.names(),
        "required": required,
        "default": default,
        "typical": declared.typical,
    }


def _describe_allowed(declared: FieldDeclaration) -> str:
    if declared.unit == DRIVE:
        return "any level in the unit of the source"
    if declared.unit in OF_LOOPS:
        return f"{declared.describe_range()}, in units of signal and reading"
    if declared.unit in OF_READINGS:
        return f"{declared.describe_range()}, in the unit of the reading"
    if declared.kind == "parameter":
        return declared.describe_range()
    if declared.kind == "option":
        return " | ".join(declared.choices)
    if declared.kind == "text":
        return "text, or a list of texts" if isinstance(declared.default, tuple) else "text"
    if declared.registry is None:
        return "table" if declared.default is None or isinstance(declared.default, Parametrised) else "list"
    return " | ".join(declared.registry.names())
