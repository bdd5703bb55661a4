"""The simulated platform: parameter sets, its springs, and runs of one hot spring.

Values missing in the paper are chosen here or in `scenario.toml`: the springs have no force as assembled, are closed (N
d long) when hot and unloaded, and have the printed mass and resistance for any coil diameter. Heat capacity and latent
heat are those of the material.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import cast

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.elements.coil_spring import CoilSpring
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.physics.electrical.resistances import MixtureResistance
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import ZERO, choose_runtime, load_once, passing_time
from martensite.studies.tables import Printed, printed_numbers

SCENARIO = Path(__file__).with_name("scenario.toml")
load_scenario = partial(load_once, SCENARIO)
STEEP = 1e9
"""Slope with negligible effect of stress [Pa/K]; the printed 6 and 12 GPa/K exceed the range of a law."""
UNLIMITED = 1e6
"""Current limit without effect [A]."""
PORTS = ("first", "second", "third")
RISE, LATE, COOLING = 32.0, 50.0, 40.0
"""Durations [s]: calibrated sets at the high and at the low voltage, and cooling."""
FINE, COARSE = 0.01, 0.02
"""Steps [s]: springs that heat within seconds, and slower ones."""
HOT = PORTS[0]
"""The heated spring, on +Y, so that the platform turns about X."""


@dataclass(frozen=True)
class Case:
    """A choice of the values missing in the paper."""

    title: str
    film: float
    """[W/(m² K)]"""
    series: float = 0.0
    """Resistance in series [ohm]."""
    limits: tuple[float, float] = (UNLIMITED, UNLIMITED)
    """Largest current at the high and at the low voltage [A]."""
    damping: float = 0.0
    """Damping of the joint [N m s/rad]."""
    capacity: float | None = None
    """Heat capacity [J/(kg K)]; by default of the material."""
    latent: float | None = None
    """Latent heat [J/kg]; by default of the material."""
    coil: float | None = None
    """Mean coil diameter [m]; by default the printed one is the outer diameter."""
    slope: float | None = None
    """C_A and C_M [Pa/K]; by default the printed ones in MPa/K."""


AS_PRINTED = Case("as printed: V²/R, 150 W/(m² K)", 150.0)
LIMITED = replace(AS_PRINTED, title="as printed, but 2.5 A at most", limits=(2.5, 2.5))
CASES = {
    "as-printed": AS_PRINTED,
    "A": Case("A: 68.6 W/(m² K), 0.594 Ω in series, 2.5 A at most", 68.6, 0.594, limits=(2.5, 2.5)),
    "A'": Case("A': 37.5 W/(m² K), 2.283 A at 5 V, 1.904 A at 3 V", 37.5, limits=(2.2834, 1.9038)),
    "C": replace(AS_PRINTED, title="C: as printed, joint with 16.48 N m s/rad", damping=16.48),
}
"""The paper's equations, and sets calibrated to its two response times."""
VARIANTS = {
    "base": AS_PRINTED,
    "no latent heat": replace(AS_PRINTED, latent=0.0),
    "320 J/(kg K), no latent heat": replace(AS_PRINTED, capacity=320.0, latent=0.0),
    "466 J/(kg K), 12.2 kJ/kg": replace(AS_PRINTED, capacity=466.0, latent=12.2e3),
    "6 mm mean coil diameter": replace(AS_PRINTED, coil=6e-3),
    "C of 1 GPa/K": replace(AS_PRINTED, slope=STEEP),
    "C of 1 GPa/K, 320 J/(kg K), no latent heat": replace(AS_PRINTED, slope=STEEP, capacity=320.0, latent=0.0),
}
"""Interpretations of the paper's equations and missing values."""
IN_SERIES = {
    "no heat loss": replace(AS_PRINTED, film=0.0),
    "35 W/(m² K), 0.6 Ω in series": replace(AS_PRINTED, film=35.0, series=0.6),
    "35 W/(m² K), 1.2 Ω in series": replace(AS_PRINTED, film=35.0, series=1.2),
}
"""Other heating by voltage without a current limit."""


def build_spring(case: Case, printed: Printed) -> CoilSpring:
    """Return a spring of printed mass and resistances, without force as assembled."""
    base = cast("CoilSpring", load_scenario().system.actuators()[HOT].element)
    outer = printed.coil_diameter if case.coil is None else case.coil + printed.diameter
    shape = base.with_values(
        {
            "diameter": printed.diameter,
            "coil_diameter": outer,
            "turns": printed.turns,
            "free_length": printed.turns * printed.diameter,
        }
    )
    length, section = shape.wire_length(), shape.section()
    resistance = MixtureResistance(rho_A=printed.R_A * section / length, rho_M=printed.R_M * section / length)
    heat = {"heat_capacity": case.capacity, "latent_heat": case.latent}
    numbers = (
        {name: value for name, value in heat.items() if value is not None}
        | {
            "density": printed.spring_mass / (section * length),
            "eps_L": (printed.height - shape.free_length) / shape.reach(),
            "E_A": 3.0 * printed.G_A,
            "E_M": 3.0 * printed.G_M,
            "C_A": case.slope or 1e6 * printed.C_A,
            "C_M": case.slope or 1e6 * printed.C_M,
        }
        | {name: getattr(printed, name) + ZERO for name in ("A_s", "A_f", "M_s", "M_f")}
    )
    return shape.with_parts(resistance=resistance).with_values(numbers)


def build_machine(case: Case, printed: Printed, voltage: float = 5.0, **mechanism: str) -> Machine:
    """Return the platform of a case; keyword arguments are options of the mechanism."""
    base = load_scenario().system
    limit = case.limits[0 if voltage >= printed.high else 1]
    one = base.actuators()[HOT].with_parts(element=build_spring(case, printed))
    one = one.with_values(
        {
            "environment.temperature": printed.ambient + ZERO,
            "cooling.h": case.film,
            "series_resistance": case.series,
            "current_limit": limit,
        }
    )
    plates = {"side": printed.side, "height": printed.height, "mass": printed.plate_mass}
    moved = base.mechanism.with_values(plates | {"damping": case.damping}).with_parts(**mechanism)
    members: dict[str, Actuator] = dict.fromkeys(PORTS, one)
    return Machine(mechanism=moved, group=Group(**members))


def build_platform(printed: Printed) -> ParallelPlatform:
    """Return the mechanism alone."""
    return cast("ParallelPlatform", build_machine(AS_PRINTED, printed).mechanism)


def run_heated(
    case: Case, printed: Printed, voltage: float, duration: float, step: float = FINE, until: float = math.inf
) -> Result:
    """Return a run under a voltage on the hot spring until a time [s], with a sample per step."""
    return _run_heated(case, without_results(printed), voltage, duration, step, until)


@cache
def _run_heated(case: Case, printed: Printed, voltage: float, duration: float, step: float, until: float) -> Result:
    drive = {HOT: Step(high=voltage, until=until)}
    samples = round(duration / step) + 1
    return simulate(
        build_machine(case, printed, voltage), drive, duration, step=step, samples=samples, runtime=choose_runtime()
    )


RESULTS = ("centroid", "current", "contraction", "fast", "slow")
"""Printed numbers without effect on runs."""


def without_results(printed: Printed) -> Printed:
    """Return the numbers with an effect on runs; the others as in the paper."""
    plain = vars(printed_numbers("platform"))
    return printed.with_numbers(**{name: plain[name] for name in RESULTS})


def step_of(case: Case) -> float:
    """Return a step [s] for a calibrated set, shorter for a stiff joint."""
    return FINE if case.damping > 0.0 else COARSE


def angle_degrees(result: Result, name: str = "alpha") -> list[float]:
    """Return an angle at all samples [°]."""
    return [math.degrees(angle) for angle in result[name]]


def arrival_time(
    case: Case, printed: Printed, voltage: float, angle: float, duration: float, step: float = FINE
) -> float:
    """Return the time to an angle about X [s]; NaN if it is not reached within the duration."""
    result = run_heated(case, printed, voltage, duration, step)
    return passing_time(result.times, angle_degrees(result), angle)


def at_angle(result: Result, angle: float, name: str) -> float:
    """Return an output of the hot spring [SI] where the platform first passes an angle [°]."""
    return passing_time(result.columns[f"{HOT}.{name}"], angle_degrees(result), angle)


def run_cooling(printed: Printed, case: Case) -> dict[str, float]:
    """Return times of cooling after heating to the angle of the response times [s].

    Returns:
        Times from switching off until the plate moves, and until it has turned back by 10° and 20°.
    """
    begin = arrival_time(case, printed, printed.high, printed.angle, RISE, COARSE)
    result = run_heated(case, printed, printed.high, begin + COOLING, COARSE, until=begin)
    turned = [-angle for angle in angle_degrees(result)]
    start = max(range(len(turned)), key=lambda k: -turned[k])
    times, falling = result.times[start:], turned[start:]
    levels = {"hold": 0.01, "10": 10.0, "20": 20.0}
    return {name: passing_time(times, falling, less - printed.angle) - begin for name, less in levels.items()}
