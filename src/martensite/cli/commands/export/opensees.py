"""`export opensees`: the material of a scenario as a uniaxialMaterial of OpenSees."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.cli.commands.export import export
from martensite.cli.material_options import MaterialOptions
from martensite.cli.options import ScenarioSource, spread_options

if TYPE_CHECKING:
    pass


@export.command("opensees")
@spread_options
def opensees(source: ScenarioSource, options: MaterialOptions) -> None:
    """Write a material as a uniaxialMaterial of OpenSees, in C.

    The folder also contains a script that uses the material. Its temperature is a table over the time of the model.
    """
    from martensite.export.ports.opensees import write_opensees

    kernel, called = options.compile(source)
    lines = [f"uniaxialMaterial {called} tag 1 0.0 TEMPERATURE"]
    options.write(kernel, called, write_opensees(kernel, called), lines)
