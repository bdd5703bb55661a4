"""Materials: a list of them, and one with all its sources."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.physics.materials.base import DOUBTFUL, NAMES, Material

NUMBERS = ("name", "value", "kind", "meaning", "source", "note")


def summarise_materials(found: Sequence[Material]) -> Summary:
    """Materials with a line each."""
    table = DataTable(("material", "what it is"), [(one.name, one.title) for one in found])
    rows = [{"name": one.name, "title": one.title, "summary": one.summary} for one in found]
    return Summary("", [table], rows)


def summarise_material(material: Material) -> Summary:
    """Everything about a material."""
    blocks: list[Block] = [Sentence(f"Limits: {material.limits}")]
    if material.law is not None:
        options = [f"{name} = {word}" for name, word in material.law.items() if name != "kind"]
        blocks.append(Sentence(f"Law: {', '.join([material.law['kind'], *options])}"))
    rows = [
        (
            name,
            n.text,
            ("! " if n.kind in DOUBTFUL else "") + n.kind,
            NAMES[name][1],
            ", ".join(part for part in (material.sources[n.source].cite, n.where) if part),
            n.note,
        )
        for name, n in material.values.items()
    ]
    blocks.append(DataTable(NUMBERS, rows))
    if any(n.kind in DOUBTFUL for n in material.values.values()):
        told = "! assumed or recalled: not measured on this material"
        blocks.append(Sentence(told, "caution"))
    sources = material.sources.values()
    blocks += [Sentence(f"[{source.cite}] {source.text}") for source in sources]
    title = f"{material.name}: {material.title}"
    return Summary(title, blocks, asdict(material), material.summary)
