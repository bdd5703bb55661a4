"""`check` and `params`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import typer

from martensite.base.errors import BudgetError, InputError
from martensite.base.formats import write_quantity
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import (
    Imports,
    Json,
    ScenarioFile,
    ScenarioSource,
    Settings,
    load_without_log,
    spread_options,
)
from martensite.cli.outputs import AnswerOptions, Outputs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.base.parameters import Leaf
    from martensite.control.loop.bench import Bench
    from martensite.control.margins.loop_check import LoopReport
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.judgement import Judgement
    from martensite.simulate.result import Result

TRIED = 5.0
"""CPU time [s] of the test run."""
ROUNDING = 1e-9
"""Relative to one step."""


@app.command("check", rich_help_panel="Simulate")
@spread_options
def check(source: ScenarioSource, answer: AnswerOptions) -> None:
    """Check a scenario: limits, drives and control loop.

    The command runs the scenario for at most 5 s of CPU time and applies the limits of `run`. It also tests a loop
    for sign, range, sample time and margins. The figure shows Bode and Nyquist plots. The exit code is 1 if a limit
    is exceeded or the loop has a fault.
    """
    from martensite.show.summaries.loop import check_scenario_loop, describe_loops, describe_verdict
    from martensite.simulate.judgement import judge_run

    outputs = answer.check_files()
    loaded = load_without_log(source.file, source.settings, source.modules)
    if "at" not in loaded.initial:  # `at` needs a run
        loaded.find_start(loaded.tolerance)
    report, (tried, unjudged) = _collect_report(loaded), _try_run(loaded)
    judged = None if tried is None else judge_run(tried)
    report |= {"limits": judged and judged.to_dict(), "not_judged": unjudged or None}
    if loaded.bench is not None:
        from martensite.scenario.guard_report import collect_guard

        report["guard"] = collect_guard(loaded)
    loops = None if loaded.bench is None or report["follows"] else check_scenario_loop(loaded, loaded.bench)
    outcome = describe_verdict(loops, judged, unjudged)
    verdict = replace(outcome, text=f"{loaded.title}: {outcome.text}")
    blocks = [
        verdict,
        *(() if tried is None or judged is None else _describe_run(tried, judged, loops, loaded.bench)),
        *_describe_report(report),
        *(() if loops is None else describe_loops(loops)),
    ]
    data = report if loops is None else report | {"loops": loops.to_dict()}
    outputs.answer(Summary("", blocks, data), answer.json, draw=_find_figure(loaded, outputs))
    if verdict.tone == "bad":
        raise typer.Exit(1)


def _try_run(scenario: Scenario) -> tuple[Result | None, str]:
    if scenario.follows:
        return None, "the scenario follows a log. Use `martensite run --log FILE` or `martensite fit`"
    try:
        return scenario.run(budget=TRIED), ""
    except BudgetError:
        return None, f"the run takes more than {TRIED:.3g} s of CPU time. Use `martensite run`"


def _describe_run(tried: Result, judged: Judgement, loops: LoopReport | None, bench: Bench | None) -> Iterator[Block]:
    """Yield extremes and warnings of a run that are not already in its verdict or loop tests."""
    from martensite.show.summaries.run import write_key_numbers

    yield Sentence(write_key_numbers(tried))
    members = {judged.outside, *(alarm.sentence for alarm in judged.alarms)}
    members |= set() if loops is None else {f"Warning: {one.sentence} {one.remedy}" for one in loops.findings}
    yield from (Sentence(words, "caution") for words in tried.warnings if words not in members)
    yield from map(Sentence, judged.list_remedies())
    end = float(tried.times[-1])
    cut = f"{tried.steps} steps" if bench is None else f"{round(end / bench.period)} periods of {bench.period:.6g} s"
    yield Sentence(f"Run: {end:.6g} s in {cut}.")


def _find_figure(scenario: Scenario, outputs: Outputs) -> Callable[[], Figure] | None:
    if outputs.figure is None:
        return None
    if scenario.bench is None:
        raise InputError(
            "The figure shows loop margins, but the scenario has no loop. Add a [controller] or omit `--figure`."
        )
    from martensite.show.figures.margins import plot_scenario_margins

    return lambda: plot_scenario_margins(scenario)


def _describe_report(report: dict[str, Any]) -> Iterator[Block]:
    yield from (Sentence(f"Caution: {caution}", "caution") for caution in report["cautions"])
    if report["doubtful"]:
        names = ", ".join(dict.fromkeys(path.rpartition(".")[2] for path in report["doubtful"]))
        count = len(report["doubtful"])
        values = "1 value is" if count == 1 else f"{count} values are"
        yield Sentence(f"{report['material']}: {values} assumed or recalled, not measured: {names}.", "caution")
    yield from (Sentence(f"Controller of {name}, {words}.") for name, words in report["controllers"].items())
    if report["follows"]:
        followed = ", ".join(f"`{drive}` column `{column}`" for drive, column in report["follows"].items())
        yield Sentence(f"Follows a log: {followed}.")
        return
    if report.get("guard") is not None:
        from martensite.scenario.guard_report import describe_guard

        yield from describe_guard(report["guard"])


def _collect_report(scenario: Scenario) -> dict[str, Any]:
    from martensite.control.loop.names import describe_controllers
    from martensite.physics.materials.base import DOUBTFUL
    from martensite.simulate.api import first_step

    period = None if scenario.bench is None else scenario.bench.period
    step = period or scenario.step or first_step(scenario.system, scenario.duration, scenario.samples)
    samples = 1 if period else scenario.samples
    doubtful = [p for p, o in scenario.origins.items() if o.partition(",")[0] in DOUBTFUL]
    return {
        "title": scenario.title,
        "material": scenario.material.name if scenario.material else None,
        "cautions": scenario.cautions,
        "doubtful": doubtful,
        "duration": scenario.duration,
        "first_step": step,
        "steps": max(math.ceil(scenario.duration / step - ROUNDING), samples - 1),
        "period": period,
        "tolerance": scenario.tolerance,
        "follows": scenario.follows,
        "controllers": {} if scenario.bench is None else describe_controllers(scenario.bench),
    }


@app.command("params", rich_help_panel="Look up")
def params(scenario: ScenarioFile, settings: Settings = None, json: Json = False, modules: Imports = None) -> None:
    """List all values of a scenario with their paths."""
    from martensite.show.terminal import print_summary

    rows = _list_values(load_without_log(scenario, settings, modules))
    cells = [(r["path"], write_quantity(r["value"], r["unit"]), r["from"], r["meaning"]) for r in rows]
    print_summary(Summary("", [DataTable(("path", "value", "from", "meaning"), cells)], rows), json)


def _list_values(scenario: Scenario) -> list[dict[str, Any]]:
    places, origins = scenario.places, scenario.origins
    entries = [
        _collect_value(scenario, path, leaf, places.unit(leaf))
        for leaf in scenario.leaves()
        if (path := places.path(leaf.path)) in origins or not places.is_copy(leaf.path)
    ]
    return [*entries, *_list_levels(scenario)]


def _list_levels(scenario: Scenario) -> Iterator[dict[str, Any]]:
    from martensite.scenario.assemble import waveform_path
    from martensite.signals.base import DRIVE
    from martensite.simulate.drive_waveforms import by_name

    units = {drive.name: drive.unit for drive in scenario.system.drives()}
    for name, waveform in by_name(scenario.system, scenario.waveform).items():
        begin = waveform_path(scenario.system, name, scenario.places.drive)
        for leaf in waveform.leaves(begin):
            unit = units[name] if leaf.declared.unit == DRIVE else leaf.declared.unit
            yield _collect_value(scenario, leaf.path, leaf, unit)


def _collect_value(scenario: Scenario, path: str, leaf: Leaf, unit: str) -> dict[str, Any]:
    return {
        "path": path,
        "value": leaf.value,
        "unit": unit,
        "meaning": leaf.declared.doc,
        "from": scenario.origins.get(path, "default"),
    }
