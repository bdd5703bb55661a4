"""`tune`: gains of the controller of a scenario, by rules, by a relay, or downhill on the bench."""

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

METHODS = ("rules", "relay", "gradient")


@app.command()
def tune(
    scenario: ScenarioFile,
    settings: Settings = None,
    method: Annotated[
        str, typer.Option(help="rules (step test), relay, or gradient (through the loop itself).")
    ] = "gradient",
    rule: Annotated[
        str | None,
        typer.Option(
            help="Of --method rules [default: simc], such as amigo or cohen-coon; "
            "of relay [default: tyreus-luyben]."
        ),
    ] = None,
    form: Annotated[
        str | None, typer.Option(help="pi or pid, for rules and relay [default: pid].")
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(
            help='Level of step and relay test, e.g. "4 mm" [default: the middle of what the '
            "reference asks for]."
        ),
    ] = None,
    free: Annotated[
        str | None,
        typer.Option(
            help="What is searched by gradient, comma-separated [default: Kp,Ki,Kd of a pid]."
        ),
    ] = None,
    goal: Annotated[
        str | None, typer.Option(help="itae, iae, or ise, for gradient [default: itae].")
    ] = None,
    spread: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=SPREAD",
            help='How far plants are from the scenario, e.g. --spread element.diameter="3 %" or '
            '--spread environment.temperature="3 K"; repeatable.',
        ),
    ] = None,
    plants: Annotated[
        int | None, typer.Option(help="Plants drawn within the spreads [default: 64].")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the plants and of scattered starts.")] = 0,
    loop: Annotated[
        str | None, typer.Option(help="Drive whose controller is tuned, if there are several.")
    ] = None,
    duration: Annotated[
        str | None, typer.Option(help='Length of a run, e.g. "10 s" [default: the scenario\'s].')
    ] = None,
    save: Annotated[
        Path | None, typer.Option(help="Scenario with the new numbers to write: .toml.")
    ] = None,
    figure: Figure = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Tune the controller of a scenario, and show its loop.

    The scenario needs sections [controller] and [reference]. With --spread, the gradient is that
    of the mean over many plants, and the result is judged on as many others.
    """
    import_modules(modules)
    from martensite.cli.outputs import Outputs
    from martensite.cli.tune_run import Given, run_tuning
    from martensite.cli.tune_show import shown
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    outputs = Outputs(save, figure).check(force, data=(".toml",))
    given = Given(
        method, rule, form, level, free, goal, tuple(spread or ()), plants, seed, loop, duration
    )
    given.check()
    loaded = load(scenario, read_settings(settings or []))
    shown(run_tuning(loaded, given), outputs, json)
