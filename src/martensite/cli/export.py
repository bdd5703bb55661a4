"""`export`: a scenario in the form of another program, one subcommand per form."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, ScenarioFile, Settings, import_modules, quantity

if TYPE_CHECKING:
    from martensite.system import AbstractSystem

export = typer.Typer(help="Write a scenario for another program.", no_args_is_help=True)
app.add_typer(export, name="export")


@export.command("mujoco")
def mujoco(
    scenario: ScenarioFile,
    settings: Settings = None,
    out: Annotated[
        Path | None, typer.Option(help="MJCF file to write [default: ./SCENARIO.xml].")
    ] = None,
    timestep: Annotated[str, typer.Option(help="Time step of the model.")] = "2 ms",
    modules: Imports = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
    json: Json = False,
) -> None:
    """Write the mechanism of a scenario as an MJCF model.

    It has a tendon with an actuator at the place of every element. The elements themselves are
    put there by `martensite.bridge_of`, or by a `MujocoBridge` with the forces printed.
    """
    import_modules(modules)
    from martensite.cli.outputs import Outputs
    from martensite.export.mjcf import to_mjcf
    from martensite.files import replacing
    from martensite.io.overrides import read_settings
    from martensite.io.scenario import load

    loaded = load(scenario, read_settings(settings or []))
    out = out or Path(f"{scenario.stem}.xml")
    Outputs(out, None).check(force, data=(".xml",))
    text = to_mjcf(loaded.system, timestep=quantity("timestep", timestep, "s"))
    with replacing(out) as part:
        part.write_text(text, encoding="utf-8")
    _answer(_report(loaded.system, out), json)


def _report(system: AbstractSystem, out: Path) -> dict[str, Any]:
    from martensite.export.mjcf import start_forces

    return {
        "mechanism": system.mechanism.registered_name,
        "tendons": start_forces(system),
        "files": [str(out)],
    }


def _answer(report: dict[str, Any], json: bool) -> None:
    from martensite.cli import show

    if json:
        show.as_json(report)
        return
    for tendon, force in report["tendons"].items():
        show.text(f"tendon `{tendon}`: {show.quantity(force, 'N')} at assembly")
    show.text(f"wrote {report['files'][0]}")
