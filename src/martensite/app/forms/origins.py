"""Where a number comes from, in words: the scenario, its default, or a source of the material."""

from __future__ import annotations

from martensite.app.messages import JsonTable
from martensite.physics.materials.base import DOUBTFUL, Material, MaterialNumber

ORIGIN_WORDS = {
    "scenario": "written in the scenario",
    "default": "the default",
    "plant": "worked out from the plant",
    "start": "written in the scenario; the same as an assumed start value of this form, so no data",
    "none": "not given yet",
}


def describe_origin(noted: str, name: str, material: Material | None) -> JsonTable:
    """An origin as `Scenario.origins` notes it, told in full.

    `from` is scenario, default, plant, start, law or material; `words` a sentence; for a number of
    the material also its `kind`, `source`, `where`, `note`, and whether it is `doubtful`.
    """
    kind, _, owner = noted.partition(", ")
    if not owner:
        return {"from": kind, "words": ORIGIN_WORDS.get(kind, kind)}
    if kind == "law":
        return {"from": "law", "words": f"of the law that material {owner} holds for"}
    found = {"from": "material", "words": f"{kind}, material {owner}", "kind": kind}
    if material is not None and material.name == owner and name in material.values:
        found |= describe_source(material, material.values[name])
    return found


def describe_source(material: Material, number: MaterialNumber) -> JsonTable:
    """A number of a material with its source."""
    source = material.sources[number.source]
    return {
        "words": f"{number.kind}, material {material.name}",
        "kind": number.kind,
        "doubtful": number.kind in DOUBTFUL,
        "source": source.text,
        "cite": source.cite,
        "where": number.where,
        "note": number.note,
    }


def find_material_number(material: Material | None, name: str) -> JsonTable | None:
    """What the material has for a number that the scenario gives itself; None if it has none."""
    if material is None or name not in material.values:
        return None
    number = material.values[name]
    return {"text": number.text, "value": number.value, **describe_source(material, number)}
