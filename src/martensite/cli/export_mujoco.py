"""`export mujoco`: a mechanism as MJCF, or lines for a model of one's own, and a driver for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option
from typer.core import TyperCommand

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.base.summary import Sentence, Summary
from martensite.cli.export import export
from martensite.cli.options import Force, Json, ScenarioSource, read_quantity, spread_options
from martensite.cli.outputs import Outputs

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
@spread_options
def mujoco(
    source: ScenarioSource,
    out: Annotated[
        Path | None, Option(help="MJCF file to write [default: ./SCENARIO.xml, or ./SCENARIO_snippet.xml].")
    ] = None,
    snippet: Annotated[
        bool, Option("--snippet", help="Write sites, tendons and motors alone, for a model of your own.")
    ] = False,
    driver: Annotated[
        Path | None,
        Option(
            metavar="[FILE.py]",
            help="Write a Python program too, which plays the drive of the scenario on the model "
            "[default: SCENARIO_driver.py beside it].",
        ),
    ] = None,
    timestep: Annotated[str, Option(help="Time step of the model.")] = "2 ms",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write the mechanism of a scenario as an MJCF model, or what another model needs.

    It has a tendon with an actuator at the place of every element. The elements themselves are
    put there by the driver, by `martensite.export.bridge_of`, or by a `MujocoBridge`
    with the forces printed.
    """
    from martensite.base.files import replace_together, write_file
    from martensite.export.mjcf import to_mjcf
    from martensite.export.mjcf_snippet import to_mjcf_snippet
    from martensite.show.terminal import print_summary

    loaded = source.load()
    out = out or Path(f"{source.file.stem}{'_snippet' if snippet else ''}.xml")
    Outputs(out, None).check(force, data=(".xml",))
    dt = read_quantity("timestep", timestep, "s")
    texts = {out: to_mjcf_snippet(loaded.system) if snippet else to_mjcf(loaded.system, timestep=dt)}
    if driver:
        driver = out.with_name(f"{source.file.stem}_driver.py") if driver == HERE else driver
        Outputs(driver, None).check(force, data=(".py",))
        texts[driver] = _write_driver(loaded, driver, None if snippet else out, source.modules or [])
    with replace_together():
        for path, text in texts.items():
            write_file(path, text)
    print_summary(_summarise_model(loaded), json, texts)


def _write_driver(loaded: Scenario, driver: Path, model: Path | None, modules: list[str]) -> str:
    """The text of the driver; `InputError` if the scenario has nothing to play."""
    from martensite.export.mujoco_driver import driver_text

    if loaded.outside or (loaded.bench and loaded.bench.controllers.members()):
        raise InputError(
            "A driver plays waveforms, but this scenario has a controller; leave out `--driver`, "
            "and call your controller before every `step` of a `MujocoBridge`."
        )
    return driver_text(
        loaded.system, loaded.text, driver, source=loaded.path or Path(), model=model, modules=tuple(modules)
    )


def _summarise_model(loaded: Scenario) -> Summary:
    from martensite.export.mjcf import start_forces

    mechanism, tendons = loaded.system.mechanism, start_forces(loaded.system)
    left_out = list(mechanism.signals())
    data = {"mechanism": mechanism.registered_name, "tendons": tendons, "left_out": left_out}
    lines = [
        *(f"tendon `{one}`: {write_quantity(f, 'N')} at assembly" for one, f in tendons.items()),
        *(f"signal `{one}` of the mechanism is left out: it is for the model to say" for one in left_out),
    ]
    return Summary("", [Sentence(line) for line in lines], data)
