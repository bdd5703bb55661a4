"""Options of exporters of an element or its material."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Sentence, Summary
from martensite.cli.options import Force, Json, ScenarioSource, Text, read_quantity
from martensite.cli.outputs import Outputs

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.export.c_core import CCore
    from martensite.export.ports.kernel import PortKernel

Port = Annotated[Text, Option("--port", help="Place of the element in the scenario; needed if there are several.")]


@dataclass(frozen=True)
class MaterialOptions:
    """Material and target files."""

    out: Annotated[Path, Option(metavar="FOLDER", help="Output folder.")] = Path()
    name: Annotated[Text, Option(help="Name of the material and prefix of file names [default: SCENARIO].")] = None
    port: Port = None
    preload: Annotated[Text, Option(help='Initial stress at zero strain, e.g. "50 MPa" [default: 0 MPa].')] = None
    slack: Annotated[
        bool, Option("--slack", help="Let the wire go slack under compression, instead of a bar that carries it.")
    ] = False
    force: Force = False
    json: Json = False

    def compile(self, source: ScenarioSource) -> tuple[PortKernel, str]:
        """Return the material of a scenario and its name."""
        from martensite.export.c_names import choose_identifier
        from martensite.export.ports.kernel import compile_port
        from martensite.export.ports.material import build_material_port

        called = choose_identifier(self.name, source.file.stem)
        stress = read_quantity("preload", self.preload, "Pa") or 0.0
        if self.slack and stress < 0.0:
            raise InputError("A slack wire cannot start under compression. Leave out `--slack`.")
        side = "slack" if self.slack else "carries"
        system = source.load().system
        return compile_port(build_material_port(system, port=self.port, preload=stress, compressed=side)), called

    def write(self, kernel: PortKernel, called: str, texts: Mapping[str, str], lines: list[str]) -> None:
        """Write the files of a material and print a summary."""
        files = write_texts(self.out, called, texts, self.force)
        report_written(kernel, called, lines, files, self.json)


def write_core_alone(system: AbstractSystem, part: str, port: str | None, name: str, precision: str) -> CCore:
    """Return the core of an element or its material."""
    from martensite.export.ports.element import build_element_port
    from martensite.export.ports.kernel import compile_port
    from martensite.export.ports.material import build_material_port

    build = build_element_port if part == "element" else build_material_port
    return compile_port(build(system, port=port)).write_core(name=name, precision=precision)


def write_texts(folder: Path, name: str, texts: Mapping[str, str], force: bool) -> list[Path]:
    """Write texts by file ending, all or none."""
    from martensite.base.files import make_folder, replace_together, write_file

    missing = not folder.exists()
    files = {folder / f"{name}{end}": text for end, text in texts.items()}
    for path in [folder.parent / next(iter(files)).name] if missing else files:
        Outputs(path, None).check(force or missing, data=(path.suffix,))
    make_folder(folder)
    with replace_together():
        for path, text in files.items():
            write_file(path, text)
    return list(files)


def report_written(kernel: PortKernel, name: str, lines: list[str], files: list[Path], json: bool) -> None:
    """Print element, remarks, cautions and files."""
    from martensite.show.terminal import print_summary

    port = kernel.system
    entries = [port.description(), *lines, *port.list_cautions()]
    data = {"name": name, "described": port.description(), "states": kernel.size}
    print_summary(Summary("", [Sentence(line) for line in entries], data), json, files)
