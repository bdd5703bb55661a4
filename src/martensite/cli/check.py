"""`check` and `params`: what a scenario holds, before anything is run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.errors import InputError
from martensite.cli.app import app
from martensite.cli.options import Imports, Json, ScenarioFile, Settings, import_modules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from martensite.base.parameters import Leaf
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.end_states import EndState
    from martensite.simulate.result import Result

LEVELS = ("lowest", "highest")
FEW = 2
"""Drives that are named one by one."""
HAIR = 1e-9
"""Part of a step that is rounding."""


@app.command()
def check(
    scenario: ScenarioFile, settings: Settings = None, json: Json = False, modules: Imports = None
) -> None:
    """Build a scenario, and say where its drives lead if held.

    One that leaves the envelope (melting, 3 GPa, a strain of 20 %, or a bound of your own) is
    refused.
    """
    import_modules(modules)
    from martensite.cli import show
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    loaded = load(scenario, read_settings(settings or []))
    report = _report(loaded) | _ends(loaded)
    if report["leaves"]:
        raise InputError(report["leaves"])
    if json:
        show.as_json(report)
        return
    show.text(report["title"], "bold")
    for caution in report["cautions"]:
        show.text(f"Caution: {caution}", "yellow")
    if report["doubtful"]:
        names = ", ".join(report["doubtful"])
        show.text(f"Assumed or recalled numbers of {report['material']}: {names}", "yellow")
    for end in report["end_states"]:
        show.text(f"Held at {end['words']}")
        for warning in end["warnings"]:
            show.text(f"  {warning}", "yellow")
    show.text(_sound(report))


def _ends(scenario: Scenario) -> dict[str, Any]:
    """Where drives that are held lead, and the sentence of a run that leaves the envelope."""
    from martensite.simulate.end_states import find_end_states, leaves_envelope

    if scenario.bench is not None:
        return {"end_states": [], "leaves": ""}
    case = scenario.system, scenario.waveform, scenario.duration
    found = find_end_states(*case)
    leaves = leaves_envelope(*case) if any(end.leaves for end in found) else ""
    rows = [
        _row(end, f"all drives at their {which}") for end, which in zip(found, LEVELS, strict=False)
    ]
    return {"end_states": rows, "leaves": leaves}


def _row(end: EndState, all_drives: str) -> dict[str, Any]:
    """An end state, ready for JSON; numbers in SI."""
    from martensite.cli import show

    result = end.result
    system = result.system
    units = {drive.name: drive.unit for drive in system.drives()}
    levels = [f"{name} {show.quantity(v, units[name])}" for name, v in end.levels.items()]
    held = levels[0].split(" ", 1)[1] if len(levels) == 1 else ", ".join(levels)
    words = [
        f"{result.outputs[name].long_name} "
        f"{show.quantity(result.columns[name][-1], result.unit(name))}"
        for name in system.judged()
    ]
    if len(levels) > FEW:
        held, words = all_drives, list(_highest(result))
    return {
        "levels": end.levels,
        "leaves": end.leaves,
        "values": {name: result.columns[name][-1] for name in system.judged()},
        "warnings": result.warnings,
        "words": f"{held}: leaves the envelope; the run does not stay there so long"
        if end.leaves else f"{held}: {', '.join(words)}",
    }  # fmt: skip


def _highest(result: Result) -> Iterator[str]:
    """The highest temperature and stress of many wires in the end."""
    from martensite.cli import show

    for name in ("hottest", "stress"):
        columns = [result.system.label(port, name) for port in result.system.actuators()]
        most = max(result.columns[column][-1] for column in columns)
        words = {"hottest": "highest temperature", "stress": "highest stress"}[name]
        yield f"{words} {show.quantity(most, result.unit(columns[0]))}"


def _sound(report: dict[str, Any]) -> str:
    begin = f"The scenario is sound: {report['duration']:.6g} s"
    if report["period"] is not None:
        return f"{begin} in {report['steps']} periods of {report['period']:.3g} s."
    return (
        f"{begin}, first step {report['first_step']:.3g} s (at least {report['steps']} steps), "
        f"tolerance {report['tolerance']:.3g}."
    )


def _report(scenario: Scenario) -> dict[str, Any]:
    import math

    from martensite.physics.materials.base import DOUBTFUL
    from martensite.simulate.api import first_step

    period = None if scenario.bench is None else scenario.bench.period
    step = (
        period or scenario.step or first_step(scenario.system, scenario.duration, scenario.samples)
    )
    samples = 1 if period else scenario.samples
    doubtful = [p for p, o in scenario.origins.items() if o.partition(",")[0] in DOUBTFUL]
    return {
        "title": scenario.title,
        "material": scenario.material.name if scenario.material else None,
        "cautions": scenario.cautions,
        "doubtful": doubtful,
        "duration": scenario.duration,
        "first_step": step,
        "steps": max(math.ceil(scenario.duration / step - HAIR), samples - 1),
        "period": period,
        "tolerance": scenario.tolerance,
    }


@app.command()
def params(
    name: Annotated[
        str, typer.Argument(metavar="NAME|SCENARIO", help="A part, or a scenario file.")
    ],
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """List the parameters of a part, or all values of a scenario."""
    import_modules(modules)
    from martensite.cli import describe, show

    if name.endswith(".toml"):
        _print_values(Path(name), settings, json)
    else:
        found = describe.anywhere(name)
        if json:
            show.as_json(found)
        else:
            for part in found:
                describe.print_part(part)


def _print_values(path: Path, settings: list[str] | None, json: bool) -> None:
    from martensite.cli import show
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    rows = _values(load(path, read_settings(settings or [])))
    if json:
        show.as_json(rows)
        return
    show.table(
        ("path", "value", "from", "meaning"),
        [(r["path"], show.quantity(r["value"], r["unit"]), r["from"], r["meaning"]) for r in rows],
    )


def _values(scenario: Scenario) -> list[dict[str, Any]]:
    """Every number of a scenario under the path by which `--set` reaches it."""
    places, known = scenario.places, scenario.origins
    found = [
        _value(scenario, path, leaf, places.unit(leaf))
        for leaf in scenario.leaves()
        if (path := places.path(leaf.path)) in known or not places.is_copy(leaf.path)
    ]
    return [*found, *_levels(scenario)]


def _levels(scenario: Scenario) -> Iterator[dict[str, Any]]:
    """The numbers of the waveforms; their levels are in the unit of what they drive."""
    from martensite.scenario.assemble import waveform_path
    from martensite.signals.base import DRIVE
    from martensite.simulate.driven import by_name

    units = {drive.name: drive.unit for drive in scenario.system.drives()}
    for name, waveform in by_name(scenario.system, scenario.waveform).items():
        begin = waveform_path(scenario.system, name, scenario.places.drive)
        for leaf in waveform.leaves(begin):
            unit = units[name] if leaf.declared.unit == DRIVE else leaf.declared.unit
            yield _value(scenario, leaf.path, leaf, unit)


def _value(scenario: Scenario, path: str, leaf: Leaf, unit: str) -> dict[str, Any]:
    return {
        "path": path,
        "value": leaf.value,
        "unit": unit,
        "meaning": leaf.declared.doc,
        "from": scenario.origins.get(path, "default"),
    }
