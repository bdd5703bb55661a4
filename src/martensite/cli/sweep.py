"""`sweep`: many variants of a scenario, into a store that survives interruptions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, ScenarioFile, Settings, import_modules, quantity


@app.command()
def sweep(
    scenario: ScenarioFile,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=NUMBERS",
            help='What is varied: "diameter=0.1..0.5 mm:9", "A_s=68, 70 degC", '
            '"length=250 mm +- 2 %"; repeatable.',
        ),
    ] = None,
    sample: Annotated[
        str, typer.Option(help="grid, or a sample and its size: sobol:1024, latin-hypercube:1000 …")
    ] = "grid",
    output: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MEASURE",
            help='One number kept of every run: stroke, "max(stress)", energy, rise-time …; '
            "repeatable [default: stroke, max(temperature), max(stress), energy].",
        ),
    ] = None,
    trace: Annotated[
        list[str] | None,
        typer.Option(metavar="OUTPUT:SAMPLES", help="A column kept over time; repeatable."),
    ] = None,
    settings: Settings = None,
    out: Annotated[
        Path | None, typer.Option(help="Zarr store to write, or to go on with [./SCENARIO.zarr].")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the sample.")] = 0,
    step: Annotated[
        str | None, typer.Option(help="Longest of equal steps [default: an error control].")
    ] = None,
    runtime: Annotated[
        str | None, typer.Option(help="c, jax or floats [default: c, if there is a compiler].")
    ] = None,
    precision: Annotated[str, typer.Option(help="float64, or float32 on JAX.")] = "float64",
    backend: Annotated[
        str | None,
        typer.Option(
            help="Who runs the chunks: processes, serial, dask [default: processes; serial for a "
            "few chunks, or on JAX]."
        ),
    ] = None,
    workers: Annotated[
        int, typer.Option(min=0, help="How many processes; 0 for one per core.")
    ] = 0,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, such as tcp://host:8786.")
    ] = None,
    chunk_size: Annotated[int, typer.Option(min=1, help="Runs in a chunk.")] = 512,
    chunk: Annotated[
        str | None,
        typer.Option(metavar="I/N", help="Run only part I of N of the chunks, for job arrays."),
    ] = None,
    figure: Annotated[
        Path | None, typer.Option(help="Figure to write, or to replace: .png, .svg or .pdf.")
    ] = None,
    modules: Imports = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing store.")] = False,
    json: Json = False,
) -> None:
    """Run many variants of a scenario; go on where it stopped."""
    import_modules(modules)
    from martensite.cli.outputs import Outputs
    from martensite.cli.sweep_run import swept
    from martensite.design.sweep.api import How
    from martensite.design.sweep.job import MEASURES, Wanted
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    Outputs(None, figure).check(force=True)
    wanted = Wanted(
        over=tuple(over or ()), sample=sample, measures=tuple(output or MEASURES),
        traces=tuple(_trace(words) for words in trace or ()), seed=seed, chunk=chunk_size,
        step=None if step is None else quantity("step", step, "s"), runtime=runtime,
        precision=precision,
    )  # fmt: skip
    how = How(backend, workers, scheduler, chunk, tuple(modules or ()), force)
    path = out or Path(f"{scenario.stem}.zarr")
    swept(load(scenario, read_settings(settings or [])), wanted, path, how).show(json)
    if figure is not None:
        _draw(path, figure)


def _draw(store: Path, path: Path) -> None:
    from martensite.design.sweep.reading import read_sweep
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.sweep import plot_sweep

    write_figure(plot_sweep(read_sweep(store)), path)


def _trace(words: str) -> tuple[str, int]:
    from martensite.base.errors import InputError

    name, _, count = words.rpartition(":")
    if not name or not count.isdecimal() or int(count) < 2:
        raise InputError(f"`{words}` is no trace; write an output and 2 samples or more, `T:101`.")
    return name, int(count)
