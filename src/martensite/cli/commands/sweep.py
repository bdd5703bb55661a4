"""`sweep`, `sensitivity` and `pareto`."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from martensite.base.errors import InputError
from martensite.cli.app import app
from martensite.cli.options import Json, ScenarioSource, Text, Texts, read_quantity, spread_options
from martensite.cli.outputs import AnswerOptions, Outputs
from martensite.cli.progress import open_bar, show_spinner

if TYPE_CHECKING:
    from martensite.design.sweep.api import Progress
    from martensite.design.sweep.pareto import ParetoFront
    from martensite.design.sweep.table import SweepTable

StoreFolder = Annotated[Path, typer.Argument(metavar="STORE", help="Sweep store (Zarr folder).")]


@app.command("sweep", rich_help_panel="Design")
@spread_options
def sweep(
    source: ScenarioSource,
    over: Annotated[
        Texts,
        Option(
            metavar="NAME=NUMBERS",
            help=(
                'Varied parameter, e.g. "diameter=0.1..0.5 mm:9", "A_s=68, 70 degC" or "length=250 mm +- 2 %"; '
                "repeatable."
            ),
        ),
    ] = None,
    sample: Annotated[
        str, Option(help="Sampling: grid, or a method with its size, e.g. sobol:1024 or latin-hypercube:1000.")
    ] = "grid",
    output: Annotated[
        Texts,
        Option(
            metavar="MEASURE",
            help=(
                'Measure of every run, e.g. stroke, "max(stress)" or rise-time; repeatable [default: stroke, '
                "max(temperature), max(stress), energy]."
            ),
        ),
    ] = None,
    trace: Annotated[
        Texts, Option(metavar="OUTPUT:SAMPLES", help="Column stored over time, e.g. position; repeatable.")
    ] = None,
    out: Annotated[
        Path | None, Option(help="Sweep store (Zarr) to write or to resume [default: ./SCENARIO.zarr].")
    ] = None,
    seed: Annotated[int, Option(help="Seed of the sample.")] = 0,
    step: Annotated[Text, Option(help='Fixed time step, e.g. "10 ms" [default: error control].')] = None,
    runtime: Annotated[Text, Option(help="Runtime: c, cuda or floats [default: c if there is a compiler].")] = None,
    precision: Annotated[str, Option(help="Floating-point type: float64, or float32 on CUDA.")] = "float64",
    backend: Annotated[
        Text,
        Option(
            help=("Scheduling: processes, serial or dask [default: processes; serial for a few chunks or on CUDA].")
        ),
    ] = None,
    workers: Annotated[int, Option(min=0, help="Number of processes, 0 for one per core.")] = 0,
    scheduler: Annotated[Text, Option(help="Address of a Dask scheduler, e.g. tcp://host:8786.")] = None,
    chunk_size: Annotated[int, Option(min=1, help="Number of runs per chunk, many thousands for a GPU.")] = 512,
    chunk: Annotated[
        Text, Option(metavar="I/N", help="Part I/N of the chunks to run, for job arrays, e.g. 1/8.")
    ] = None,
    figure: Annotated[Path | None, Option(help="Figure to write or replace: .png, .svg or .pdf.")] = None,
    force: Annotated[bool, Option("--force", help="Overwrite an existing store.")] = False,
    json: Json = False,
) -> None:
    """Run variants of a scenario; resume an interrupted sweep."""
    from martensite.design.sweep.api import SweepExecution, begin_sweep
    from martensite.design.sweep.job import MEASURES, SweepRequest
    from martensite.show.figures.sweep import plot_sweep
    from martensite.show.summaries.sweep import summarise_sweep
    from martensite.show.terminal import print_summary

    outputs = Outputs(None, figure).check(force=True)
    loaded = source.load()
    wanted = SweepRequest(
        over=tuple(over or ()),
        sample=sample,
        measures=tuple(output or MEASURES),
        traces=tuple(_read_trace(words) for words in trace or ()),
        seed=seed,
        chunk=chunk_size,
        step=read_quantity("step", step, "s"),
        runtime=runtime,
        precision=precision,
    )
    how = SweepExecution(backend, workers, scheduler, chunk, tuple(source.modules or ()), force)
    path = out or Path(f"{source.file.stem}.zarr")
    with show_spinner(f"preparing {loaded.title}"):
        planned_sweep = begin_sweep(loaded, wanted, path, how)
    with show_sweep(loaded.title) as tell:
        progress = planned_sweep.run(tell)
    print_summary(summarise_sweep(planned_sweep.plan, planned_sweep.store, progress), json)
    if figure is not None:
        from martensite.design.sweep.reading import read_sweep

        outputs.write(draw=lambda: plot_sweep(read_sweep(path)))


def _read_trace(words: str) -> tuple[str, int]:
    name, _, count = words.rpartition(":")
    if not name or not count.isdecimal() or int(count) < 2:
        raise InputError(f"`{words}` is no trace; write an output and 2 samples or more, `T:101`.")
    return name, int(count)


@contextmanager
def show_sweep(label: str) -> Iterator[Callable[[Progress], None] | None]:
    """Yield a function that moves a bar with rate and failures of a sweep."""
    start = time.monotonic()
    with open_bar(label, None, counted=True) as move:
        yield move and (
            lambda now: move(total=now.runs, completed=now.done, rate=_write_rate(now, time.monotonic() - start))
        )


def _write_rate(now: Progress, elapsed: float) -> str:
    failed = sum(count for status, count in now.status.items() if status > 1)
    speed = "" if not elapsed or not now.new_runs else f"{now.new_runs / elapsed:.0f}/s"
    return f"{speed}, {failed} failed" if failed else speed


@app.command("sensitivity", rich_help_panel="Design")
@spread_options
def sensitivity(
    store: StoreFolder,
    answer: AnswerOptions,
    output: Annotated[
        Texts, Option(metavar="MEASURE", help="Measure of the sweep, e.g. stroke; repeatable [default: all].")
    ] = None,
) -> None:
    """Compute Sobol indices or other sensitivities of a sweep.

    A sweep with `--sample saltelli:1024` gives first and total order with intervals. A complete grid gives both
    without intervals. Any other sample gives first order, delta and derivatives.
    """
    from martensite.design.sweep.indices import compute_sensitivity as find_sensitivity
    from martensite.design.sweep.reading import read_sweep
    from martensite.show.figures.sweep_analysis import plot_sensitivity
    from martensite.show.summaries.sweep import summarise_sensitivity

    outputs = answer.check_files()
    table = read_sweep(store)
    indices = find_sensitivity(table, output)
    summary = summarise_sensitivity(store, table, indices)
    outputs.answer(summary, answer.json, draw=lambda: plot_sensitivity(indices, table.title))


@app.command("pareto", rich_help_panel="Design")
@spread_options
def pareto(
    store: StoreFolder,
    answer: AnswerOptions,
    minimise: Annotated[
        Texts, Option(metavar="MEASURE", help="Measure or varied parameter to minimise, e.g. energy; repeatable.")
    ] = None,
    maximise: Annotated[
        Texts, Option(metavar="MEASURE", help="Measure or varied parameter to maximise, e.g. stroke; repeatable.")
    ] = None,
    out: Annotated[Path | None, Option(help="Table of the Pareto front to write: .csv.")] = None,
) -> None:
    """Find the Pareto front of a sweep."""
    from martensite.design.sweep.pareto import find_pareto_front
    from martensite.design.sweep.reading import read_sweep
    from martensite.show.figures.sweep_analysis import plot_pareto
    from martensite.show.summaries.sweep import summarise_front

    outputs = answer.check_files(out, ".csv")
    table = read_sweep(store)
    front = find_pareto_front(table, minimise or (), maximise or ())
    outputs.answer(
        summarise_front(store, table, front),
        answer.json,
        lambda: _write_front(table, front),
        lambda: plot_pareto(table, front),
    )


def _write_front(table: SweepTable, front: ParetoFront) -> str:
    from martensite.logs.record_text import format_heading

    columns, text = front.columns(table), io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", *(format_heading(name, c.unit) for name, c in columns.items())])
    for run in front.runs:
        writer.writerow([int(run), *(float(c.values[run]) for c in columns.values())])
    return text.getvalue()
