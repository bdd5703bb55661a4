"""`run`: simulate a scenario, print a summary, write data and figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from martensite.base.errors import InputError
from martensite.cli.app import app
from martensite.cli.options import (
    Force,
    Imports,
    Json,
    ScenarioFile,
    Settings,
    import_modules,
    quantity,
)

if TYPE_CHECKING:
    from martensite.signals.records import Record


@app.command()
def run(
    scenario: ScenarioFile,
    settings: Settings = None,
    out: Annotated[
        Path | None, typer.Option(help="netCDF file to write [default: ./SCENARIO.nc].")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(help="Figure to write: .png, .svg or .pdf [default: ./SCENARIO.png]."),
    ] = None,
    no_figure: Annotated[bool, typer.Option("--no-figure", help="Draw nothing.")] = False,
    compare: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="A record to compare with [default: the scenario's own]."
        ),
    ] = None,
    log: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="The log that the scenario follows; it is compared with as well."
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(help="What the columns of such a record or log are, comma-separated."),
    ] = None,
    no_compare: Annotated[bool, typer.Option("--no-compare", help="Compare with nothing.")] = False,
    tolerance: Annotated[
        float | None, typer.Option(help="Replaces the tolerance of the scenario.")
    ] = None,
    runtime: Annotated[
        str | None,
        typer.Option(
            help="auto, floats, c or jax [default: auto, what is done first; on a bench c, if "
            "there is a compiler]."
        ),
    ] = None,
    budget: Annotated[
        str | None,
        typer.Option(metavar="TIME", help='Give up after so much CPU time, e.g. "30 s".'),
    ] = None,
    profile: Annotated[
        Path | None,
        typer.Option(help="Figure of temperature and fraction along an axial-wire or a ribbon."),
    ] = None,
    carrier: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY",
            help='Make every pulse of a switched drive at this frequency ("100 Hz") as well, '
            "and say what the averaged run leaves out.",
        ),
    ] = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Simulate a scenario: a summary, a netCDF file and a figure.

    A run that leaves the envelope (melting, 3 GPa, a strain of 20 %, or a bound of your own)
    stops there, keeps what was computed until then, and exits with 1.
    """
    lone = columns is not None and compare is None and log is None
    _refuse_idle("--columns", lone, "there is neither --compare nor --log")
    _refuse_idle("--figure", figure is not None and no_figure, "--no-figure is given")
    _refuse_idle("--compare", compare is not None and no_compare, "--no-compare is given")
    import_modules(modules)
    from martensite.cli.execute import Wanted, execute
    from martensite.cli.outputs import Outputs
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    names = [name.strip() for name in columns.split(",")] if columns else None
    record = None if log is None else _read_log(log, None if compare else names)
    loaded = load(scenario, read_settings(settings or []), log=record)
    idle = log is not None and not loaded.follows
    _refuse_idle("--log", idle, "no waveform of the scenario is of kind `log`; use --compare")
    closed = loaded.bench is not None
    _refuse_idle("--tolerance", closed and tolerance is not None, "a bench runs in its periods")
    outer = closed and bool(loaded.outside) and runtime is not None
    _refuse_idle("--runtime", outer, "a controller that is no kernel runs on floats")
    drawn = None if no_figure else figure or Path(f"{scenario.stem}.png")
    outputs = Outputs(out or Path(f"{scenario.stem}.nc"), drawn, profile).check(force)
    pulses = None if carrier is None else quantity("carrier", carrier, "Hz")
    _refuse_idle("--budget", closed and budget is not None, "a bench runs in its periods")
    most = None if budget is None else quantity("budget", budget, "s")
    wanted = Wanted(
        outputs, tolerance, runtime, compare, names, no_compare, record, pulses, json, most
    )
    done = execute(loaded, wanted)
    done.show(json)
    if done.result.status.failed:
        raise typer.Exit(1)


def _read_log(log: str, columns: list[str] | None) -> Record:
    from martensite.scenario.tables import read_table

    return read_table(log, columns, gaps=True)


def _refuse_idle(option: str, idle: bool, reason: str) -> None:
    """An option without effect is a mistake of the caller."""
    if idle:
        raise InputError(f"Option `{option}` has no effect, since {reason}.")
