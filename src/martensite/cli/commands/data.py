"""`data`: published measurements, and the columns of log files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument, Option

from martensite.base.errors import InputError
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import Force, Json, NamedColumns, Texts, read_quantity, refuse_idle
from martensite.cli.outputs import Outputs, check_absent, check_ending, check_folder

if TYPE_CHECKING:
    from martensite.logs.lab_files import LabFile

data = typer.Typer(help="Measured files and published data sets: list, show, fetch.")

app.add_typer(data, name="data", invoke_without_command=True, rich_help_panel="Look up")


@data.callback()
def overview(ctx: typer.Context, json: Json = False) -> None:
    """Show measured files, list and download published data sets."""
    if ctx.invoked_subcommand is None:
        list_all(json)


@data.command("list")
def list_all(json: Json = False) -> None:
    """List the data sets with their licences and local state."""
    from martensite.logs.datasets import dataset_names, describe_dataset
    from martensite.show.terminal import print_summary

    entries = [describe_dataset(name) for name in dataset_names()]
    here = {one.name: _count_here(one.name) for one in entries}
    rows = [(d.name, d.title, d.licence, str(len(d.files)), here[d.name]) for d in entries]
    table = DataTable(("data set", "what it is", "licence", "files", "on this machine"), rows)
    data = [asdict(one) | {"here": here[one.name]} for one in entries]
    print_summary(Summary("", [table], data), json)


def _count_here(name: str) -> str:
    from martensite.base.errors import DataError
    from martensite.logs.datasets import describe_dataset, locate_file

    count = 0
    dataset = describe_dataset(name)
    files = dataset.files
    if dataset.packaged is not None:
        return "in the package"
    for file in files:
        try:
            locate_file(f"{name}/{file}")
        except DataError:
            continue
        count += 1
    return "yes" if count == len(files) else "no" if not count else f"{count} of {len(files)}"


@data.command("show")
def show_data(
    names: Annotated[
        list[str],
        Argument(metavar="FILE...", help="Files of instruments in any layout, or the name of one published data set."),
    ],
    new_headings: NamedColumns = None,
    merge: Annotated[bool, Option("--merge", help="Join the files on the clock of the first file.")] = False,
    offset: Annotated[
        Texts,
        Option(
            metavar="TIME",
            help=(
                'Start of each further file on the clock of the first file, e.g. "1.5 s" [default: found from '
                "the data]."
            ),
        ),
    ] = None,
    out: Annotated[Path | None, Option(metavar="CSV", help="Table to write in SI units: .csv.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Show the contents of measured files or of a data set.

    Layout, units, clocks and columns are recognised. Guesses are marked, and --as corrects them.
    """
    from martensite.logs.datasets import dataset_names

    if len(names) == 1 and names[0] in dataset_names():
        _show_set(names[0], json)
        return
    from martensite.logs.merged_files import merge_by_clock
    from martensite.show.summaries.lab_file import summarise_lab_files

    check_ending(out, (".csv",))
    refuse_idle("--merge", merge and len(names) < 2, "there is one file only")
    refuse_idle("--offset", bool(offset) and not merge, "files are joined by --merge only")
    if out is not None:
        check_folder(out)
        check_absent(out, force)
    tables = _read_files(names, new_headings or ())
    if merge:
        offsets = [read_quantity("offset", text, "s") or 0.0 for text in offset or ()]
        tables = [merge_by_clock(tables, offsets or None)]
    if out is not None and len(tables) > 1:
        raise InputError(f"`{out}` takes one table, but there are {len(tables)} files; join them by --merge.")
    Outputs(out, None).answer(_name_experiment(summarise_lab_files(tables), tables), json, tables[0].to_csv)


def _name_experiment(summary: Summary, tables: Sequence[LabFile]) -> Summary:
    """Return the summary with the kind of experiment in the tables, if it is recognised."""
    from martensite.base.errors import DataError
    from martensite.fit.experiment_kinds.base import recognise_experiment

    try:
        experiment = recognise_experiment([one.record for one in tables])
    except DataError:
        return summary
    command = f"martensite fit {experiment.kind.command}".strip()
    text = f"Experiment `{experiment.name}`: {experiment.kind.meaning}. `{command} FILE` evaluates it."
    return replace(summary, blocks=[*summary.blocks, Sentence(text)])


def _read_files(names: list[str], new_headings: Iterable[str]) -> list[LabFile]:
    """Return all tables of files, without unreadable rows."""
    from martensite.logs.container_files import list_sheets
    from martensite.logs.lab_files import read_lab_file
    from martensite.logs.reader import choose_tables, parse_new_headings, part_label

    tables: list[LabFile] = []
    for whole, label in map(part_label, names):
        sheets = [read_lab_file(sheet, parse_new_headings(new_headings)) for sheet in list_sheets(whole)]
        tables += choose_tables(sheets, whole, label)
    return tables


def _show_set(name: str, json: bool) -> None:
    from martensite.logs.datasets import describe_dataset
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


@data.command("fetch")
def fetch(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of a data set, see `martensite data list`.")],
    force: Annotated[bool, typer.Option("--force", help="Download files again that already exist.")] = False,
    json: Json = False,
) -> None:
    """Download a data set from its authors and verify its SHA-256."""
    from martensite.logs import datasets
    from martensite.show.terminal import print_summary

    folder = datasets.fetch_dataset(name, force)
    packaged = folder == datasets.describe_dataset(name).packaged
    title = f"{name} is in the package: there is nothing to fetch" if packaged else f"{name} is in {folder}"
    print_summary(Summary(title, [], {"name": name, "folder": str(folder)}), json)
