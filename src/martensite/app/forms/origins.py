"""Where a number comes from, in words: the scenario, its default, or a source of the material."""

from __future__ import annotations

from martensite.app.forms.form_types import MaterialValue, Origin
from martensite.physics.materials.base import DOUBTFUL, Material, MaterialNumber

ORIGIN_WORDS = {
    "scenario": "written in the scenario",
    "default": "the default",
    "plant": "worked out from the plant",
    "start": "written in the scenario; the same as an assumed start value of this form, so no data",
    "none": "not given yet",
}


def describe_origin(noted: str, name: str, material: Material | None) -> Origin:
    """An origin as `Scenario.origins` notes it, told in full.

    Its sort is scenario, default, plant, start, none, law or material; a number of the material has
    its kind, source and place as well, and whether it is doubtful.
    """
    kind, _, owner = noted.partition(", ")
    if not owner:
        return {"sort": kind, "words": ORIGIN_WORDS.get(kind, kind)}
    if kind == "law":
        return {"sort": "law", "words": f"of the law that material {owner} holds for"}
    if material is not None and material.name == owner and name in material.values:
        return describe_source(material, material.values[name])
    return {"sort": "material", "words": f"{kind}, material {owner}", "kind": kind}


def describe_source(material: Material, number: MaterialNumber) -> Origin:
    """A number of a material with its source."""
    source = material.sources[number.source]
    return {
        "sort": "material",
        "words": f"{number.kind}, material {material.name}",
        "kind": number.kind,
        "doubtful": number.kind in DOUBTFUL,
        "source": source.text,
        "cite": source.cite,
        "where": number.where,
        "note": number.note,
    }


def find_material_number(material: Material | None, name: str) -> MaterialValue | None:
    """What the material has for a number that the scenario gives itself; None if it has none."""
    if material is None or name not in material.values:
        return None
    number = material.values[name]
    return {**describe_source(material, number), "text": number.text, "value": number.value}
