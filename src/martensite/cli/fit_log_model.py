"""`fit LOG...` without a scenario: propose scenarios and keep the best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

from typer import Exit, Option

from martensite.base.errors import InputError
from martensite.base.interrupts import InterruptError, rescue_answer
from martensite.cli.fit_best import tell_best
from martensite.cli.options import Text
from martensite.cli.outputs import check_absent, check_ending, check_folder
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    from martensite.fit.log_models import LogModel
    from martensite.fit.problem import Problem
    from martensite.fit.search_monitor import SearchNote

NEEDLESS = ("each", "column", "noise", "method", "loss", "step")
"""Options that require a scenario file."""


@dataclass(frozen=True)
class ModelOptions:
    """Settings for logs without a scenario."""

    experiment: Annotated[
        Text,
        Option(
            metavar="KIND",
            help=(
                "Experiment if there is no --scenario, e.g. isobaric; `martensite list experiment` lists all "
                "[default: recognised from the columns]."
            ),
        ),
    ] = None
    save_scenario: Annotated[
        Path | None, Option(metavar="FILE", help="Proposed scenario with the fitted parameters to write: .toml.")
    ] = None

    def refuse_beside_scenario(self) -> None:
        """Raise `InputError` if a scenario is given."""
        for name, given in (("--experiment", self.experiment), ("--save-scenario", self.save_scenario)):
            if given is not None:
                raise InputError(f"Option `{name}` has no effect with --scenario.")

    def find_scenario_file(self, report: Path | None) -> Path | None:
        """Return the scenario file: as given, or next to the report."""
        return self.save_scenario or (None if report is None else report.with_suffix(".toml"))

    def check(self, given: object, report: Path | None, force: bool) -> None:
        """Raise an error for options without effect and files that cannot be written."""
        idle = next((name for name in NEEDLESS if getattr(given, name, None) is not None), None)
        if idle is not None:
            raise InputError(f"Option `--{idle.replace('_', '-')}` needs --scenario and --free, or has no effect.")
        check_ending(self.save_scenario, (".toml",))
        path = self.find_scenario_file(report)
        if path is not None:
            check_folder(path)
            check_absent(path, force)


def fit_alone(
    logs: Sequence[str],
    options: ModelOptions,
    settings: Sequence[str],
    search: Mapping[str, Any],
    files: tuple[Path | None, Path | None],
    json: bool,
) -> NoReturn:
    """Make a model of logs without a scenario, print it, write report and material, and end with the exit code."""
    latest: dict[str, Any] = {}

    def keep(problem: Problem, note: SearchNote) -> None:
        latest.update(problem=problem, note=note)

    report, material = files
    whole = {**search, "keep": keep}
    with rescue_answer(lambda: tell_best(latest, None, json)):
        model = fit_log_model(logs, options, settings, search=whole, report=report, material=material, json=json)
    if model.stop_reason == "interruption":
        raise Exit(InterruptError.exit_code)
    raise Exit(0 if model.predicts else 1)


def fit_log_model(
    logs: Sequence[str],
    options: ModelOptions,
    settings: Sequence[str],
    *,
    search: Mapping[str, Any],
    report: Path | None = None,
    material: Path | None = None,
    json: bool = False,
) -> LogModel:
    """Fit proposed models to logs and print the result; `search` has further arguments of `model_logs`."""
    from martensite.fit.log_models import model_logs
    from martensite.scenario.overrides import read_settings
    from martensite.show.pages import write_page
    from martensite.show.summaries.log_model import summarise_log_model
    from martensite.show.terminal import print_summary

    with show_spinner("recognising, fitting, leaving out"):
        model = model_logs(list(logs), experiment=options.experiment, overrides=read_settings(list(settings)), **search)
    scenario, command = options.find_scenario_file(report), ""
    written: list[Path] = []
    if scenario is not None:
        scenario.write_text(model.write_scenario(), encoding="utf-8")
        tables = [] if model.follows_logs else write_records(model, scenario)
        written += [scenario, *tables]
        command = write_command(model, tables or logs, scenario, None if tables else search.get("interval"))
    summary = summarise_log_model(model, command)
    if material is not None:
        from martensite.fit.material_files import write_material

        write_material(model.fit, material, scenario=model.fit.scenario)
        written.append(material)
    if report is not None:
        written += write_page(summary, report)
    print_summary(summary, json, written)
    return model


def write_records(model: LogModel, scenario: Path) -> list[Path]:
    """Write the records that the scenario follows, if it needs columns that the logs lack."""
    from martensite.base.files import write_file
    from martensite.logs.record_text import format_record

    written: list[Path] = []
    for record in model.chosen_model.proposal.rows:
        written.append(scenario.with_name(f"{scenario.stem}_{record.name}.csv"))
        write_file(written[-1], format_record(record, list(record.columns)))
    return written


def write_command(model: LogModel, logs: Sequence[str | Path], scenario: Path, interval: float | None) -> str:
    """Return the command that fits a saved scenario to the same logs."""
    proposal = model.chosen_model.proposal
    words = ["martensite", "fit", *map(str, logs), "--scenario", str(scenario), "--free", ",".join(proposal.free)]
    words += [word for one in proposal.each for word in ("--each", one)]
    words += [word for one in proposal.columns for word in ("--column", one)]
    words += [word for one in ((model.heading_options or ()) if model.follows_logs else ()) for word in ("--as", one)]
    words += [] if interval is None else ["--interval", f"{interval:.12g} s"]
    return " ".join(map(quote, words))
