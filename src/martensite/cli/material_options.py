"""The element of a scenario, or its material, for `export c --part` and `export umat`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.cli.options import Text

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.export.c_core import CCore

Port = Annotated[Text, Option("--port", help="Place of the element in the scenario; needed if there are several.")]


def write_core_alone(system: AbstractSystem, part: str, port: str | None, name: str, precision: str) -> CCore:
    """Return the core of an element or its material."""
    from martensite.export.ports.element import build_element_port
    from martensite.export.ports.kernel import compile_port
    from martensite.export.ports.material import build_material_port

    build = build_element_port if part == "element" else build_material_port
    return compile_port(build(system, port=port)).write_core(name=name, precision=precision)
