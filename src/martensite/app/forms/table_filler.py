"""Tables of new components: matching values are kept, missing ones are filled in.

A table for a new kind keeps values of the same name and unit, options with a known word, and components of the same
registry. Other required values come from the material or the start values, or are recorded as missing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

from martensite.actuators.elements.from_material import ASSUMED_KINDS
from martensite.app.messages import JsonTable
from martensite.base.errors import InputError
from martensite.base.parameters import REQUIRED, FieldDeclaration, Leaf, Parametrised
from martensite.base.registry import Registry
from martensite.physics.materials.base import NAMES, Material
from martensite.scenario.build import LAW
from martensite.scenario.components import component_class, is_members
from martensite.signals.base import DRIVE

KIND = "kind"
PartClass = type[Parametrised]
Kinds = Registry[Any] | None
Entries = dict[str, tuple[Any, FieldDeclaration]]
"""Values by name, with their declarations."""


@dataclass(frozen=True)
class MissingNumber:
    """A value without material and start value."""

    path: str
    name: str
    declared: FieldDeclaration
    unit: str
    owner: str
    """Kind that needs it."""


@dataclass
class ChangedScenario:
    """A document with another kind in it."""

    document: JsonTable
    notes: list[str] = field(default_factory=list[str])
    assumed: list[str] = field(default_factory=list[str])
    """Paths of start values."""
    missing: list[MissingNumber] = field(default_factory=list[MissingNumber])


@dataclass
class TableFiller:
    """Filler of tables that records assumed and missing values."""

    unit: Callable[[Leaf], str] = lambda leaf: leaf.declared.unit
    """SI unit of a number at a path of the document."""
    material: Material | None = None
    """Material that can provide values."""
    elsewhere: tuple[str, ...] = ()
    """Entries that are not filled."""
    fresh: bool = False
    """True if components are recreated instead of becoming part of a bundle."""
    assumed: list[str] = field(default_factory=list[str])
    missing: list[MissingNumber] = field(default_factory=list[MissingNumber])

    def table(
        self, cls: PartClass, registry: Kinds, old: JsonTable, path: str, was: PartClass | None = None
    ) -> JsonTable:
        """Return the completed table of a class, from the table of the same or another class."""
        was = was or cls
        table: JsonTable = {KIND: cls.registered_name} if registry is not None else {}
        if was is cls:
            table |= {key: value for key, value in old.items() if key not in cls.declarations}
        spread = self._collect_entries(old, was, registry)
        for name, declared in cls.declarations.items():
            below = f"{path}.{name}"
            if name in self.elsewhere:
                previous = old.get(name)
            elif declared.kind == "part":
                previous = self._fill_part(cls, registry, name, old, below, was)
            else:
                previous = self._fill_single(cls, registry, name, declared, spread, below)
            if previous is not None:
                table[name] = previous
        return table

    def _collect_entries(self, old: JsonTable, was: PartClass, registry: Kinds) -> Entries:
        """Return the entries by name with their declarations, including those of a component of the same registry."""
        entries: Entries = {}
        for name, declared in was.declarations.items():
            if name not in old:
                continue
            if registry is not None and declared.registry is registry:
                inner = read_kind(old[name])
                if KIND in inner:
                    entries = {**self._collect_entries(inner, registry[str(inner[KIND])], registry), **entries}
            else:
                entries[name] = old[name], declared
        return entries

    def _fill_single(
        self, cls: PartClass, registry: Kinds, name: str, declared: FieldDeclaration, old: Entries, path: str
    ) -> Any:
        """Return the value of a number, option or text; None if it can be omitted."""
        if name in old and self._can_keep(declared, *old[name], path):
            return old[name][0]
        if declared.default is not REQUIRED:
            return None
        if self.material is not None and name in self.material.values:
            return None
        unit = self.unit(Leaf(path, declared, None))
        owner = cls.registered_name or cls.__name__
        value = declared.typical_in(unit)
        if value is None:
            self.missing.append(MissingNumber(path, name, declared, unit, owner))
        else:
            self.assumed.append(path)
            if isinstance(value, str) and value.startswith("="):  # the same as another entry
                value = old[value[1:]][0] if value[1:] in old else None
        return value

    def _can_keep(self, declared: FieldDeclaration, value: Any, was: FieldDeclaration, path: str) -> bool:
        if (declared.kind, declared.unit) != (was.kind, was.unit):
            return False
        if declared is was:
            return True
        if declared.kind == "option":
            return str(value) in declared.choices
        if declared.kind != "parameter" or self.unit(Leaf(path, declared, None)) != declared.unit:
            return True
        try:
            declared.convert("", "", value)
        except InputError:
            return False
        return True

    def _fill_part(self, cls: PartClass, registry: Kinds, name: str, old: JsonTable, path: str, was: PartClass) -> Any:
        declared = cls.declarations[name]
        before = was.declarations.get(name)
        given = old.get(name) if before is not None and _is_alike(before, declared) else None
        if declared.registry is None:
            return self._fill_known(cls, registry, name, given, path)
        if registry is not None and declared.registry is registry and not given and was is not cls:
            given = self._take_in(cls, registry, name, old, path, was)
        return self._fill_chosen(name, declared, given, path)

    def _fill_known(self, cls: PartClass, registry: Kinds, name: str, given: Any, path: str) -> Any:
        declared, inner = cls.declarations[name], component_class(cls, name)
        if inner is None or is_members(inner) or not isinstance(inner.declarations, dict):
            return self._begin_row(declared, path) if given is None else given
        if given is None and declared.default is not REQUIRED:
            return None
        return self.table(inner, None, cast("JsonTable", given or {}), path) or None

    def _begin_row(self, declared: FieldDeclaration, path: str) -> Any:
        unit = self.unit(Leaf(path, FieldDeclaration("parameter", "", None, DRIVE), None))
        typical = declared.typical_in(unit)
        if typical is None:
            return None
        self.assumed.append(path)
        return list(cast("tuple[Any, ...]", typical)) if isinstance(typical, tuple) else typical

    def _take_in(
        self, cls: PartClass, registry: Registry[Any], name: str, old: JsonTable, path: str, was: PartClass
    ) -> Any:
        inner = next((n for n, d in was.declarations.items() if d.registry is registry), None)
        if inner is not None and inner in old:
            return old[inner]
        start = cls.declarations[name].typical_in("")
        taken = next(n for n, d in cls.declarations.items() if d.registry is registry)
        if name != taken:
            return start
        if not self.fresh or start is None:
            rest = {key: value for key, value in old.items() if key in (*was.declarations, KIND)}
            return {**rest, KIND: was.registered_name}
        return self.table(registry[read_kind(start)[KIND]], registry, old, path, was)

    def _fill_chosen(self, name: str, declared: FieldDeclaration, given: Any, path: str) -> Any:
        """Return a completed component of a registry; None if the default suffices."""
        registry = cast("Registry[Any]", declared.registry)
        full = read_kind(given) if given is not None else {}
        intended = self._find_meant(name, declared, full)
        if intended is None:
            if declared.default is REQUIRED:
                full = read_kind(declared.typical_in(""))
            if KIND not in full:
                return given
            intended = full
        cls = registry[str(intended[KIND])]
        table = self.table(cls, registry, {**full, KIND: intended[KIND]}, path)
        if not full and all(table.get(key) == value for key, value in intended.items()) and len(table) == 1:
            return None
        implied = set(table) - set(full) == {KIND} and KIND not in full
        return given if implied and given is not None else table

    def _find_meant(self, name: str, declared: FieldDeclaration, full: JsonTable) -> JsonTable | None:
        if KIND in full:
            return full
        if name == LAW and self.material is not None and self.material.law:
            return {**self.material.law}
        if name in ASSUMED_KINDS:
            return {KIND: ASSUMED_KINDS[name]}
        if isinstance(declared.default, Parametrised):
            return {KIND: declared.default.registered_name}
        return None


def read_kind(value: Any) -> JsonTable:
    """Return a table; a text is its kind, and None is empty."""
    return {KIND: value} if isinstance(value, str) else dict(cast("JsonTable", value or {}))


def _is_alike(one: FieldDeclaration, other: FieldDeclaration) -> bool:
    return one.kind == other.kind and one.registry is other.registry


def without_material(table: JsonTable, material: Material | None) -> JsonTable:
    """Return a table of an element without values of a material, at any depth."""
    if material is None:
        return table
    return {
        key: without_material(cast("JsonTable", value), material) if isinstance(value, dict) else value
        for key, value in table.items()
        if key not in material.values or key not in NAMES
    }
