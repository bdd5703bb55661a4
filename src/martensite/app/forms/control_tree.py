"""Groups of controls from components, along their declarations.

A walk visits the objects of a scenario, which provides paths in the document, origins and units.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from martensite.actuators.assembly import Members
from martensite.app.forms import controls, documents
from martensite.app.forms.controls import EntrySpot
from martensite.app.forms.form_types import FormNode, GroupNode, KindChoice, SingleNode
from martensite.app.messages import JsonTable
from martensite.base.formats import spell_title
from martensite.base.parameters import REQUIRED, FieldDeclaration, Leaf, Parametrised
from martensite.base.registry import Registry
from martensite.control.controllers.state_feedback import NumberedGains
from martensite.physics.materials.base import NAMES, Material
from martensite.scenario.components import is_plain
from martensite.signals.base import DRIVE
from martensite.signals.table import Table

Paths = Callable[[str], str]


@dataclass(frozen=True)
class GroupSpot:
    """The part of a group, with its walk and registry."""

    walk: ControlWalk
    path: str
    """Path of the object."""
    part: Parametrised
    registry: Registry[Any]


@dataclass
class ControlWalk:
    """Builder of groups for components of a scenario."""

    document: JsonTable
    origins: dict[str, str]
    document_path: Paths
    """Path in the document by path of the object."""
    origin_path: Paths
    """Path of the origin by path of the object."""
    unit: Callable[[Leaf], str]
    """SI unit of a parameter in its place."""
    material: Material | None = None
    """Material that can provide values."""
    is_skipped: Callable[[str], bool] = lambda path: False
    """True if an object is elsewhere in the document, or absent."""
    paths_with_control: set[str] = field(default_factory=set[str])
    """Document paths that already have a control."""
    spots: dict[str, GroupSpot] = field(default_factory=dict[str, "GroupSpot"])
    """Spots by path of the kind."""

    def group(
        self,
        part: Parametrised,
        path: str,
        title: str,
        meaning: str = "",
        registry: Registry[Any] | None = None,
        default: Any = REQUIRED,
    ) -> GroupNode:
        """Return the controls of a component, with groups for its components."""
        node = build_group(self.document_path(path), spell_title(title), meaning=meaning)
        if registry is not None and part.registered_name:
            node["kind"] = self._kind(part, path, registry, default)
        node["items"] = list(self._items(part, path, node))
        return node

    def _kind(self, part: Parametrised, path: str, registry: Registry[Any], default: Any) -> KindChoice:
        place, value = f"{self.document_path(path)}.kind", part.registered_name
        self.spots[place] = GroupSpot(self, path, part, registry)
        changed = isinstance(default, Parametrised) and default.registered_name != value
        return {"path": place, "value": value, "registry": registry.kind, "changed": changed}

    def _items(self, part: Parametrised, path: str, owner: GroupNode) -> Iterator[FormNode]:
        table, later = isinstance(part, Table), list[FormNode]()
        for name, declared in sorted(part.declarations.items(), key=_rank_entry(part)):
            below = f"{path}.{name}" if path else name
            if table:
                yield from self._list_texts(below, name, declared)
            elif declared.kind != "part":
                yield from self._single(part, below, name, declared)
            elif is_plain(type(part), name) or isinstance(part.__dict__[name], NumberedGains):
                yield from self._row(part, below, name, declared)
            else:
                later += self._parts(part, below, name, declared, owner)
        yield from later

    def _parts(
        self, part: Parametrised, path: str, name: str, declared: FieldDeclaration, owner: GroupNode
    ) -> list[FormNode]:
        value = part.__dict__[name]
        if not isinstance(value, Parametrised) or self.is_skipped(path):
            return []
        if isinstance(value, Members):
            return [self.members(value, path, name, declared.doc)]
        node = self.group(value, path, name, declared.doc, declared.registry, declared.default)
        if node["path"] == owner["path"]:  # both are in one table, such as a mounted sensor
            owner["kind"] = node["kind"]
            return node["items"]
        return [node] if node["items"] or node["kind"] else []

    def members(self, value: Members[Any], path: str, title: str, meaning: str = "") -> GroupNode:
        """Return the components with user-defined names."""
        below = [self.group(one, f"{path}.{name}", name, "", value.registry) for name, one in value.members().items()]
        return build_group(self.document_path(path), spell_title(title), below, meaning=meaning)

    def _spot(self, part: Parametrised, path: str, name: str, declared: FieldDeclaration) -> EntrySpot | None:
        """Return the spot of an entry; None if it already has a control."""
        place, origin_path = self.document_path(path), self.origin_path(path)
        if place in self.paths_with_control:
            return None
        self.paths_with_control.add(place)
        origin = self.origins.get(origin_path, self.origins.get(place, "default"))
        if origin == "scenario" and declared.kind == "parameter":
            raw = documents.find_entry(self.document, place)
            unit = self.unit(Leaf(path, declared, None))
            if raw is not None and raw == declared.typical_in(unit):  # unchanged since the start
                origin = "start"
        return EntrySpot(place, name, declared, origin, self.material)

    def _single(self, part: Parametrised, path: str, name: str, declared: FieldDeclaration) -> Iterator[SingleNode]:
        spot = self._spot(part, path, name, declared)
        value = part.__dict__[name]
        if spot is None:
            return
        if declared.kind == "parameter":
            yield controls.describe_number(spot, value, self.unit(Leaf(path, declared, value)))
        elif declared.kind == "option":
            yield controls.describe_option(spot, value)
        else:
            yield controls.describe_text(spot, value)

    def _row(self, part: Parametrised, path: str, name: str, declared: FieldDeclaration) -> Iterator[SingleNode]:
        spot = self._spot(part, path, name, declared)
        value = part.__dict__[name]
        if spot is not None:
            raw = documents.find_entry(self.document, spot.path)
            value = list(value.numbers) if isinstance(value, NumberedGains) else value
            yield controls.describe_row(spot, value if raw is None else raw)

    def _list_texts(self, path: str, name: str, declared: FieldDeclaration) -> Iterator[SingleNode]:
        """Yield the samples listed in the document; samples of a file are not shown."""
        raw = documents.find_entry(self.document, self.document_path(path))
        if raw is not None:
            row = controls.describe_row(EntrySpot(self.document_path(path), name, declared, "scenario"), raw)
            if name == "values":
                row["unit"] = self.unit(Leaf(path, FieldDeclaration("parameter", "", None, DRIVE), None))
            yield row


def _rank_entry(part: Parametrised) -> Callable[[tuple[str, FieldDeclaration]], tuple[bool, bool]]:
    """Return a sort key: other required parameters before those of a material."""
    mixed = any(name in NAMES for name in part.declarations)
    return lambda item: (mixed and item[0] in NAMES, mixed and item[1].default is not REQUIRED)


def place_units(drive_unit: str) -> Callable[[Leaf], str]:
    """Return the units of a waveform's parameters for a drive."""
    return lambda leaf: drive_unit if leaf.declared.unit == DRIVE else leaf.declared.unit


def build_group(path: str, title: str, items: Sequence[FormNode] = (), note: str = "", meaning: str = "") -> GroupNode:
    """Return a group without a kind."""
    return {
        "sort": "group",
        "path": path,
        "title": title,
        "meaning": meaning,
        "note": note,
        "kind": None,
        "items": list(items),
    }


def join_path(begin: str, path: str) -> str:
    """Return a path below a prefix that ends in a dot."""
    return f"{begin}{path}" if path else begin.removesuffix(".")


def flatten_controls(items: Sequence[FormNode]) -> Iterator[SingleNode]:
    """Yield all controls at any depth."""
    for item in items:
        if item["sort"] == "group":
            yield from flatten_controls(item["items"])
        else:
            yield item
