"""Registered parts with their parameters, and materials with their sources."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from martensite.base.formats import write_quantity
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.base.units import OF_READINGS
from martensite.characterise.plateaus import find_plateaus
from martensite.physics.materials.base import DOUBTFUL, NAMES, Material
from martensite.scenario.citations import read_bibliography, read_title
from martensite.scenario.laws import ConfiguredLaw
from martensite.signals.base import DRIVE

ELASTIC = ("E_A", "E_M", "eps_L", "H_sat", "H_min")
"""Parameters that finite-element programs ask for beside the plateaus."""
PLATEAUS = "Stresses at which the law transforms when it is loaded and unloaded at this temperature."
NUMBERS = ("name", "value", "kind", "meaning", "source", "note")


def describe_part(part: Mapping[str, Any]) -> Iterator[Block]:
    """Yield a described part with its parameters and sources."""
    yield Heading(f"{part['kind']} {part['name']}: {part['summary']}")
    yield Sentence(f"\n{part['description']}")
    rows = [_parameter_row(entry) for entry in part["parameters"]]
    yield DataTable(("parameter", "unit", "meaning", "allowed", "default"), rows)
    for key in part["cites"]:
        title = read_title(key) if key in read_bibliography() else "not in the bibliography"
        yield Sentence(f"Source: {title} [{key}]")


def _parameter_row(entry: Mapping[str, Any]) -> tuple[str, ...]:
    unit = entry["unit"] or ""
    return entry["name"], unit, entry["meaning"], entry["allowed"], write_default(entry)


def write_default(entry: Mapping[str, Any]) -> str:
    """Return the default of a described parameter in a readable unit."""
    default = entry["default"]
    if not isinstance(default, float):
        return "required" if entry["required"] else str(default)
    if entry["unit"] in OF_READINGS and default and math.isfinite(default):
        return f"{default:g} in SI"
    placed = entry["unit"] in (DRIVE, *OF_READINGS)
    return write_quantity(default, "1" if placed else entry["unit"])


def tabulate_parts(kind: str, rows: Sequence[Mapping[str, Any]]) -> DataTable:
    """Return names and descriptions of parts; for blocks also their notation in a chain."""
    if any("written" in row for row in rows):
        cells = [(row["name"], row["written"], row["summary"]) for row in rows]
        return DataTable((kind, "in a chain", "what it is"), cells)
    return DataTable((kind, "what it is"), [(row["name"], row["summary"]) for row in rows])


def summarise_materials(materials: Sequence[Material]) -> Summary:
    """Return the materials with a line each."""
    table = DataTable(("material", "what it is"), [(one.name, one.title) for one in materials])
    rows = [{"name": one.name, "title": one.title, "summary": one.summary} for one in materials]
    return Summary("", [table], rows)


def summarise_material(material: Material) -> Summary:
    """Return the summary of a material."""
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
        legend = "! assumed or recalled: not measured on this material"
        blocks.append(Sentence(legend, "caution"))
    sources = material.sources.values()
    blocks += [Sentence(f"[{source.cite}] {source.text}") for source in sources]
    title = f"{material.name}: {material.title}"
    return Summary(title, blocks, asdict(material), material.summary)


def summarise_plateaus(configured: ConfiguredLaw, temperature: float) -> Summary:
    """Return the plateau stresses of a law at a temperature [K], and their change with temperature.

    Raises:
        InputError: the law is not superelastic at this temperature.
    """
    law, material = configured.law, configured.material
    plateaus = find_plateaus(law, temperature)
    slopes = plateaus.estimate_slopes(find_plateaus(law, temperature + 1.0))
    numbers = {
        leaf.path: (leaf.value, leaf.declared.unit) for leaf in law.leaves() if leaf.path in ELASTIC and leaf.value
    }
    numbers |= {
        "loading_start": (plateaus.loading[0], "Pa"),
        "loading_end": (plateaus.loading[1], "Pa"),
        "unloading_start": (plateaus.unloading[0], "Pa"),
        "unloading_end": (plateaus.unloading[1], "Pa"),
        "loading_slope": (slopes[0], "Pa/K"),
        "unloading_slope": (slopes[1], "Pa/K"),
    }
    rows = [(name, write_quantity(value, unit)) for name, (value, unit) in numbers.items()]
    name = f"{material.name}, " if material else ""
    title = f"{name}law {law.registered_name} at {temperature - 273.15:.4g} °C"
    data = {"law": law.registered_name, "temperature": temperature} | {n: value for n, (value, _) in numbers.items()}
    notes = [Sentence(one, "caution") for one in configured.cautions]
    return Summary(title, [DataTable(("quantity", "value"), rows), *notes], data, PLATEAUS)
