"""`list` and `materials`: what there is, and what is known of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument

from martensite.base.summary import DataTable, Summary
from martensite.cli.app import app
from martensite.cli.options import Imports, Json, Text, import_modules

if TYPE_CHECKING:
    from martensite.identify.blocks.base import AbstractBlock


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
    kind: Annotated[Text, Argument(metavar="[KIND]", help="A kind of parts.", autocompletion=complete_kind)] = None,
    name: Annotated[
        Text, Argument(metavar="[NAME]", help="One of them, in detail.", autocompletion=complete_name)
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
    from martensite.show.summaries.parts import describe_part, tabulate_parts
    from martensite.show.terminal import print_summary

    registry = catalogue.find_registry(kind)
    if name is None:
        rows = catalogue.list_named(registry)
        if registry.kind == "block":
            rows = [{"written": _write_block(registry[row["name"]]), **row} for row in rows]
        print_summary(Summary("", [tabulate_parts(registry.kind, rows)], rows), json)
        return
    short = {getattr(registry[n], "short", ""): n for n in registry.names()}
    part = catalogue.describe_class(registry.kind, registry[short.get(name, name)])
    print_summary(Summary("", list(describe_part(part)), part), json)


def _list_kinds(json: bool) -> None:
    """All kinds of parts, with what there is of each."""
    from martensite.scenario import catalogue
    from martensite.show.terminal import print_summary

    found = {kind: r.names() for kind, r in catalogue.list_registries(blocks=True).items()}
    table = DataTable(("kind of part", "names"), [(k, ", ".join(v)) for k, v in found.items()])
    print_summary(Summary("", [table], found), json)


def _write_block(block: type[AbstractBlock]) -> str:
    """How a block is written in the text of a chain; empty if it cannot be."""
    if not block.short or not block.shape:
        return block.short
    return f"{block.short}({','.join(block.shape)})"


@app.command()
def materials(
    name: Annotated[Text, Argument(metavar="[NAME|FILE]", help="One of them, in detail.")] = None, json: Json = False
) -> None:
    """List the materials, or show one with all sources."""
    from martensite.physics.materials.base import load_material, material_names
    from martensite.show.summaries.parts import summarise_material, summarise_materials
    from martensite.show.terminal import print_summary

    if name is None:
        summary = summarise_materials([load_material(one) for one in material_names()])
    else:
        summary = summarise_material(load_material(name))
    print_summary(summary, json)
