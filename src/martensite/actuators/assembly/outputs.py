"""Outputs of an element and its drive, each declared once.

A new entry of `OBSERVABLES` appears in runs, files, figures, exports and the bench.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from martensite.actuators.elements.base import Condition
from martensite.actuators.mechanisms.base import Output
from martensite.kernels.namespace import Scalar


class Observation(NamedTuple):
    """Values from which outputs are computed."""

    drive: Scalar
    """Signal of the source, in its unit."""
    force: Scalar
    """[N]"""
    current: Scalar
    """[A]"""
    condition: Condition


@dataclass(frozen=True)
class Observable:
    """One output and its kernel."""

    output: Output
    compute: Callable[[Observation], Scalar]
    after_mechanism: bool = False
    """True if it follows the outputs of the mechanism in a system of one element."""
    of_rphase: bool = False
    """True for laws with an R-phase only; `OUTPUTS` excludes it."""


OBSERVABLES: dict[str, Observable] = {
    "drive": Observable(Output("1", "drive signal", "u"), lambda of: of.drive),
    "temperature": Observable(Output("K", "wire temperature", "T"), lambda of: of.condition.temperature),
    "hottest": Observable(Output("K", "highest temperature in the element", "T_max"), lambda of: of.condition.hottest),
    "martensite_fraction": Observable(
        Output("1", "martensite fraction", "ξ"), lambda of: of.condition.martensite_fraction
    ),
    "oriented_fraction": Observable(
        Output("1", "net oriented martensite fraction", "ξ_S"), lambda of: of.condition.oriented_fraction
    ),
    "rphase_fraction": Observable(
        Output("1", "R-phase fraction", "ξ_R"), lambda of: of.condition.rphase_fraction, of_rphase=True
    ),
    "stress": Observable(Output("Pa", "axial stress", "σ"), lambda of: of.condition.stress),
    "strain": Observable(Output("1", "strain", "ε"), lambda of: of.condition.strain),
    "force": Observable(Output("N", "force", "F"), lambda of: of.force),
    "resistance": Observable(Output("ohm", "electrical resistance", "R"), lambda of: of.condition.resistance, True),
    "current": Observable(Output("A", "current", "I"), lambda of: of.current, True),
    "voltage": Observable(
        Output("V", "voltage across the element", "U"), lambda of: of.current * of.condition.resistance, True
    ),
    "power": Observable(
        Output("W", "electrical power in the element", "P"),
        lambda of: of.current * of.current * of.condition.resistance,
        True,
    ),
    "heat_loss": Observable(Output("W", "heat flow to the environment", "Q"), lambda of: of.condition.heat_loss, True),
}
"""The unit of the drive is the unit of its source."""

OUTPUTS: dict[str, Output] = {name: one.output for name, one in OBSERVABLES.items() if not one.of_rphase}

PROFILES: dict[str, Output] = {
    "cell_temperature": Output("K", "temperature of a cell", "T"),
    "cell_fraction": Output("1", "martensite fraction of a cell", "ξ"),
}
