"""`data`: published measurements, what they are and how to get them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import Json

data = typer.Typer(help="List, show or fetch published measurements.")
app.add_typer(data, name="data", invoke_without_command=True)


@data.callback()
def overview(ctx: typer.Context, json: Json = False) -> None:
    """List, show or fetch published measurements."""
    if ctx.invoked_subcommand is None:
        list_all(json)


@data.command("list")
def list_all(json: Json = False) -> None:
    """List the data sets, their licences, and which are on this machine."""
    from martensite.scenario.datasets import dataset_names, describe_dataset
    from martensite.show.terminal import print_summary

    found = [describe_dataset(name) for name in dataset_names()]
    here = {one.name: _count_here(one.name) for one in found}
    rows = [(d.name, d.title, d.licence, str(len(d.files)), here[d.name]) for d in found]
    table = DataTable(("data set", "what it is", "licence", "files", "on this machine"), rows)
    data = [asdict(one) | {"here": here[one.name]} for one in found]
    print_summary(Summary("", [table], data), json)


def _count_here(name: str) -> str:
    from martensite.base.errors import DataError
    from martensite.scenario.datasets import describe_dataset, locate_file

    found = 0
    files = describe_dataset(name).files
    for file in files:
        try:
            locate_file(f"{name}/{file}")
        except DataError:
            continue
        found += 1
    return "yes" if found == len(files) else "no" if not found else f"{found} of {len(files)}"


@data.command("show")
def show_one(name: Annotated[str, typer.Argument(metavar="NAME", help="A data set.")], json: Json = False) -> None:
    """Show a data set: what it holds, what it is not, where it comes from, its files."""
    from martensite.scenario.datasets import describe_dataset
    from martensite.show.terminal import print_summary

    dataset = describe_dataset(name)
    rows = [(f"data:{name}/{f.name}", ", ".join(f.layout.columns)) for f in dataset.files.values()]
    blocks = [
        Sentence(f"Caution: {dataset.caution}", "caution"),
        Sentence(f"Licence: {dataset.licence}, {dataset.notice}. Source: {dataset.page}"),
        DataTable(("file", "columns"), rows),
    ]
    title = f"{dataset.name}: {dataset.title}"
    print_summary(Summary(title, blocks, asdict(dataset), dataset.summary), json)


@data.command()
def fetch(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A data set.")],
    force: Annotated[bool, typer.Option("--force", help="Download what is there, too.")] = False,
    json: Json = False,
) -> None:
    """Download a data set from its authors, and check every file against its SHA-256."""
    from martensite.scenario import datasets
    from martensite.show.terminal import print_summary

    folder = str(datasets.fetch_dataset(name, force))
    print_summary(Summary(f"{name} is in {folder}", [], {"name": name, "folder": folder}), json)
