"""`export fmu`: a scenario as a functional mock-up unit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from martensite.base.errors import InputError
from martensite.base.formats import write_quantity
from martensite.base.summary import Sentence, Summary
from martensite.cli.commands.export import export
from martensite.cli.material_options import Port
from martensite.cli.options import Force, Json, ScenarioSource, Text, Texts, read_quantity, spread_options
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.export.fmu import Fmu


@export.command("fmu")
@spread_options
def fmu(
    source: ScenarioSource,
    fmi: Annotated[str, Option(help="Version of FMI: 2.0 or 3.0.")] = "2.0",
    out: Annotated[Path | None, Option(help="FMU to write [default: ./SCENARIO.fmu].")] = None,
    step: Annotated[
        Text,
        Option(help=('Maximum internal step, e.g. "5 ms" [default: the step at which `run` reaches its tolerance].')),
    ] = None,
    name: Annotated[Text, Option(help="Model identifier [default: the name of the scenario file].")] = None,
    platforms: Annotated[
        Texts,
        Option(
            "--platform",
            help=("Target platform, e.g. x86_64-windows; repeatable [default: all platforms of the installed gcc]."),
        ),
    ] = None,
    ports: Annotated[
        bool,
        Option(
            "--ports",
            help=("Export the element alone: inputs elongation, drive and ambient; outputs force and temperature."),
        ),
    ] = False,
    port: Port = None,
    sources_only: Annotated[
        bool, Option("--sources-only", help="Write the sources without a compiled library.")
    ] = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a scenario as an FMU for co-simulation.

    Drives are inputs, observable quantities are outputs, and all values of the scenario are parameters. A closed
    loop has its reference as an input. With --ports the FMU contains the element alone, for a host that has the
    mechanism.
    """
    from martensite.export.fmu import to_fmu
    from martensite.show.terminal import print_summary

    if port is not None and not ports:
        raise InputError("Option `--port` chooses the element of an FMU with `--ports`.")
    if sources_only and platforms:
        raise InputError("Options `--sources-only` and `--platform` exclude each other.")
    loaded = source.load()
    out = out or Path(f"{source.file.stem}.fmu")
    Outputs(out, None).check(force, data=(".fmu",))
    chosen = read_quantity("step", step, "s")
    compiled = [] if sources_only else platforms or None
    archive = to_fmu(loaded, out, fmi=fmi, step=chosen, name=name, platforms=compiled, ports=ports, port=port)
    print_summary(_summarise_fmu(archive), json)


def _collect_signals(archive: Fmu) -> dict[str, Any]:
    report = {
        "file": str(archive.path),
        "fmi": archive.fmi,
        "identifier": archive.name,
        "token": archive.token,
        "period" if archive.discrete else "step": archive.step,
        "platforms": list(archive.platforms),
    }
    kinds = {"inputs": "input", "outputs": "output", "parameters": "parameter"}
    named = {key: archive.select_variables(causality) for key, causality in kinds.items()}
    named["fixed"] = [one for one in archive.select_variables("local") if one.variability == "constant"]
    return report | {key: {one.name: one.reference for one in signals} for key, signals in named.items()}


def _summarise_fmu(archive: Fmu) -> Summary:
    counts = {kind: len(archive.select_variables(kind)) for kind in ("input", "output", "parameter")}
    counted = [f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()]
    inputs = ", ".join(f"{one.name} [{one.unit or '-'}]" for one in archive.select_variables("input"))
    pace = "period" if archive.discrete else "inner step of at most"
    platforms = ", ".join(archive.platforms) or "no platform: compile its sources before use"
    lines = (
        f"{', '.join(counted)}; {pace} {write_quantity(archive.step, 's')}",
        f"inputs: {inputs}",
        f"wrote {archive.path} (FMI {archive.fmi}; {platforms})",
    )
    return Summary("", [Sentence(line) for line in lines], _collect_signals(archive))
