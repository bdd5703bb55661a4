"""`list` and `materials`: what there is, and what is known of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, import_modules

if TYPE_CHECKING:
    from martensite.base.registry import Registry
    from martensite.identify.blocks.base import AbstractBlock
    from martensite.physics.materials.base import Material


def complete_kind(incomplete: str) -> list[str]:
    """Kinds of parts that begin as what is typed in a shell."""
    from martensite.scenario import catalogue

    return [kind for kind in catalogue.list_registries(blocks=True) if kind.startswith(incomplete)]


def complete_name(ctx: typer.Context, incomplete: str) -> list[str]:
    """Parts of the kind before it that begin as what is typed in a shell."""
    from martensite.scenario import catalogue

    registry = catalogue.list_registries(blocks=True).get(ctx.params.get("kind") or "")
    names = registry.names() if registry is not None else []
    return [name for name in names if name.startswith(incomplete)]


@app.command(name="list")
def list_parts(
    kind: Annotated[
        str | None,
        typer.Argument(metavar="[KIND]", help="A kind of parts.", autocompletion=complete_kind),
    ] = None,
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]", help="One of them, in detail.", autocompletion=complete_name
        ),
    ] = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """List the kinds of parts, the parts of a kind, or describe one.

    For example `martensite list law`, and `martensite list law brinson`.
    """
    import_modules(modules)
    if kind is None:
        _list_kinds(json)
        return
    from martensite.scenario import catalogue

    registry = catalogue.find_registry(kind)
    if name is not None:
        _describe(registry, name, json)
    elif registry.kind == "block":
        _list_blocks(registry, json)
    else:
        from martensite.cli import describe, show

        show.as_json(describe.listed(registry)) if json else describe.print_list(registry)


def _list_kinds(json: bool) -> None:
    """All kinds of parts, with what there is of each."""
    from martensite.cli import show
    from martensite.scenario import catalogue

    found = {kind: r.names() for kind, r in catalogue.list_registries(blocks=True).items()}
    if json:
        show.as_json(found)
    else:
        show.table(("kind of part", "names"), [(k, ", ".join(v)) for k, v in found.items()])


def _describe(registry: Registry[Any], name: str, json: bool) -> None:
    """One part; a block by its short name too."""
    from martensite.cli import describe, show

    short = {getattr(registry[n], "short", ""): n for n in registry.names()}
    part = describe.one(registry, short.get(name, name))
    show.as_json(part) if json else describe.print_part(part)


def _list_blocks(registry: Registry[Any], json: bool) -> None:
    """All blocks, with how they are written in a chain."""
    from martensite.cli import describe, show

    found = [
        {"written": _written(registry[n]), **row}
        for n, row in zip(registry.names(), describe.listed(registry), strict=True)
    ]
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
    from martensite.physics.materials.base import load_material

    material = load_material(name)
    if json:
        from dataclasses import asdict

        show.as_json(asdict(material))
    else:
        _print_material(material)


def _list_materials(json: bool) -> None:
    from martensite.cli import show
    from martensite.physics.materials.base import load_material, material_names

    found = [load_material(name) for name in material_names()]
    if json:
        show.as_json([{"name": m.name, "title": m.title, "summary": m.summary} for m in found])
    else:
        show.table(("material", "what it is"), [(m.name, m.title) for m in found])


def _print_material(material: Material) -> None:
    from martensite.cli import show
    from martensite.physics.materials.base import DOUBTFUL
    from martensite.physics.materials.names import NAMES

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
