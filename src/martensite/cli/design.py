"""`design`: numbers of a scenario for which a goal is best and limits are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import (
    Figure,
    Force,
    Imports,
    Json,
    ScenarioFile,
    Settings,
    import_modules,
)


@app.command()
def design(
    scenario: ScenarioFile,
    settings: Settings = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=LOW..HIGH",
            help='What may change, e.g. --free "element.diameter=0.05..0.5 mm" or '
            '--free "drive.peak=1..5 W"; repeatable.',
        ),
    ] = None,
    minimise: Annotated[
        str | None, typer.Option(help='What shall be least, e.g. "max(stress)" [default: energy].')
    ] = None,
    maximise: Annotated[str | None, typer.Option(help='What shall be most, e.g. "stroke".')] = None,
    subject: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MEASURE<=LIMIT",
            help='What must hold, e.g. --subject "max(stress) <= 200 MPa"; repeatable.',
        ),
    ] = None,
    life: Annotated[
        str | None,
        typer.Option(
            help='Keep the limits that the elements declare, with this much to spare, e.g. "10 %".'
        ),
    ] = None,
    case: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUE",
            help='Another case in which it must hold, e.g. --case "environment.temperature='
            '35 degC"; repeatable.',
        ),
    ] = None,
    grid: Annotated[
        int | None,
        typer.Option(help="Compare with all designs of a grid of so many points along a number."),
    ] = None,
    sample: Annotated[int, typer.Option(help="Designs of the first sample, a power of 2.")] = 64,
    descents: Annotated[int, typer.Option(help="Designs from which it is descended.")] = 3,
    seed: Annotated[int, typer.Option(help="Of the sample.")] = 0,
    save: Annotated[
        Path | None, typer.Option(help="Scenario with the numbers found to write: .toml.")
    ] = None,
    figure: Figure = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find numbers for which a goal is best and limits are kept.

    Goal and limits are measures of its run, such as stroke, rise-time, energy, max(stress) or
    at(position, time=2 s). The search follows derivatives through the simulation.
    """
    import_modules(modules)
    from martensite.cli.design_run import Given, run_design
    from martensite.cli.design_show import shown
    from martensite.cli.outputs import Outputs
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    outputs = Outputs(save, figure).check(force, data=(".toml",))
    given = Given(
        tuple(free or ()), minimise, maximise, tuple(subject or ()), life, tuple(case or ()), grid,
        sample, descents, seed,
    )  # fmt: skip
    given.check()
    loaded = load(scenario, read_settings(settings or []))
    found = run_design(loaded, given, saved=save is not None)
    shown(found, loaded, outputs, json)
