"""The heated wire: film coefficient, steady temperatures, and the two closures simulated.

Film coefficient and steady balance (thesis, equations 3.1 to 3.4):

    h = Nu k/l,    Nu after LeFevre and Ede,    Ra = g β (T - T_a) l³/(α ν)
    V²/R = h(T) π d l (T - T_a)
"""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from pathlib import Path

from martensite import simulate as simulation
from martensite.kernels import floats
from martensite.physics.fluids.air import ROWS, AirTable
from martensite.physics.thermal.base import Cylinder, Environment
from martensite.physics.thermal.convection import LeFevreEde
from martensite.scenario.scenario import Scenario, load
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import ZERO
from martensite.studies.tables import Printed

FOLDER = Path(__file__).parent
CLOSURES = {"a": FOLDER / "closure-a.toml", "b": FOLDER / "closure-b.toml"}
AMBIENT = 22.0
"""Assumed ambient temperature [°C]: the thesis states none."""
COOLING = LeFevreEde(fluid=AirTable(), gravity=9.81)
"""The correlation with textbook air between 20 °C and 100 °C."""
_SETTLING = 300.0
"""More than twenty time constants [s]."""


def lateral_surface(printed: Printed) -> float:
    """Return the lateral surface of the wire [m²]."""
    return math.pi * printed.diameter * printed.length


def _wire_shape(printed: Printed) -> Cylinder:
    return Cylinder(printed.diameter, printed.length)


def printed_film(row: Printed, printed: Printed, ambient: float = AMBIENT) -> float:
    """Return h of equations (3.2) to (3.4) with the printed properties of a row [W/(m² K)]."""
    film_temperature = 0.5 * (row.temperature + ambient) + ZERO
    difference = row.temperature - ambient
    size = printed.length
    rayleigh = COOLING.gravity * difference * size**3 / (film_temperature * row.diffusivity * row.viscosity)
    nusselt = COOLING.nusselt(floats, rayleigh, row.prandtl, _wire_shape(printed))
    return nusselt * row.conductivity / size


def _surroundings(ambient: float) -> Environment:
    """Return air at an ambient temperature [°C], with the correlation."""
    return Environment(temperature=ambient + ZERO, cooling=COOLING)


def film_coefficient(temperature: float, ambient: float, printed: Printed) -> float:
    """Return h of the correlation with textbook air [W/(m² K)]; temperatures in °C."""
    shape, around = _wire_shape(printed), _surroundings(ambient)
    return simulation.find_film_coefficient(shape, temperature=temperature + ZERO, environment=around)


def steady_temperature(power: float, ambient: float, printed: Printed) -> float:
    """Return the root of power = h(T) S (T - T_a) [°C], with h of the correlation."""
    return simulation.find_steady_temperature(_wire_shape(printed), power, environment=_surroundings(ambient)) - ZERO


def implied_ambient(row: Printed) -> float:
    """Return the ambient temperature [°C] whose film temperature has a row's conductivity."""
    table = [(entry[0], entry[1]) for entry in ROWS["textbook"]]
    for (low, first), (high, last) in pairwise(table):
        if row.conductivity <= last:
            at = low + (high - low) * (row.conductivity - first) / (last - first)
            return 2.0 * at - row.temperature
    return math.nan


def textbook_prandtl(row: Printed) -> float:
    """Return the Prandtl number of textbook air with the conductivity of a row."""
    table = [(entry[1], entry[3]) for entry in ROWS["textbook"]]
    for (low, first), (high, last) in pairwise(table):
        if row.conductivity <= high:
            return first + (last - first) * (row.conductivity - low) / (high - low)
    return math.nan


@cache
def load_scenario(closure: str) -> Scenario:
    """Return the scenario of closure `a` or `b`."""
    return load(CLOSURES[closure])


@cache
def simulated_temperature(closure: str, voltage: float) -> float:
    """Return the simulated steady temperature under a voltage [V], in °C."""
    system = load_scenario(closure).system
    run = simulate(system, Constant(level=voltage), _SETTLING, tolerance=1e-4, samples=101)
    return run["temperature"][-1] - ZERO


@cache
def heating_run(closure: str) -> Result:
    """Return the run of a closure's scenario: the voltage on, then off."""
    return load_scenario(closure).run()
