"""`check` and `params`: what a scenario holds, before anything is run; `conform`: what a part keeps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.base.lazy import import_extra
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.cli.app import app
from martensite.cli.options import (
    Imports,
    Json,
    ScenarioSource,
    Settings,
    import_modules,
    load_without_log,
    spread_options,
)

if TYPE_CHECKING:
    from martensite.base.parameters import Leaf
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.result import Result
    from martensite.simulate.trial_runs import EndState
    from martensite_testing.conformance import Conformance

LEVELS = ("lowest", "highest")
FEW = 2
"""Drives that are named one by one."""
ROUNDING = 1e-9
"""Part of a step."""


@app.command()
@spread_options
def check(source: ScenarioSource, json: Json = False) -> None:
    """Build a scenario, and say where its drives lead if held.

    One that follows a log needs none for it.

    One that leaves the envelope (melting, 3 GPa, a strain of 20 %, or a bound of your own) is
    refused.
    """
    from martensite.show.terminal import print_summary

    loaded = load_without_log(source.file, source.settings, source.modules)
    if "at" not in loaded.initial:  # to find what is to be found takes a run
        loaded.find_start(loaded.tolerance)
    report = _collect_report(loaded) | _find_ends(loaded)
    if loaded.bench is not None:
        from martensite.scenario.guard_report import collect_guard

        report["guard"] = collect_guard(loaded)
    if report["leaves"]:
        raise InputError(report["leaves"])
    print_summary(Summary(loaded.title, list(_describe_report(report)), report), json)


def _describe_report(report: dict[str, Any]) -> Iterator[Block]:
    yield from (Sentence(f"Caution: {caution}", "caution") for caution in report["cautions"])
    if report["doubtful"]:
        names = ", ".join(report["doubtful"])
        told = f"Assumed or recalled numbers of {report['material']}: {names}"
        yield Sentence(told, "caution")
    for end in report["end_states"]:
        yield Sentence(f"Held at {end['words']}")
        yield from (Sentence(f"  {warning}", "caution") for warning in end["warnings"])
    if report["follows"]:
        followed = ", ".join(f"`{drive}` column `{column}`" for drive, column in report["follows"].items())
        yield Sentence(f"Follows a log: {followed}. Where its drives lead is seen with it: `run --log`, or `fit`.")
        yield Sentence("The scenario is sound; it lasts as long as its log.")
        return
    if report.get("guard") is not None:
        from martensite.scenario.guard_report import describe_guard

        yield from describe_guard(report["guard"])
    yield Sentence(_tell_steps(report))


def _find_ends(scenario: Scenario) -> dict[str, Any]:
    """Where drives that are held lead, and the sentence of a run that leaves the envelope."""
    from martensite.simulate.trial_runs import find_end_states, leaves_envelope

    if scenario.bench is not None or scenario.follows:
        return {"end_states": [], "leaves": ""}
    case = scenario.system, scenario.waveform, scenario.duration
    found = find_end_states(*case)
    leaves = leaves_envelope(*case) if any(end.leaves for end in found) else ""
    rows = [_collect_end(end, f"all drives at their {which}") for end, which in zip(found, LEVELS, strict=False)]
    return {"end_states": rows, "leaves": leaves}


def _collect_end(end: EndState, all_drives: str) -> dict[str, Any]:
    result = end.result
    system = result.system
    units = {drive.name: drive.unit for drive in system.drives()}
    levels = [f"{name} {write_quantity(v, units[name])}" for name, v in end.levels.items()]
    held = levels[0].split(" ", 1)[1] if len(levels) == 1 else ", ".join(levels)
    words = [
        f"{result.outputs[name].long_name} {write_quantity(result.columns[name][-1], result.unit(name))}"
        for name in system.convergence_scales()
    ]
    if len(levels) > FEW:
        held, words = all_drives, list(_find_highest(result))
    return {
        "levels": end.levels,
        "leaves": end.leaves,
        "values": {name: result.columns[name][-1] for name in system.convergence_scales()},
        "warnings": result.warnings,
        "words": f"{held}: leaves the envelope; the run does not stay there so long"
        if end.leaves
        else f"{held}: {', '.join(words)}",
    }


def _find_highest(result: Result) -> Iterator[str]:
    for name in ("hottest", "stress"):
        columns = [result.system.label(port, name) for port in result.system.actuators()]
        most = max(result.columns[column][-1] for column in columns)
        words = {"hottest": "highest temperature", "stress": "highest stress"}[name]
        yield f"{words} {write_quantity(most, result.unit(columns[0]))}"


def _tell_steps(report: dict[str, Any]) -> str:
    begin = f"The scenario is sound: {report['duration']:.6g} s"
    if report["period"] is not None:
        return f"{begin} in {report['steps']} periods of {report['period']:.3g} s."
    return (
        f"{begin}, first step {report['first_step']:.3g} s (at least {report['steps']} steps), "
        f"tolerance {report['tolerance']:.3g}."
    )


def _collect_report(scenario: Scenario) -> dict[str, Any]:
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
    }


@app.command()
def params(
    name: Annotated[str, typer.Argument(metavar="NAME|SCENARIO", help="A part, or a scenario file.")],
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """List the parameters of a part, or all values of a scenario."""
    from martensite.scenario.catalogue import describe_named
    from martensite.show.summaries.parts import describe_part
    from martensite.show.terminal import print_summary

    if name.endswith(".toml"):
        rows = _list_values(load_without_log(name, settings, modules))
        cells = [(r["path"], write_quantity(r["value"], r["unit"]), r["from"], r["meaning"]) for r in rows]
        table = DataTable(("path", "value", "from", "meaning"), cells)
        print_summary(Summary("", [table], rows), json)
        return
    import_modules(modules)
    found = describe_named(name)
    blocks = [block for part in found for block in describe_part(part)]
    print_summary(Summary("", blocks, found), json)


def _list_values(scenario: Scenario) -> list[dict[str, Any]]:
    places, known = scenario.places, scenario.origins
    found = [
        _collect_value(scenario, path, leaf, places.unit(leaf))
        for leaf in scenario.leaves()
        if (path := places.path(leaf.path)) in known or not places.is_copy(leaf.path)
    ]
    return [*found, *_list_levels(scenario)]


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


@app.command()
def conform(
    target: Annotated[str, typer.Argument(metavar="FILE|NAME", help="A .py or .toml file, or a name.")],
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Try whether parts of your own keep what they promise.

    A law, for example, must not depend on how a path is cut into steps. Parts of this package can
    be tried as well. They are made of the typical values of their declarations, once for every
    choice of an option. Ends with 1 if a check fails.
    """
    import_modules(modules)
    from martensite.show.terminal import print_summary

    found = import_extra("martensite_testing", "testing", "`martensite-testing`").check_target(target)
    blocks = [block for one in found for block in _describe_findings(one)]
    print_summary(Summary("", blocks, [_collect_findings(one) for one in found]), json)
    if not all(one.holds for one in found):
        raise typer.Exit(1)


def _collect_findings(found: Conformance) -> dict[str, Any]:
    return {
        "name": found.name,
        "kind": found.kind,
        "holds": found.holds,
        "findings": [vars(one) for one in found.findings],
    }


def _describe_findings(found: Conformance) -> Iterator[Block]:
    yield Heading(str(found))
    faults = {one.check: one for one in found.faults}
    for check, promise in {one.check: one.promise for one in found.findings}.items():
        fault = faults.get(check)
        yield Sentence(f"  {'kept  ' if fault is None else 'broken'}  {promise}")
        if fault is not None:
            yield Sentence(f"          {fault.part}: {fault.fault}", "bad")
