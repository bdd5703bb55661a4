"""`export fmu`: a scenario as an FMU for Simulink, Modelica tools and other masters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.export import export
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
    from martensite.export.fmu import Fmu


@export.command("fmu")
def fmu(
    scenario: ScenarioFile,
    settings: Settings = None,
    fmi: Annotated[str, typer.Option(help="Version of FMI: 2.0 or 3.0.")] = "2.0",
    out: Annotated[
        Path | None, typer.Option(help="FMU to write [default: ./SCENARIO.fmu].")
    ] = None,
    step: Annotated[
        str | None,
        typer.Option(
            help="Longest step of the model within a step of the co-simulation "
            "[default: that with which `run` reaches its tolerance]."
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(help="Model identifier [default: made of the name of the file]."),
    ] = None,
    platforms: Annotated[
        list[str] | None,
        typer.Option(
            "--platform",
            help="For which to compile, e.g. x86_64-windows, with gcc or zig; repeatable "
            "[default: all that gcc is there for].",
        ),
    ] = None,
    sources_only: Annotated[bool, typer.Option("--sources-only", help="Compile nothing.")] = False,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as an FMU for co-simulation: the model in C, compiled and as sources.

    Drives are inputs, everything that can be observed is an output, all numbers of the scenario
    are parameters; a closed loop has its reference as an input.
    """
    import_modules(modules)
    from martensite.base.errors import InputError
    from martensite.cli.outputs import Outputs
    from martensite.export.fmu import to_fmu
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    if sources_only and platforms:
        raise InputError("Options `--sources-only` and `--platform` exclude each other.")
    loaded = load(scenario, read_settings(settings or []))
    out = out or Path(f"{scenario.stem}.fmu")
    Outputs(out, None).check(force, data=(".fmu",))
    chosen = None if step is None else quantity("step", step, "s")
    compiled = [] if sources_only else platforms or None
    _answer(to_fmu(loaded, out, fmi=fmi, step=chosen, name=name, platforms=compiled), json)


def _report(made: Fmu) -> dict[str, Any]:
    report = {
        "file": str(made.path),
        "fmi": made.fmi,
        "identifier": made.name,
        "token": made.token,
        "period" if made.discrete else "step": made.step,
        "platforms": list(made.platforms),
    }
    kinds = {"inputs": "input", "outputs": "output", "parameters": "parameter", "fixed": "local"}
    for key, causality in kinds.items():
        report[key] = {one.name: one.reference for one in made.named(causality)}
    return report


def _answer(made: Fmu, json: bool) -> None:
    from martensite.cli import show

    if json:
        show.as_json(_report(made))
        return
    counted = [_count(made, kind) for kind in ("input", "output", "parameter")]
    inputs = ", ".join(f"{one.name} [{one.unit or '-'}]" for one in made.named("input"))
    pace = "period" if made.discrete else "inner step of at most"
    show.text(f"{', '.join(counted)}; {pace} {show.quantity(made.step, 's')}")
    show.text(f"inputs: {inputs}")
    known = ", ".join(made.platforms) or "no platform: compile its sources before use"
    show.text(f"wrote {made.path} (FMI {made.fmi}; {known})")


def _count(made: Fmu, kind: str) -> str:
    count = len(made.named(kind))
    return f"{count} {kind}{'' if count == 1 else 's'}"
