"""Commands of the benchmark of control, run from a checkout by `python -m benchmarks.control`.

`control` runs and ranks, `guards` compares guards, and `tune` finds the numbers of the entries.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Option

from martensite.base.errors import SolveError, require_known
from martensite.cli.app import PlainErrors
from martensite.cli.options import Json, Texts, refuse_idle, spread_options
from martensite.cli.outputs import AnswerOptions, Outputs
from martensite.cli.progress import show_progress

if TYPE_CHECKING:
    from benchmarks.control.competition import BenchmarkTable
    from martensite.base.summary import Summary

benchmark = typer.Typer(
    cls=PlainErrors,
    help="Compare controllers on fixed tasks, wires and faults.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
ALL, NONE = "all", "none"
QUICK = ("pid", "sliding-mode", "on-off", "direct", "cascade")
"""Entries of a quick run."""


@dataclass(frozen=True)
class BenchmarkOptions:
    """Options that choose entries, tasks, faults and wires."""

    shown: Annotated[bool, Option("--list", help="Show tasks, entries and faults, and run nothing.")] = False
    entry: Annotated[
        Texts, Option(help="Entry of the benchmark; repeatable [default: all, or none next to your own].")
    ] = None
    controller: Annotated[
        Texts,
        Option(metavar="FILE[:NAME]", help="Controller of your own: FILE.py:NAME, FILE.c, FILE.toml; repeatable."),
    ] = None
    task: Annotated[Texts, Option(help="Task; repeatable [default: all].")] = None
    fault: Annotated[Texts, Option(help="Fault besides none at all; repeatable; or all, or none [default: all].")] = (
        None
    )
    wires: Annotated[int, Option(min=1, max=64, help="The first so many wires; a power of 2.")] = 64
    seed: Annotated[int | None, Option(help="Seed of wires and noise, for held-out wires [default: 20260].")] = None
    read: Annotated[Path | None, Option(help="Show a table that was saved as .json, and run nothing.")] = None
    quick: Annotated[bool, Option("--quick", help="8 wires, one task, no faults, five entries.")] = False
    workers: Annotated[int, Option(min=1, help="Threads.")] = 2


@benchmark.command()
@spread_options
def control(
    options: BenchmarkOptions,
    answer: AnswerOptions,
    save: Annotated[Path | None, Option(help="Table to write: .csv, .json, or .nc with every wire.")] = None,
) -> None:
    """Run the benchmark of control, and rank the controllers.

    All entries run if none is named and no controller of your own is given. Exit code 1 if a run without a
    fault has no result.
    """
    outputs = answer.check_files(save, ".csv", ".json", ".nc")
    if options.shown:
        refuse_idle("--save", save is not None, "--list runs nothing")
        outputs.answer(_list_parts(), answer.json)
        return
    table = _run_benchmark(options) if options.read is None else _read_saved(options.read)
    _answer_table(table, outputs, answer.json)
    lost = [f"{one.entry} on {one.task}" for one in table.select(fault="none") if one.failed > 0.0]
    if lost:
        raise SolveError(f"Runs without a result: {', '.join(dict.fromkeys(lost))}.")


def _run_benchmark(options: BenchmarkOptions) -> BenchmarkTable:
    from benchmarks.control.competition import EntryRuns, list_faults, run_benchmark
    from benchmarks.control.entries import find_entry, load_entries
    from benchmarks.control.strangers import read_stranger
    from benchmarks.control.tasks import find_task, load_tasks
    from benchmarks.control.wires import SEED

    quick = options.quick
    names = options.entry or (list(QUICK) if quick else [] if options.controller else None)
    entries = list(load_entries().values()) if names is None else [find_entry(name) for name in names]
    competitors: list[Any] = [EntryRuns(one) for one in entries]
    competitors += [read_stranger(text) for text in options.controller or []]
    tasks = [find_task(name) for name in options.task or (["steps"] if quick else load_tasks())]
    faults = _choose_faults(options.fault or ([NONE] if quick else [ALL]), list_faults())
    wires = min(options.wires, 8) if quick else options.wires
    with show_progress("benchmark of control") as tell:
        seed = SEED if options.seed is None else options.seed
        return run_benchmark(competitors, tasks, faults, wires, seed=seed, workers=options.workers, tell=tell)


def _read_saved(path: Path) -> BenchmarkTable:
    from benchmarks.control.competition import read_table

    return read_table(path)


def _choose_faults(given: list[str], known: list[str]) -> list[str]:
    for name in given:
        require_known("fault", name, [*known, ALL, NONE])
    return known if ALL in given else [name for name in given if name != NONE]


def _answer_table(table: BenchmarkTable, outputs: Outputs, json: bool) -> None:
    from benchmarks.control.table_figure import plot_benchmark
    from benchmarks.control.table_files import format_table
    from benchmarks.control.table_summary import summarise_benchmark

    outputs.answer(
        summarise_benchmark(table),
        json,
        lambda: format_table(table, outputs.data.suffix if outputs.data else ".csv"),
        lambda: plot_benchmark(table),
    )


def _list_parts() -> Summary:
    from benchmarks.control.table_summary import summarise_parts

    return summarise_parts()


@benchmark.command()
def guards(
    entry: Annotated[Texts, Option(help="Entry; repeatable [default: all].")] = None,
    read: Annotated[Path | None, Option(help="Show a table that was saved, and run nothing.")] = None,
    save: Annotated[Path | None, Option(help="Table to write: .json.")] = None,
    json: Json = False,
) -> None:
    """Run entries for an hour without a fault, and under all faults, with the default guard and the benchmark's."""
    from benchmarks.control.entries import find_entry, load_entries
    from benchmarks.control.guard_runs import format_guards, read_guards, run_guards, summarise_guards
    from martensite.show.terminal import print_summary

    refuse_idle("--save", save is not None and read is not None, "--read runs nothing")
    if read is not None:
        print_summary(summarise_guards(read_guards(read)), json)
        return
    entries = [find_entry(name) for name in entry or load_entries()]
    with show_progress("guards of the benchmark") as tell:
        rows = run_guards(entries, tell=tell)
    if save is not None:
        save.write_text(format_guards(rows), encoding="utf-8")
    print_summary(summarise_guards(rows), json, [] if save is None else [save])


@benchmark.command()
def tune(
    save: Annotated[Path, Option(help="File of gains to write, or to continue: .toml.")],
    entry: Annotated[Texts, Option(help="Entry; repeatable [default: all].")] = None,
    plant: Annotated[Texts, Option(help="Plant; repeatable [default: all].")] = None,
    json: Json = False,
) -> None:
    """Search the numbers of the entries on the nominal wires; minutes. Entries that the file has already are kept."""
    from benchmarks.control.entries import find_entry, load_entries
    from benchmarks.control.search import format_gains, read_found, search_gains, summarise_gains
    from benchmarks.control.tasks import ORDER
    from martensite.show.terminal import print_summary

    for name in plant or []:
        require_known("plant", name, ORDER)
    entries = [find_entry(name) for name in entry or load_entries()]
    wanted = [(one, name) for name in plant or ORDER for one in entries if name in one.plants and one.free]
    found = read_found(save)
    with show_progress("searching gains") as tell:
        for k, (one, name) in enumerate(wanted):
            if (one.name, name) not in found or entry:
                found[(one.name, name)] = search_gains(one, name)
                save.write_text(format_gains(found), encoding="utf-8")
            if tell is not None:
                tell(k + 1, len(wanted))
    print_summary(summarise_gains(found), json, [save])
