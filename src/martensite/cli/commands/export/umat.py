"""`export umat`: the material of a scenario as a user material of Abaqus and CalculiX."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Sentence, Summary
from martensite.cli.commands.export import export
from martensite.cli.material_options import Port
from martensite.cli.options import Force, Json, ScenarioSource, Text, read_quantity, spread_options
from martensite.cli.outputs import check_folder_files


@export.command("umat")
@spread_options
def umat(
    source: ScenarioSource,
    out: Annotated[Path, Option(metavar="FOLDER", help="Output folder.")] = Path(),
    name: Annotated[Text, Option(help="Name of the material and prefix of file names [default: SCENARIO].")] = None,
    port: Port = None,
    preload: Annotated[Text, Option(help='Initial stress at zero strain, e.g. "50 MPa" [default: 0 MPa].')] = None,
    slack: Annotated[
        bool, Option("--slack", help="Let the wire go slack under compression, instead of a bar that carries it.")
    ] = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a material as a UMAT for Abaqus and CalculiX, in C.

    Inputs are strain and temperature; outputs are stress, latent heat and the consistent tangent. The material is
    for trusses; in a solid it acts as a fibre along the first material axis.
    """
    from martensite.base.files import make_folder, replace_together, write_file
    from martensite.export.c_names import choose_identifier
    from martensite.export.ports.kernel import compile_port
    from martensite.export.ports.material import build_material_port
    from martensite.export.ports.umat import count_state_variables, write_umat
    from martensite.show.terminal import print_summary

    called = choose_identifier(name, source.file.stem)
    stress = read_quantity("preload", preload, "Pa") or 0.0
    if slack and stress < 0.0:
        raise InputError("A slack wire cannot start under compression. Leave out `--slack`.")
    side = "slack" if slack else "carries"
    material = build_material_port(source.load().system, port=port, preload=stress, compressed=side)
    kernel = compile_port(material)
    texts = {f"{called}{end}": text for end, text in write_umat(kernel, called).items()}
    files = check_folder_files(out, tuple(texts), force)
    make_folder(out)
    with replace_together():
        for path in files:
            write_file(path, texts[path.name])
    states = count_state_variables(kernel)
    constants = f"{states} state variables; constants: unit of stress, zero of temperature, lateral modulus, start"
    lines = [material.description(), constants, *material.list_cautions()]
    data = {"name": called, "described": material.description(), "states": kernel.size}
    print_summary(Summary("", [Sentence(line) for line in lines], data), json, files)
