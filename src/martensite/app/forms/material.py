"""Another material in a scenario, and a law that it can serve."""

from __future__ import annotations

from copy import deepcopy

from martensite.actuators.elements.base import ELEMENTS
from martensite.app.forms import documents
from martensite.app.forms.table_filler import KIND, ChangedScenario, TableFiller, read_kind, without_material
from martensite.app.messages import JsonTable
from martensite.app.packaged_scenarios import FOLDER
from martensite.base.parameters import REQUIRED, Parametrised
from martensite.physics.laws.base import LAWS
from martensite.physics.materials.base import Material, load_material

USUAL_LAWS = ("liang-rogers", "lagoudas", "mas-hybrid", "brinson")
"""Laws among which one is chosen for a material that names none, the first if all fit."""


def with_material(document: JsonTable, name: str) -> ChangedScenario:
    """The document with another material; a law that it cannot serve goes to one that it can."""
    made = deepcopy(document)
    material = load_material(name, FOLDER) if name else None
    old = documents.find_table(made, "element")
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
    made["element"] = {**head, **tables[best]}
    notes = []
    if best:
        notes.append(f"The law is one that material {name} has the numbers for.")
    return ChangedScenario(made, notes, choices[best].assumed, choices[best].missing)


def _law_for(material: Material | None) -> JsonTable:
    """The law that a material names, or of which it has most; the first of the usual ones."""
    if material is not None and material.law:
        return dict(material.law)
    known = material.values if material is not None else {}

    def lacks(name: str) -> int:
        needed = [n for n, d in LAWS[name].declarations.items() if d.default is REQUIRED]
        return sum(one not in known for one in needed)

    return {KIND: min(USUAL_LAWS, key=lacks)}


def _with_law(table: JsonTable, cls: type[Parametrised], law: JsonTable) -> JsonTable:
    """A table of an element with another law, in the wire that it is made of."""
    if "law" in cls.declarations:
        return {**table, "law": law}
    inner = next((n for n, d in cls.declarations.items() if d.registry is ELEMENTS), None)
    if inner is None or inner not in table:
        return table
    below = read_kind(table[inner])
    return {**table, inner: _with_law(below, ELEMENTS[str(below[KIND])], law)}
