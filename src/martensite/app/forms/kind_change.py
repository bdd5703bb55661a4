"""Another kind in a scenario: a law, material, mechanism, cooling, drive, waveform or element.

The rest of the scenario stays. If that cannot be built, less is kept: first components of bundles are recreated, then
sections around the system are removed. Assumed values and removed sections are reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

from martensite.actuators.elements.base import ELEMENTS
from martensite.app.documents import FOLDER, list_standalone
from martensite.app.forms import documents
from martensite.app.forms.control_tree import GroupSpot
from martensite.app.forms.sections import MATERIAL, FormSections
from martensite.app.forms.surroundings import change_reference, change_source, relax_surroundings
from martensite.app.forms.table_filler import KIND, ChangedScenario, TableFiller, read_kind, without_material
from martensite.app.messages import JsonTable
from martensite.base.errors import InputError, ParameterError
from martensite.base.files import toml_document
from martensite.base.parameters import REQUIRED, Leaf, Parametrised
from martensite.base.registry import Registry
from martensite.base.toml_text import as_toml
from martensite.control.loop.parts import MountedSensor
from martensite.physics.electrical.base import SOURCES
from martensite.physics.laws.base import LAWS
from martensite.physics.materials.base import Material, load_material
from martensite.scenario.components import list_nested
from martensite.scenario.scenario import Scenario, read_scenario
from martensite.scenario.sections import MODEL, NAME, PERIOD, REFERENCE

Unit = Callable[[Leaf], str]
USUAL_LAWS = ("liang-rogers", "lagoudas", "mas-hybrid", "brinson")
"""Laws for a material without one; the first of those with fewest missing values."""


def change_kind(scenario: Scenario, path: str, kind: str, given: JsonTable) -> ChangedScenario:
    """Put another kind into a scenario.

    Args:
        scenario: present scenario.
        path: path of the kind, such as `element.law.kind`, or `element.material`.
        kind: name of the new kind.
        given: values by path that replace others.
    """
    document = toml_document(scenario.text)
    if path == MATERIAL:
        entries = [with_material(document, kind)]
    else:
        entries = list(_list_candidates(scenario, document, path, kind))
    fault: InputError | None = None
    for one in entries:
        for name, value in given.items():
            documents.put_entry(one.document, name, value)
        one.missing = [m for m in one.missing if documents.find_entry(one.document, m.path) is None]
        if one.missing:
            return one
        try:
            read_scenario(as_toml(one.document), FOLDER / "scenario.toml")
        except InputError as error:
            fault = fault or error
        else:
            return one
    raise fault or ParameterError(f"`{path}` cannot be `{kind}`.")


def _list_candidates(scenario: Scenario, document: JsonTable, path: str, kind: str) -> Iterator[ChangedScenario]:
    spot = _find_spot(scenario, path)
    registry = spot.registry
    cls, example = registry[kind], getattr(registry[kind], "typical_scenario", "")
    if example:
        note = f"`{kind}` needs more than one number, so a whole packaged scenario is on the bench."
        yield ChangedScenario(toml_document(list_standalone()[example]), [note])
        return
    for fresh in (False, True):
        candidate = _put_kind(scenario, document, path, spot, cls, fresh)
        yield from relax_surroundings(scenario, candidate)
    if registry.kind == "controller":
        yield from change_reference(scenario, candidate, path.removesuffix(f".{KIND}"))


def _find_spot(scenario: Scenario, path: str) -> GroupSpot:
    form = FormSections(scenario)
    form.all()
    if path not in form.walk.spots:
        raise ParameterError(f"The scenario has no kind at `{path}`.")
    return form.walk.spots[path]


def _put_kind(
    scenario: Scenario, document: JsonTable, path: str, spot: GroupSpot, cls: type[Parametrised], fresh: bool
) -> ChangedScenario:
    """Return the document with a table for another class in place of a part."""
    new_document, place, registry = deepcopy(document), path.removesuffix(f".{KIND}"), spot.registry
    was, old = type(spot.part), documents.find_table(new_document, place)
    elsewhere = {"controller": (PERIOD, REFERENCE, MODEL), "observer": (MODEL,)}
    filler = TableFiller(
        _place_units(spot.walk.unit, spot.path, place),
        (scenario.material if "element" in place.split(".")[:3] else None),
        elsewhere.get(registry.kind, ()),
        fresh,
    )
    old_entries = _keep_entries(registry, cls, was, old, fresh)
    full = {**old, KIND: was.registered_name}
    table = {**old_entries, **filler.table(cls, registry, full, place, was)}
    documents.put_entry(new_document, place, table)
    changed_scenario = ChangedScenario(new_document, [], filler.assumed, filler.missing)
    if registry is SOURCES:
        change_source(changed_scenario, scenario, place, getattr(spot.part, "unit", "1"), cls)
    return changed_scenario


def _place_units(unit: Unit, at: str, place: str) -> Unit:
    def find_unit(leaf: Leaf) -> str:
        rest = leaf.path.removeprefix(place).removeprefix(".")
        return unit(Leaf(f"{at}.{rest}" if at else rest, leaf.declared, None))

    return find_unit


def _keep_entries(
    registry: Registry[Any], cls: type[Parametrised], was: type[Parametrised], old: JsonTable, fresh: bool
) -> JsonTable:
    """Return the entries of a table that are independent of the kind."""
    inner = [name for name, _ in list_nested(cls)]
    names = {
        "element": ["material"],
        "drive": ["waveform"],
        "sensor": [n for n in (*MountedSensor.declarations, NAME) if n != "of" or not fresh],
        "controller": [PERIOD, REFERENCE, *(n for n in inner if inner.count(n) == 1)],
    }.get(registry.kind, [])
    own = cls.declarations if registry.kind != "controller" else {**cls.declarations, **was.declarations}
    always = (PERIOD, REFERENCE)
    return {n: old[n] for n in names if n in old and (n not in own or n in always)}


def with_material(document: JsonTable, name: str) -> ChangedScenario:
    """Return the document with another material, and with another law if that needs fewer assumptions."""
    new_document = deepcopy(document)
    material = load_material(name, FOLDER) if name else None
    old = documents.find_table(new_document, "element")
    rest = without_material({k: v for k, v in old.items() if k != "material"}, material)
    cls = ELEMENTS[str(old[KIND])]
    choices = [TableFiller(material=material) for _ in range(2)]
    tables = [
        choices[0].table(cls, ELEMENTS, rest, "element"),
        choices[1].table(cls, ELEMENTS, _with_law(rest, cls, _law_for(material)), "element"),
    ]
    costs = [len(one.assumed) + len(one.missing) for one in choices]
    best = 1 if costs[1] < costs[0] else 0
    head = {KIND: tables[best].pop(KIND), **({"material": name} if name else {})}
    new_document["element"] = {**head, **tables[best]}
    notes = []
    if best:
        notes.append(f"The law is one that material {name} has the numbers for.")
    return ChangedScenario(new_document, notes, choices[best].assumed, choices[best].missing)


def _law_for(material: Material | None) -> JsonTable:
    if material is not None and material.law:
        return dict(material.law)
    values = material.values if material is not None else {}

    def lacks(name: str) -> int:
        needed = [n for n, d in LAWS[name].declarations.items() if d.default is REQUIRED]
        return sum(one not in values for one in needed)

    return {KIND: min(USUAL_LAWS, key=lacks)}


def _with_law(table: JsonTable, cls: type[Parametrised], law: JsonTable) -> JsonTable:
    if "law" in cls.declarations:
        return {**table, "law": law}
    inner = next((n for n, d in cls.declarations.items() if d.registry is ELEMENTS), None)
    if inner is None or inner not in table:
        return table
    below = read_kind(table[inner])
    return {**table, inner: _with_law(below, ELEMENTS[str(below[KIND])], law)}
