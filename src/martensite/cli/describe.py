"""`describe`: all that is declared, of every part and of a scenario, as one document."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument

from martensite.base.summary import Block, DataTable, Heading, Summary
from martensite.cli.app import app
from martensite.cli.options import Imports, Json, Settings, import_modules, load_scenario

if TYPE_CHECKING:
    from martensite.app.forms.form_types import GroupNode, SingleNode


@app.command()
def describe(
    scenario: Annotated[
        Path | None, Argument(metavar="[SCENARIO]", help="A scenario file, section by section.")
    ] = None,
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Say what is declared of all parts, and of a scenario.

    With --json it is one document with unit, bounds, default, typical value and meaning of every
    entry, of which other programs can build forms, as the web bench does.
    """
    import_modules(modules)
    from martensite.scenario.catalogue import describe_parts
    from martensite.show.terminal import print_summary

    parts = describe_parts()
    if scenario is None:
        rows = [(k, str(len(v)), str(sum(len(p["parameters"]) for p in v))) for k, v in parts.items()]
        blocks: list[Block] = [DataTable(("kind of part", "parts", "entries"), rows, right=(1, 2))]
        print_summary(Summary("", blocks, {"parts": parts}), json)
        return
    from martensite.app.forms.sections import describe_scenario

    form = describe_scenario(load_scenario(scenario, settings))
    blocks = [block for one in form["sections"] for block in _describe_section(one)]
    print_summary(Summary(form["title"], blocks, {"parts": parts, "scenario": form}), json)


def _describe_section(section: GroupNode) -> Iterator[Block]:
    """The title of a section, and its entries in a table."""
    yield Heading(section["title"])
    yield DataTable(("entry", "value", "allowed", "from"), list(_list_rows(section)))


def _list_rows(group: GroupNode) -> Iterator[tuple[str, ...]]:
    """The kind of a part, then its entries and parts."""
    if group["kind"]:
        yield group["kind"]["path"], group["kind"]["value"], f"a {group['kind']['registry']}", ""
    for one in group["items"]:
        if one["sort"] == "group":
            yield from _list_rows(one)
        else:
            yield one["path"], _write_value(one), one["allowed"], one["origin"]["words"]


def _write_value(one: SingleNode) -> str:
    """The value of an entry as the form shows it."""
    if one["sort"] != "number":
        return one["value"]
    if one["value"] is None or one["unlimited"]:
        return "no limit"
    return f"{one['value'] * one['factor'] + one['offset']:.6g} {one['label']}".strip()
