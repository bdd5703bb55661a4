"""`tune` and `benchmark`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from typer import Option

from martensite.base.errors import InputError, UnknownNameError
from martensite.cli.app import app
from martensite.cli.options import ScenarioSource, Text, Texts, spread_options
from martensite.cli.outputs import JudgedOptions, name_interrupted

METHODS = ("rules", "relay", "gradient", "schedule")


@dataclass(frozen=True)
class TuneOptions:
    """Options of a tuning."""

    method: Annotated[
        str,
        Option(
            help=(
                "Method: rules (step test), relay, gradient (through the closed loop), or schedule (PI gains "
                "over stroke and branch)."
            )
        ),
    ] = "gradient"
    rule: Annotated[
        Text, Option(help="Tuning rule, e.g. simc, amigo or cohen-coon [default: simc; tyreus-luyben for relay].")
    ] = None
    form: Annotated[Text, Option(help="Controller form: pi or pid [default: pid for rules, pi for relay].")] = None
    level: Annotated[
        Text, Option(help='Level of the step or relay test, e.g. "4 mm" [default: the centre of the reference].')
    ] = None
    free: Annotated[
        Text,
        Option(
            help=(
                "Parameters of the gradient search, with optional bounds, e.g. Kp=1..100,Ki [default: Kp,Ki,Kd "
                "of a pid]."
            )
        ),
    ] = None
    goal: Annotated[Text, Option(help="Goal of the gradient search: itae, iae, or ise [default: itae].")] = None
    spread: Annotated[
        Texts,
        Option(
            metavar="PATH=SPREAD",
            help=(
                'Spread of the plants around the scenario, e.g. element.diameter="3 %" or '
                'environment.temperature="3 K"; repeatable.'
            ),
        ),
    ] = None
    plants: Annotated[int | None, Option(help="Number of plants drawn within the spreads [default: 64].")] = None
    seed: Annotated[int, Option(help="Seed of the plants and of random starting points.")] = 0
    sensitivity: Annotated[
        float | None, Option(help="Maximum sensitivity M_s of --method schedule [default: 1.4].")
    ] = None
    loop: Annotated[Text, Option(help="Drive whose controller is tuned; needed if there are several.")] = None
    duration: Annotated[Text, Option(help='Duration of a run, e.g. "10 s" [default: that of the scenario].')] = None

    def check(self) -> None:
        """Raise `InputError` for an unknown method, or an option without effect."""
        if self.method not in METHODS:
            raise UnknownNameError("method of tuning", self.method, METHODS)
        search = {"free": self.free, "goal": self.goal}
        rules = {"rule": self.rule, "form": self.form}
        schedule = {"sensitivity": self.sensitivity}
        tests = {"level": self.level}
        idle = {"gradient": rules | schedule, "schedule": search | rules | tests}.get(self.method, search | schedule)
        name = next((name for name, value in idle.items() if value is not None), None)
        if name is not None:
            raise InputError(f"Option `--{name}` has no effect with --method {self.method}.")
        methods = self._list_rules()
        if self.rule is not None and self.rule not in methods:
            raise UnknownNameError(f"rule for --method {self.method}", self.rule, methods)
        if self.plants is not None and not self.spread:
            raise InputError("Option `--plants` has no effect without --spread.")

    def _list_rules(self) -> list[str]:
        from martensite.control.rules.formulas import RULES
        from martensite.control.rules.relay import RELAY_RULES

        return list(RULES if self.method == "rules" else RELAY_RULES)


@app.command("tune", rich_help_panel="Design")
@spread_options
def tune(
    source: ScenarioSource,
    options: TuneOptions,
    answer: JudgedOptions,
    out: Annotated[Path | None, Option(help="Scenario with the tuned controller to write: .toml.")] = None,
) -> None:
    """Tune the controller of a scenario and compare the loops.

    The scenario needs the sections [controller] and [reference]. With --spread the search uses the mean over many
    plants. The result is compared with the present controller on other plants, and tested like `check`. If the
    result is worse, the exit code is 1, and --save-anyway writes it.
    """
    outputs = answer.check_files(out, ".toml")
    options.check()
    loaded = source.load()
    if options.method == "schedule":
        from martensite.cli.tune_schedule import run_schedule

        tuned = run_schedule(loaded, options)
    else:
        from martensite.cli.tune_run import run_tuning

        tuned = run_tuning(loaded, options, name_interrupted(out, source.file))
    if tuned.give(outputs, answer):
        raise typer.Exit(1)
