"""The simulated wire: without any fit, with the material's resistivities, and calibrated.

Three parameters are calibrated to the same record: ρ_M and ρ_A from the mean resistance on either side of the drop, and
one h from the current I at half of the drop,

    h = I² (R_M + R_A)/2/[π d l (T_½ - T_a)],    T_½ = (A_s + A_f)/2

so only the shape of R(I) can be compared. This h is apparent: three to four times free convection, and not a property
of the wire.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import cast

from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.characterise.regression import root_mean_square
from martensite.kernels import floats
from martensite.physics.thermal.base import AbstractCooling, Cylinder
from martensite.physics.thermal.convection import LeFevreEde
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.records import Record
from martensite.simulate.api import simulate
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.electrothermal.staircase import reduce_to_plateaus
from martensite.studies.readings import load_once
from martensite.studies.tables import Printed

SCENARIO = Path(__file__).with_name("scenario.toml")
load_scenario = partial(load_once, SCENARIO)
VARIANTS = {
    "maker": "resistivities of sheet F1140, free convection, without a fit",
    "material": "resistivities of material `flexinol-90` from this record, free convection",
    "calibrated": "two resistivities and an apparent h from this record",
}
_TOLERANCE = 1e-3


@dataclass(frozen=True)
class RecordCalibration:
    """Three parameters calibrated to the record."""

    rho_A: float
    """[ohm m]"""
    rho_M: float
    """[ohm m]"""
    h: float
    """Apparent film coefficient [W/(m² K)]."""


def get_wire() -> Wire:
    """Return the wire of the scenario."""
    return cast("Wire", load_scenario().single_system.element)


def read_number(path: str) -> float:
    """Return a parameter of the scenario's system by its dotted path [SI]."""
    return load_scenario().system.value_of(path)


def half_way_temperature() -> float:
    """Return the temperature of half transformation on heating, unloaded [K]."""
    return 0.5 * (read_number("A_s") + read_number("A_f"))


def film_coefficient(cooling: AbstractCooling, temperature: float) -> float:
    """Return the film coefficient of a heat-loss model on this wire [W/(m² K)]."""
    shape = Cylinder(get_wire().diameter, get_wire().length)
    return float(cooling.film(floats, temperature, read_number("environment.temperature"), shape))


def free_films() -> tuple[float, float]:
    """Return h of free convection of a horizontal and a vertical wire at half transformation [W/(m² K)]."""
    at = half_way_temperature()
    return film_coefficient(load_scenario().single_system.environment.cooling, at), film_coefficient(LeFevreEde(), at)


def calibrate_model(staircase: RecordStaircase) -> RecordCalibration:
    """Return the three parameters of the record."""
    element, stated = get_wire(), staircase.stated
    cold, hot = staircase.mean(*stated.cold), staircase.mean(*stated.hot)
    per_ohm = float(element.section()) / float(element.length)
    warmer = half_way_temperature() - read_number("environment.temperature")
    power = staircase.half_way() ** 2 * 0.5 * (cold + hot)
    surface = math.pi * float(element.diameter) * float(element.length)
    return RecordCalibration(hot * per_ohm, cold * per_ohm, power / (surface * warmer))


def build_system(key: str, stated: Printed, calibration: RecordCalibration | None = None) -> System:
    """Return the system of one of `VARIANTS`; only `calibrated` needs a calibration."""
    base = load_scenario().single_system
    if key == "maker":
        return base
    if key == "material" or calibration is None:
        return base.with_values({"rho_A": stated.rho_A, "rho_M": stated.rho_M})
    environment = base.environment.with_parts(cooling=ConstantCooling(h=calibration.h))
    system = base.with_parts(environment=environment)
    return system.with_values({"rho_A": calibration.rho_A, "rho_M": calibration.rho_M})


@cache
def predict_plateaus(key: str, stated: Printed, calibration: RecordCalibration | None = None) -> Record:
    """Return the plateaus of a simulated staircase."""
    run = simulate(
        build_system(key, stated, calibration),
        load_scenario().waveform,
        load_scenario().duration,
        tolerance=_TOLERANCE,
        samples=load_scenario().samples,
    )
    names = ("time", "drive", "current", "resistance", "temperature", "martensite_fraction")
    columns = {name: run[name] for name in names}
    units = {name: run.unit(name) for name in names}
    return reduce_to_plateaus(Record(f"simulated, {key}", columns, units), "drive")


def find_span(table: Record) -> tuple[float, float]:
    """Return the currents of the last plateau with all martensite, and the first without [A]."""
    fractions, current = table["martensite_fraction"].tolist(), table["current"].tolist()
    first = next(i for i, xi in enumerate(fractions) if xi < 0.99)
    end = next(i for i, xi in enumerate(fractions) if xi < 0.01)
    return current[max(first - 1, 0)], current[end]


def resistance_rms(table: Record, staircase: RecordStaircase, low: float, high: float) -> float:
    """Return the RMS difference of the resistance on the plateaus between two set-points [ohm]."""
    places = staircase.within(low, high)
    resistance = table["resistance"].tolist()
    errors = [resistance[i] - staircase.resistance[i] for i in places]
    return root_mean_square(errors)
