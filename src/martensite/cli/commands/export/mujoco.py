"""`export mujoco`: the mechanism of a scenario as an MJCF model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.formats import write_quantity
from martensite.base.summary import Sentence, Summary
from martensite.cli.commands.export import export
from martensite.cli.options import Force, Json, ScenarioSource, read_positive, spread_options
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario


@export.command("mujoco")
@spread_options
def mujoco(
    source: ScenarioSource,
    out: Annotated[
        Path | None, Option(help="MJCF file to write [default: ./SCENARIO.xml, or ./SCENARIO_snippet.xml].")
    ] = None,
    snippet: Annotated[
        bool, Option("--snippet", help="Write sites and tendons alone, for a model of your own.")
    ] = False,
    timestep: Annotated[str, Option(help='Time step of the model, e.g. "1 ms".')] = "2 ms",
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a mechanism as an MJCF model for MuJoCo.

    The model has a tendon at the place of every element. In Python, `ms.export.to_mujoco` adds the elements
    themselves, and `ms.export.MujocoActuators` adds them to any model.
    """
    from martensite.base.files import write_file
    from martensite.export.mjcf import to_mjcf
    from martensite.export.mjcf_snippet import to_mjcf_snippet
    from martensite.show.terminal import print_summary

    loaded = source.load()
    out = out or Path(f"{source.file.stem}{'_snippet' if snippet else ''}.xml")
    Outputs(out, None).check(force, data=(".xml",))
    dt = read_positive("timestep", timestep, "s")
    write_file(out, to_mjcf_snippet(loaded.system) if snippet else to_mjcf(loaded.system, timestep=dt))
    print_summary(_summarise_model(loaded), json, [out])


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
