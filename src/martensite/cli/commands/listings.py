"""`list`, `materials` and `cite`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument

from martensite.base.summary import DataTable, Summary
from martensite.cli.app import app
from martensite.cli.options import (
    Imports,
    Json,
    Settings,
    Text,
    import_modules,
    load_scenario,
    read_quantity,
    refuse_idle,
)

if TYPE_CHECKING:
    from martensite.base.registry import Registry
    from martensite.identify.blocks.base import AbstractBlock


def complete_kind(incomplete: str) -> list[str]:
    """Return the kinds that begin with a text."""
    return [kind for kind in _find_registries() if kind.startswith(incomplete)]


def _find_registries() -> dict[str, Registry[Any]]:
    """Return every registry by the word for one of its entries, with kinds of experiment."""
    from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS
    from martensite.scenario import catalogue

    return catalogue.list_registries(blocks=True) | {EXPERIMENT_KINDS.kind: EXPERIMENT_KINDS}


def complete_name(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the parts of the chosen kind that begin with a text."""
    registry = _find_registries().get(ctx.params.get("kind") or "")
    names = registry.names() if registry is not None else []
    return [name for name in names if name.startswith(incomplete)]


@app.command("list", rich_help_panel="Look up")
def list_parts(
    kind: Annotated[
        Text, Argument(metavar="[KIND]", help="Kind of part, e.g. law.", autocompletion=complete_kind)
    ] = None,
    name: Annotated[
        Text,
        Argument(metavar="[NAME]", help="Name of the part to describe, e.g. brinson.", autocompletion=complete_name),
    ] = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """List kinds of parts, the parts of a kind, or one part.

    Examples: `martensite list law` and `martensite list law brinson`.
    """
    import_modules(modules)
    if kind is None:
        _list_kinds(json)
        return
    if kind.removesuffix("s") == "experiment":
        _list_experiments(name, json)
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


def _list_experiments(name: str | None, json: bool) -> None:
    """List the kinds of experiment in the order of recognition, or one kind."""
    from martensite.base.errors import require_known
    from martensite.fit.experiment_kinds.base import list_kinds
    from martensite.show.terminal import print_summary

    kinds = {one.registered_name: one for one in list_kinds()}
    if name is not None:
        require_known("experiment", name, kinds)
        kinds = {name: kinds[name]}
    rows = [
        {
            "name": one.registered_name,
            "meaning": one.meaning,
            "needs": one.needs,
            "command": f"fit {one.command}".strip(),
        }
        for one in kinds.values()
    ]
    table = DataTable(("experiment", "meaning", "needs", "command"), [tuple(row.values()) for row in rows])
    print_summary(Summary("", [table], rows), json)


def _list_kinds(json: bool) -> None:
    from martensite.show.terminal import print_summary

    kinds = {kind: r.names() for kind, r in _find_registries().items()}
    table = DataTable(("kind of part", "names"), [(k, ", ".join(v)) for k, v in kinds.items()])
    print_summary(Summary("", [table], kinds), json)


def _write_block(block: type[AbstractBlock]) -> str:
    if not block.short:
        return block().text()
    if not block.shape:
        return block.short
    return f"{block.short}({','.join(block.shape)})"


@app.command("materials", rich_help_panel="Look up")
def materials(
    name: Annotated[
        Text, Argument(metavar="[NAME|FILE]", help="Name of the material to show, e.g. flexinol-90.")
    ] = None,
    plateaus: Annotated[
        Text, typer.Option(help='Show the plateau stresses of a superelastic test at a temperature, e.g. "60 degC".')
    ] = None,
    law: Annotated[
        Text, typer.Option(help="Law of the plateaus; by default the one that the material belongs to.")
    ] = None,
    json: Json = False,
) -> None:
    """List the materials, or show one with all sources."""
    from martensite.physics.materials.base import load_material, material_names
    from martensite.show.summaries.parts import summarise_material, summarise_materials, summarise_plateaus
    from martensite.show.terminal import print_summary

    refuse_idle("--law", law is not None and plateaus is None, "only --plateaus uses a law")
    refuse_idle("--plateaus", plateaus is not None and name is None, "no material is named")
    if name is None:
        summary = summarise_materials([load_material(one) for one in material_names()])
    elif plateaus is None:
        summary = summarise_material(load_material(name))
    else:
        from martensite.scenario.laws import configure_laws

        material = load_material(name)
        usual = "lagoudas" if "H_sat" in material.values else "liang-rogers"
        (configured,) = configure_laws([law or (material.law or {}).get("kind", usual)], name, {})
        summary = summarise_plateaus(configured, read_quantity("plateaus", plateaus, "K"))
    print_summary(summary, json)


@app.command("cite", rich_help_panel="Look up")
def cite(
    name: Annotated[str, typer.Argument(metavar="SCENARIO|STUDY", help="Scenario file, or name of a study.")],
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Print BibTeX entries for a scenario or a study."""
    import_modules(modules)
    from martensite.scenario import citations
    from martensite.show.terminal import print_json

    if name.endswith(".toml"):
        loaded = load_scenario(name, settings)
        keys = citations.list_citations(loaded, loaded.material)
    else:
        from martensite.studies.base import load_study

        keys = list(dict.fromkeys(load_study(name).cites))
    texts = citations.list_entries(keys)
    if json:
        print_json([{"key": k, "bibtex": t} for k, t in zip(keys, texts, strict=True)])
    else:
        typer.echo("\n\n".join(texts))
