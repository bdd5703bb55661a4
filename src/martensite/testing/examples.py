"""Examples of any part, built from the typical values or defaults of its declarations."""

import contextlib
from collections.abc import Mapping
from functools import cache
from typing import Any, TypeVar, cast

from martensite.actuators.assembly import AbstractSystem, Members, System
from martensite.base import units
from martensite.base.errors import ParameterError, UnitError
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised
from martensite.base.part_kinds import find_annotated
from martensite.base.registry import Registry
from martensite.physics.electrical.sources import VoltageSource
from martensite.scenario.components import component_class, is_members
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH

Some = TypeVar("Some", bound=Parametrised)
LEVEL = {DRIVE: "V"}
"""SI unit of levels whose unit depends on the use."""


def build_example(cls: type[Some], /, **choices: Any) -> Some:
    """Return a part with typical values, except for the given choices.

    Raises:
        ParameterError: a required value has no typical value.
    """
    values = {name: _read_level(cls, name, one) for name, one in choices.items()}
    for name, declared in cls.declarations.items():
        if name not in values:
            values[name] = _find_value(cls, name, declared, values)
    return cls(**values)


@cache
def build_plant() -> System:
    """Return a wire of typical values under a voltage source, the plant for tests of loop parts."""
    return build_example(System, source=VoltageSource())


def list_variants(cls: type[Some], **choices: Any) -> list[Some]:
    """Return an example of a part, and one for each other choice of each option."""
    options = {n: d for n, d in cls.declarations.items() if d.kind == "option" and n not in choices}
    usual = {n: d.typical if d.default is REQUIRED else d.default for n, d in options.items()}
    others = [usual | {n: w} for n, d in options.items() for w in d.choices if w != usual[n]]
    return [build_example(cls, **choices, **words) for words in (usual, *others)]


def label_part(part: Parametrised) -> str:
    """Return the name and options of a part."""
    words = [getattr(part, n) for n, d in part.declarations.items() if d.kind == "option"]
    return "-".join([type(part).registered_name or type(part).__name__, *words])


def _find_value(cls: type[Parametrised], name: str, declared: FieldDeclaration, values: Mapping[str, Any]) -> Any:
    unit = LEVEL.get(declared.unit, declared.unit)
    if unit in units.OF_READINGS:  # a controller follows a position, the others look at kelvin
        place = "m" if "position" in (values.get(n) for n in cls.names_reading) else "K"
        unit = f"{place}/s" if unit == units.RATE else place
    typical = declared.typical_in("V" if declared.kind == "part" else unit)
    if declared.kind == "part":
        return _find_part(cls, name, declared, typical)
    if declared.kind == "option":
        return typical if declared.default is REQUIRED else declared.default
    if isinstance(typical, str) and typical.startswith("="):
        return values[typical[1:]]
    if typical is not None:
        return _to_number(typical, unit) if declared.kind == "parameter" else typical
    if declared.default is not REQUIRED:
        return declared.default
    word, sort = ("param", "number") if declared.kind == "parameter" else ("text", "text")
    raise ParameterError(
        f"`{name}` of `{cls.__name__}` has neither a default nor a typical {sort}, so that no "
        f"example can be made; declare one: {word}(..., typical=…)."
    )


def _read_level(cls: type[Parametrised], name: str, value: Any) -> Any:
    """Return a choice, converted to SI if it is text for a level with a dependent unit."""
    declared = cls.declarations.get(name)
    if isinstance(value, str) and declared is not None and declared.unit in units.OF_READINGS:
        for unit in (one for one in HIGH if one not in ("1", "delta_degC")):
            with contextlib.suppress(UnitError):
                return units.parse_quantity(value, unit)
    return value


def _to_number(typical: Any, unit: str) -> float:
    if not isinstance(typical, str):
        return float(typical)
    return units.parse_quantity(typical, unit)


def _find_part(cls: type[Parametrised], name: str, declared: FieldDeclaration, typical: Any) -> Any:
    """Return a component: typical, default, or an example of its class."""
    inner = component_class(cls, name)
    if declared.typical is None and declared.default is not REQUIRED:
        return declared.default
    if isinstance(typical, tuple):
        return tuple(_to_number(one, _unit_of(one)) for one in cast("tuple[Any, ...]", typical))
    if typical is not None:
        return _build_typical(typical, declared.registry, inner)
    named = [one for one in find_annotated(cls, name) if issubclass(one, Parametrised)] or [cls]
    if issubclass(named[0], AbstractSystem):
        return build_plant()
    if inner is None or is_members(inner):
        raise ParameterError(
            f'`{name}` of `{cls.__name__}` has no typical component; give one, or declare it: part(..., typical="…").'
        )
    return build_example(inner)


def _unit_of(value: Any) -> str:
    return value.partition(" ")[2] or "1" if isinstance(value, str) else "1"


def _build_typical(typical: Any, registry: Registry[Any] | None, inner: type[Parametrised] | None) -> Any:
    """Return a component from a name or a table in the form of scenario files."""
    table: dict[str, Any] = {"kind": typical} if isinstance(typical, str) else dict(typical)
    if registry is not None:
        return build_example(registry[table.pop("kind")], **table)
    if inner is None:
        return typical
    if not issubclass(inner, Members):
        return build_example(inner, **table)
    kinds = inner.registry
    return inner(**{name: _build_typical(one, kinds, inner.kind) for name, one in table.items()})
