"""`export mujoco`: a mechanism as MJCF, or lines for a model of one's own, and a driver for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

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
    from martensite.scenario.scenario import Scenario

HERE = Path("SCENARIO_driver.py")
"""Stands for the file that is written where `--driver` names none."""


class Driving(TyperCommand):
    """The command, whose option `--driver` may stand without a file."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:
        """Name the file that was left out."""
        found: list[str] = []
        for given, after in zip(args, [*args[1:], "-"], strict=True):
            found.append(given)
            if given == "--driver" and (after.startswith("-") or after.endswith(".toml")):
                found.append(str(HERE))
        return super().parse_args(ctx, found)


@export.command("mujoco", cls=Driving)
def mujoco(
    scenario: ScenarioFile,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="MJCF file to write [default: ./SCENARIO.xml, or ./SCENARIO_snippet.xml]."
        ),
    ] = None,
    snippet: Annotated[
        bool,
        typer.Option(
            "--snippet", help="Write sites, tendons and motors alone, for a model of your own."
        ),
    ] = False,
    driver: Annotated[
        Path | None,
        typer.Option(
            metavar="[FILE.py]",
            help="Write a Python program too, which plays the drive of the scenario on the model "
            "[default: SCENARIO_driver.py beside it].",
        ),
    ] = None,
    timestep: Annotated[str, typer.Option(help="Time step of the model.")] = "2 ms",
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write the mechanism of a scenario as an MJCF model, or what another model needs.

    It has a tendon with an actuator at the place of every element. The elements themselves are
    put there by the driver, by `martensite.bridge_of`, or by a `MujocoBridge` with the forces
    printed.
    """
    import_modules(modules)
    from martensite.cli.outputs import Outputs
    from martensite.export.mjcf import to_mjcf
    from martensite.export.mjcf_snippet import to_mjcf_snippet
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    loaded = load(scenario, read_settings(settings or []))
    out = out or Path(f"{scenario.stem}{'_snippet' if snippet else ''}.xml")
    Outputs(out, None).check(force, data=(".xml",))
    dt = quantity("timestep", timestep, "s")
    texts = {
        out: to_mjcf_snippet(loaded.system) if snippet else to_mjcf(loaded.system, timestep=dt)
    }
    if driver:
        driver = out.with_name(f"{scenario.stem}_driver.py") if driver == HERE else driver
        Outputs(driver, None).check(force, data=(".py",))
        texts[driver] = _driver(loaded, driver, None if snippet else out, modules or [])
    _write(texts)
    _answer(_report(loaded, texts), json)


def _driver(loaded: Scenario, driver: Path, model: Path | None, modules: list[str]) -> str:
    """The text of the driver; `InputError` if the scenario has nothing to play."""
    from martensite.base.errors import InputError
    from martensite.export.mujoco_driver import driver_text

    if loaded.outside or (loaded.bench and loaded.bench.controllers.members()):
        raise InputError(
            "A driver plays waveforms, but this scenario has a controller; leave out `--driver`, "
            "and call your controller before every `step` of a `MujocoBridge`."
        )
    return driver_text(
        loaded.system, loaded.text, driver, source=loaded.path or Path(), model=model,
        modules=tuple(modules),
    )  # fmt: skip


def _write(texts: dict[Path, str]) -> None:
    from martensite.base.files import replace_file

    for path, text in texts.items():
        with replace_file(path) as part:
            part.write_text(text, encoding="utf-8")


def _report(loaded: Scenario, files: dict[Path, str]) -> dict[str, Any]:
    from martensite.export.mjcf import start_forces

    mechanism = loaded.system.mechanism
    return {
        "mechanism": mechanism.registered_name,
        "tendons": start_forces(loaded.system),
        "left_out": list(mechanism.signals()),
        "files": [str(path) for path in files],
    }


def _answer(report: dict[str, Any], json: bool) -> None:
    from martensite.cli import show

    if json:
        show.as_json(report)
        return
    for tendon, force in report["tendons"].items():
        show.text(f"tendon `{tendon}`: {show.quantity(force, 'N')} at assembly")
    for name in report["left_out"]:
        show.text(f"signal `{name}` of the mechanism is left out: it is for the model to say")
    show.text(f"wrote {', '.join(report['files'])}")
