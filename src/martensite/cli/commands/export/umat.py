"""`export umat`: the material of a scenario as a user material of Abaqus and CalculiX."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.cli.commands.export import export
from martensite.cli.material_options import MaterialOptions
from martensite.cli.options import ScenarioSource, spread_options

if TYPE_CHECKING:
    pass


@export.command("umat")
@spread_options
def umat(source: ScenarioSource, options: MaterialOptions) -> None:
    """Write a material as a UMAT for Abaqus and CalculiX, in C.

    Inputs are strain and temperature; outputs are stress, latent heat and the consistent tangent. The material is
    for trusses; in a solid it acts as a fibre along the first material axis.
    """
    from martensite.export.ports.umat import count_state_variables, write_umat

    kernel, called = options.compile(source)
    states = count_state_variables(kernel)
    lines = [f"{states} state variables; constants: unit of stress, zero of temperature, lateral modulus, start"]
    options.write(kernel, called, write_umat(kernel, called), lines)
