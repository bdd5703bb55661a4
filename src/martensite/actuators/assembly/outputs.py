"""What can be observed on an element and what drives it."""

from __future__ import annotations

from typing import NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.kernels.namespace import Scalar


class Outputs(NamedTuple):
    """What can be observed on an actuator, in SI units; described in `OUTPUTS`."""

    drive: Scalar
    temperature: Scalar
    hottest: Scalar
    martensite_fraction: Scalar
    oriented_fraction: Scalar
    stress: Scalar
    strain: Scalar
    force: Scalar
    resistance: Scalar
    current: Scalar
    voltage: Scalar
    power: Scalar
    heat_loss: Scalar


OUTPUTS: dict[str, Output] = {
    "drive": Output("1", "drive signal", "u"),
    "temperature": Output("K", "wire temperature", "T"),
    "hottest": Output("K", "highest temperature in the element", "T_max"),
    "martensite_fraction": Output("1", "martensite fraction", "ξ"),
    "oriented_fraction": Output("1", "net oriented martensite fraction", "ξ_S"),
    "stress": Output("Pa", "axial stress", "σ"),
    "strain": Output("1", "strain", "ε"),
    "force": Output("N", "force", "F"),
    "resistance": Output("ohm", "electrical resistance", "R"),
    "current": Output("A", "current", "I"),
    "voltage": Output("V", "voltage across the element", "U"),
    "power": Output("W", "electrical power in the element", "P"),
    "heat_loss": Output("W", "heat flow to the environment", "Q"),
}
"""The unit of the drive is that of its source."""

PROFILES: dict[str, Output] = {
    "cell_temperature": Output("K", "temperature of a cell", "T"),
    "cell_fraction": Output("1", "martensite fraction of a cell", "ξ"),
}
