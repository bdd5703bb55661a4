"""Components from tables of text: one walk over the declarations.

A table holds a `kind` and the parameters of this kind. A component is a nested table, or its bare kind. Quantities with
a dimension are text with a unit. Missing numbers come from the material, by canonical name, then from the default; a
number that is missing everywhere is an error. The material may also name the law.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, cast

from martensite.actuators.elements.from_material import ASSUMED_KINDS
from martensite.base import units
from martensite.base.errors import InputError, ParameterError, UnitError, suggest_name
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised
from martensite.base.registry import Registry
from martensite.physics.materials.base import NAMES, Material
from martensite.scenario.components import component_class, convert_plain, is_members, is_plain
from martensite.scenario.place_units import PlaceUnits

Table = Mapping[str, Any]
LAW = "law"
"""Name of the component that a material may describe."""

FULLY_DESCRIBED = 3
"""Largest number of missing parameters that a message explains."""


@dataclass(frozen=True)
class Builder:
    """Builder of components from tables; `origins` gets the origin of each number."""

    material: Material | None = None
    """Source of missing numbers, for components built with `draws`."""
    scales: PlaceUnits = field(default_factory=PlaceUnits)
    """Units of signals and readings."""
    origins: dict[str, str] = field(default_factory=dict[str, str])
    """Origin by dotted path: `scenario`, `default`, or the kind of number and name of the material."""
    extra: tuple[str, ...] = ()
    """Keys of the outermost table that other code reads."""
    plain: bool = False
    """True if whole numbers and rows of numbers are possible parts."""
    ready_components: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Ready components of the outermost object."""

    def choose(self, registry: Registry[Any], table: Any, path: str, *, draws: bool = False) -> Any:
        """Build the component of `registry` that a table or bare kind describes."""
        full = as_table(table, path)
        return self.build(choose_class(registry, full, path), full, path, draws=draws)

    def build(self, cls: type[Parametrised], table: Table, path: str, *, draws: bool = False) -> Any:
        """Build a component of a class from its table."""
        if is_members(cls):
            return self._build_members(cls, table, path, draws)
        scales = self.scales.within(cls, table)
        if scales is not self.scales:
            return replace(self, scales=scales).build(cls, table, path, draws=draws)
        names = [name for name in _list_parts(cls) if name not in self.ready_components]
        children = {name: self._find_child(cls, name, table, path, draws) for name in names}
        self._refuse_unknown(cls, table, path, children)
        values, missing = self._collect_values(cls, table, path, children, draws)
        if missing:
            raise ParameterError(self._describe_missing(cls, missing, path, draws))
        with name_section(path):
            return cls(**values)

    def _collect_values(
        self, cls: type[Parametrised], table: Table, path: str, children: Mapping[str, Any], draws: bool
    ) -> tuple[dict[str, Any], list[str]]:
        """Return the arguments of a class by name, and the names of missing parameters."""
        values: dict[str, Any] = dict(self.ready_components)
        missing: list[str] = []
        for name, declared in cls.declarations.items():
            if name in children:
                self._add_part(values, name, declared, children[name], path, draws)
            elif declared.kind == "part":
                if self.plain and name in table and name not in self.ready_components:
                    values[name] = convert_plain(declared, name, table[name], path)
                    self.origins[f"{path}.{name}"] = "scenario"
            elif name in table:
                values[name] = self._convert_value(cls, name, declared, table[name], path)
                self.origins[f"{path}.{name}"] = self._find_writer(name, table, path, draws)
            elif draws and self.material and name in self.material.values:
                number = self.material.values[name]
                values[name] = number.text
                self.origins[f"{path}.{name}"] = f"{number.kind}, {self.material.name}"
            elif declared.default is REQUIRED:
                missing.append(name)
            else:
                self.origins[f"{path}.{name}"] = "default"
        return values, missing

    def _build_members(self, cls: Any, table: Table, path: str, draws: bool) -> Any:
        members: dict[str, Any] = {}
        for name, given in table.items():
            below, full = f"{path}.{name}", as_table(given, f"{path}.{name}")
            if cls.registry is None:
                members[name] = self.build(cls.kind, full, below, draws=draws)
            else:
                members[name] = self.choose(cls.registry, full, below, draws=draws)
        with name_section(path):
            return cls(**members)

    def _find_writer(self, name: str, table: Table, path: str, draws: bool) -> str:
        """Return the origin of a number of a table: the scenario, or the law of the material."""
        law = self.material.law if self.material and draws else None
        own = law is not None and path.rpartition(".")[2] == LAW and law.get(name) == table[name]
        return f"law, {self.material.name}" if own and self.material else "scenario"

    def _find_child(
        self, cls: type[Parametrised], name: str, table: Table, path: str, draws: bool
    ) -> tuple[type[Parametrised], Table] | None:
        """Return the class and table of a component, or None for its default."""
        declared = cls.declarations[name]
        given = table.get(name, ASSUMED_KINDS.get(name))
        if name == LAW and draws and self.material and self.material.law:
            given = self._merge_law(given, self.material.law, f"{path}.{name}")
        if declared.registry is None:
            child = component_class(cls, name)
            if child is None or (given is None and not isinstance(declared.default, Parametrised)):
                return None
            return child, (as_table(given, f"{path}.{name}") if given is not None else {})
        if given is None:
            return None
        full = as_table(given, f"{path}.{name}")
        if name in ASSUMED_KINDS:
            full = {"kind": ASSUMED_KINDS[name], **full}
        elif isinstance(declared.default, Parametrised):
            full = {"kind": declared.default.registered_name, **full}
        return choose_class(declared.registry, full, f"{path}.{name}"), full

    @staticmethod
    def _merge_law(given: Any, law: Table, path: str) -> Any:
        """Return the table of a law; without a kind, with the entries of the material."""
        if given is None:
            return law
        full = as_table(given, path)
        return full if "kind" in full else {**law, **full}

    def _add_part(
        self,
        values: dict[str, Any],
        name: str,
        declared: FieldDeclaration,
        child: tuple[type[Parametrised], Table] | None,
        path: str,
        draws: bool,
    ) -> None:
        if child is not None:
            below = replace(self, extra=(), ready_components={})
            values[name] = below.build(*child, f"{path}.{name}", draws=draws)
        elif declared.default is REQUIRED:
            kinds = declared.registry
            valid = f"Write a table [{path}.{name}]." if kinds is None else suggest_name("", kinds.names())
            raise ParameterError(f"[{path}] needs `{name}` ({declared.doc}). {valid}")

    def _convert_value(
        self, cls: type[Parametrised], name: str, declared: FieldDeclaration, value: Any, path: str
    ) -> Any:
        """Return the value for the constructor; text keeps its unit for messages."""
        if declared.kind in ("option", "text"):
            return value
        if declared.unit in units.OF_GAINS and not isinstance(value, str):
            return _convert_plain(value, name, "1", path)  # signal per SI unit
        with name_section(path):
            unit = self.scales.unit(declared)
        if not isinstance(value, str):
            return _convert_plain(value, name, unit, path)
        if unit == declared.unit:
            return value
        with name_section(path):
            return replace(declared, unit=unit).convert(_name_class(cls), name, value)

    def _refuse_unknown(
        self,
        cls: type[Parametrised],
        table: Table,
        path: str,
        children: Mapping[str, tuple[type[Parametrised], Table] | None],
    ) -> None:
        kind = ("kind",) if cls.registered_name else ()
        simple = [
            name
            for name, declared in cls.declarations.items()
            if declared.kind != "part" or name in children or (self.plain and is_plain(cls, name))
        ]
        valid = [*simple, *kind, *self.extra]
        unknown = next((key for key in table if key not in valid), None)
        if unknown is None:
            return
        for name, child in children.items():
            if child is not None and unknown in _list_declared(child[0]):
                raise ParameterError(
                    f"[{path}] `{_name_class(cls)}` has no `{unknown}`; it belongs to the {name}: "
                    f"write `{path}.{name}.{unknown}`, or `{unknown}` under [{path}.{name}]."
                )
        raise ParameterError(f"[{path}] `{_name_class(cls)}` has no `{unknown}`. {suggest_name(unknown, valid)}")

    def _describe_missing(self, cls: type[Parametrised], missing: list[str], path: str, draws: bool) -> str:
        brief = len(missing) > FULLY_DESCRIBED
        listed = ", ".join(self._describe_number(cls.declarations[name], name, brief) for name in missing)
        unit = self.scales.label(cls.declarations[missing[0]])
        sample = f'{missing[0]} = "… {unit}"' if unit else f"{missing[0]} = …"
        remedy = f"write `{sample}` in [{path}]"
        if draws and any(name in NAMES for name in missing):
            if self.material is None:
                remedy = f"name a `material` in [element], or {remedy}"
            else:
                remedy = f"material `{self.material.name}` does not hold it: {remedy}"
        return f"[{path}] `{_name_class(cls)}` needs {listed}; {remedy}."

    def _describe_number(self, declared: FieldDeclaration, name: str, brief: bool) -> str:
        unit = self.scales.label(declared) if declared.kind == "parameter" else ""
        unit = f" [{unit}]" if unit else ""
        return f"`{name}`{unit}" + ("" if brief else f" ({declared.doc})")


def _convert_plain(value: Any, name: str, unit: str, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ParameterError(f"[{path}] `{name}` must be a number or text, but is {value!r}.")
    if unit != "1":
        if not math.isfinite(value):
            raise ParameterError(f"[{path}] `{name}` must be a finite number with a unit, but is {value}.")
        label = units.choose_readable_unit(unit)
        raise UnitError(f'[{path}] `{name}` is {value} without a unit; write for example `{name} = "{value} {label}"`.')
    return float(value)


def _list_parts(cls: type[Parametrised]) -> Iterator[str]:
    for name, declared in cls.declarations.items():
        if declared.registry is not None or component_class(cls, name) is not None:
            yield name


def _list_declared(cls: type[Parametrised]) -> Collection[str]:
    """Return the declared entries of a class; empty if each instance has its own."""
    return () if isinstance(cls.declarations, property) else cls.declarations


def _name_class(cls: type[Parametrised]) -> str:
    return cls.registered_name or cls.__name__


def choose_class(registry: Registry[Any], table: Table, path: str) -> type[Parametrised]:
    """Return the class of a table.

    Raises:
        InputError: `kind` is missing or unknown.
    """
    if "kind" not in table:
        raise ParameterError(f"[{path}] needs `kind`. {suggest_name('', registry.names())}")
    with name_section(path):
        return registry[str(table["kind"])]


def as_table(value: Any, path: str) -> dict[str, Any]:
    """Return a table; text becomes its `kind`."""
    if isinstance(value, str):
        return {"kind": value}
    if not isinstance(value, dict):
        raise ParameterError(f"[{path}] must be a table or the name of a kind, but is {value!r}.")
    return cast("dict[str, Any]", value)


def refuse_unknown(keys: Iterable[str], valid: Iterable[str], where: str) -> None:
    """Raise `ParameterError` for the first key that is not valid."""
    names = list(valid)
    unknown = next((key for key in keys if key not in names), None)
    if unknown is not None:
        raise ParameterError(f"{where} has no `{unknown}`. {suggest_name(unknown, names)}")


@contextmanager
def name_section(path: str) -> Iterator[None]:
    """Put the section before the message of an error."""
    try:
        yield
    except InputError as error:
        error.args = (f"[{path}] {error}", *error.args[1:])
        raise
