"""`run`: simulate a scenario, print a summary, write data and figure."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, ScenarioFile, Settings, import_modules, quantity
from martensite.errors import InputError


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
    columns: Annotated[
        str | None, typer.Option(help="What the columns of that record are, comma-separated.")
    ] = None,
    no_compare: Annotated[bool, typer.Option("--no-compare", help="Compare with nothing.")] = False,
    tolerance: Annotated[
        float | None, typer.Option(help="Replaces the tolerance of the scenario.")
    ] = None,
    runtime: Annotated[str, typer.Option(help="floats, jax, or c.")] = "floats",
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
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
    json: Json = False,
) -> None:
    """Simulate a scenario: a summary, a netCDF file and a figure."""
    _refuse_idle("--columns", columns is not None and compare is None, "there is no --compare")
    _refuse_idle("--figure", figure is not None and no_figure, "--no-figure is given")
    _refuse_idle("--compare", compare is not None and no_compare, "--no-compare is given")
    import_modules(modules)
    from martensite.cli.execute import Wanted, execute
    from martensite.cli.outputs import Outputs
    from martensite.io.overrides import read_settings
    from martensite.io.scenario import load

    loaded = load(scenario, read_settings(settings or []))
    drawn = None if no_figure else figure or Path(f"{scenario.stem}.png")
    outputs = Outputs(out or Path(f"{scenario.stem}.nc"), drawn, profile).check(force)
    names = [name.strip() for name in columns.split(",")] if columns else None
    pulses = None if carrier is None else quantity("carrier", carrier, "Hz")
    wanted = Wanted(outputs, tolerance, runtime, compare, names, no_compare, pulses)
    execute(loaded, wanted).show(json)


def _refuse_idle(option: str, idle: bool, reason: str) -> None:
    """An option without effect is a mistake of the caller."""
    if idle:
        raise InputError(f"Option `{option}` has no effect, since {reason}.")
