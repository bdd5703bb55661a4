"""`laws`, `mechanisms`, `drives`, `sensors`, …: what there is, and what is known of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.identify.blocks.base import AbstractBlock
    from martensite.materials.base import Material

Name = Annotated[str | None, typer.Argument(metavar="[NAME]", help="One of them, in detail.")]


@app.command()
def laws(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List the stress-strain-temperature laws, or describe one."""
    import_modules(modules)
    _list_or_describe("law", name, json)


@app.command()
def mechanisms(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List what an element can pull on, or describe one."""
    import_modules(modules)
    _list_or_describe("mechanism", name, json)


@app.command()
def drives(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List the sources that drive an element, or describe one."""
    import_modules(modules)
    _list_or_describe("drive", name, json)


@app.command()
def sensors(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List the sensors of a bench, or describe one."""
    import_modules(modules)
    _list_or_describe("sensor", name, json)


@app.command()
def observers(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List what estimates from readings what no sensor sees, or describe one."""
    import_modules(modules)
    _list_or_describe("observer", name, json)


@app.command()
def controllers(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List the controllers, or describe one."""
    import_modules(modules)
    _list_or_describe("controller", name, json)


@app.command()
def supervisors(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List who may have the last word on a bench, or describe one."""
    import_modules(modules)
    _list_or_describe("supervisor", name, json)


@app.command()
def faults(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List what can go wrong on a bench, or describe one."""
    import_modules(modules)
    _list_or_describe("fault", name, json)


@app.command()
def blocks(name: Name = None, json: Json = False, modules: Imports = None) -> None:
    """List the blocks that models are identified with, or describe one."""
    import_modules(modules)
    from martensite.cli import describe, show
    from martensite.io import catalogue

    registry = catalogue.registries(blocks=True)["block"]
    if name is not None:
        short = {registry[n].short: n for n in registry.names()}
        _list_or_describe("block", short.get(name, name), json)
        return
    found = [{"written": _written(registry[n]), **row} for n, row in
             zip(registry.names(), describe.listed(registry), strict=True)]  # fmt: skip
    if json:
        show.as_json(found)
    else:
        rows = [(row["name"], row["written"], row["summary"]) for row in found]
        show.table(("block", "in a chain", "what it is"), rows)


def _written(block: type[AbstractBlock]) -> str:
    """How a block is written in the text of a chain; empty if it cannot be."""
    if not block.short or not block.shape:
        return block.short
    return f"{block.short}({','.join(block.shape)})"


@app.command()
def materials(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME|FILE]", help="One of them, in detail.")
    ] = None,
    json: Json = False,
) -> None:
    """List the materials, or show one with all sources."""
    if name is None:
        _list_materials(json)
        return
    from martensite.cli import show
    from martensite.materials.base import load_material

    material = load_material(name)
    if json:
        from dataclasses import asdict

        show.as_json(asdict(material))
    else:
        _print_material(material)


def _list_or_describe(kind: str, name: str | None, json: bool) -> None:
    from martensite.cli import describe, show
    from martensite.io import catalogue

    registry = catalogue.registries(blocks=kind == "block")[kind]
    if name is None:
        show.as_json(describe.listed(registry)) if json else describe.print_list(registry)
        return
    part = describe.one(registry, name)
    show.as_json(part) if json else describe.print_part(part)


def _list_materials(json: bool) -> None:
    from martensite.cli import show
    from martensite.materials.base import load_material, material_names

    found = [load_material(name) for name in material_names()]
    if json:
        show.as_json([{"name": m.name, "title": m.title, "summary": m.summary} for m in found])
    else:
        show.table(("material", "what it is"), [(m.name, m.title) for m in found])


def _print_material(material: Material) -> None:
    from martensite.cli import show
    from martensite.materials.base import DOUBTFUL
    from martensite.materials.names import NAMES

    show.text(f"{material.name}: {material.title}", "bold")
    show.text(material.summary)
    show.text(f"Limits: {material.limits}")
    if material.law is not None:
        options = [f"{name} = {word}" for name, word in material.law.items() if name != "kind"]
        show.text(f"Law: {', '.join([material.law['kind'], *options])}")
    rows = [
        (name, n.text, ("! " if n.kind in DOUBTFUL else "") + n.kind, NAMES[name][1],
         ", ".join(part for part in (material.sources[n.source].cite, n.where) if part), n.note)
        for name, n in material.values.items()
    ]  # fmt: skip
    show.table(("name", "value", "kind", "meaning", "source", "note"), rows)
    if any(n.kind in DOUBTFUL for n in material.values.values()):
        show.text("! assumed or recalled: not measured on this material", "yellow")
    for source in material.sources.values():
        show.text(f"[{source.cite}] {source.text}")
