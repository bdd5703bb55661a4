"""The simulated test bench: heating, compared variants, and their runs.

Table 2 gives for each voltage the heating power P = h S (T_ss - T_a), with S the lateral surface of the wire. To match
both voltage and power of the paper for any leads, the sine heats with

    P(t) = V²/R_eq(V),    R_eq(V) = V²/[h S (T_ss - T_a)]

with R_eq linear in V between the four voltages of the table and constant outside. Times of the sine count from the
start of its second period.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import cast

import numpy as np

from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.physics.electrical.sources import PowerSource, VoltageSource
from martensite.physics.thermal.base import AbstractCooling, Environment
from martensite.physics.thermal.films import ConstantCooling, PolynomialCooling
from martensite.scenario.examples import EXAMPLES
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.result import Result
from martensite.studies.readings import ZERO, load_once, passing_time
from martensite.studies.tables import Printed

SCENARIO = EXAMPLES / "migaone.toml"
load_scenario = partial(load_once, SCENARIO)
VARIANTS = {
    "polynomial": "polynomial h, heat capacity 837 J/(kg K) and latent heat",
    "constant": "mean constant h, heat capacity 837 J/(kg K) and latent heat",
    "paper": "polynomial h, heat capacity 320 J/(kg K), no latent heat: the paper's equations",
    "one-curve": "the paper's equations, and (6), which holds for heating, on cooling too",
}
_TOLERANCE = 1e-4
_SETTLING = 600.0
"""More than ten of the longest time constants of a step response [s]."""


def base_wire() -> Wire:
    """Return the wire of the scenario."""
    return cast("Wire", load_scenario().single_system.element)


def read_number(path: str) -> float:
    """Return a parameter of the scenario's system by its dotted path [SI]."""
    return load_scenario().system.value_of(path)


def printed_film(printed: Printed) -> PolynomialCooling:
    """Return the film coefficient as printed."""
    return PolynomialCooling(h0=printed.h0, h1=printed.h1, h2=printed.h2)


def mean_constant(printed: Printed) -> ConstantCooling:
    """Return the mean of the four film coefficients of Table 2."""
    return ConstantCooling(h=sum(printed.steps.column("film")) / len(printed.steps.column("film")))


def run_heated(cooling: AbstractCooling, values: Mapping[str, float] | None = None) -> System:
    """Return the bench with a given cooling, heated by power, with changed parameters."""
    base = load_scenario().single_system
    environment = base.environment.with_parts(cooling=cooling)
    system = base.with_parts(environment=environment, source=PowerSource())
    return system.with_values(values or {})


@cache
def run_variant(key: str, printed: Printed) -> System:
    """Return the bench of one of `VARIANTS`."""
    if key == "constant":
        return run_heated(mean_constant(printed))
    values: dict[str, float] = {}
    if key in ("paper", "one-curve"):
        values = {"heat_capacity": printed.heat_capacity, "latent_heat": 0.0}
    if key == "one-curve":
        values |= {"M_s": read_number("A_f"), "M_f": read_number("A_s")}
    return run_heated(printed_film(printed), values)


def heating_power(step: Printed, printed: Printed) -> float:
    """Return the power of a steady state of Table 2 [W]."""
    return step.film * base_wire().surface() * (step.temperature - printed.ambient)


def equivalent_resistance(voltage: float, printed: Printed) -> float:
    """Return R_eq at a voltage [V], such that V²/R_eq is the heating power [ohm]."""
    points = [(s.voltage, s.voltage**2 / heating_power(s, printed)) for s in printed.steps]
    if voltage <= points[0][0]:
        return points[0][1]
    for (low, first), (high, last) in pairwise(points):
        if voltage <= high:
            return first + (last - first) * (voltage - low) / (high - low)
    return points[-1][1]


@cache
def steady_temperature(cooling: AbstractCooling, power: float) -> float:
    """Return the simulated steady temperature under a power [W], in °C."""
    run = simulate(run_heated(cooling), Constant(level=power), _SETTLING, tolerance=_TOLERANCE, samples=101)
    return run["temperature"][-1] - ZERO


@cache
def sine_run(key: str, printed: Printed) -> Result:
    """Return two periods of the sine with one of `VARIANTS`."""
    sine, duration, samples = (load_scenario().single_waveform, load_scenario().duration, load_scenario().samples)
    times = [duration * i / (samples - 1) for i in range(samples)]
    volts = [sine.value(t) for t in times]
    powers = [v * v / equivalent_resistance(v, printed) for v in volts]
    return simulate(
        run_variant(key, printed),
        Table(times=tuple(times), values=tuple(powers)),
        duration,
        tolerance=_TOLERANCE,
        samples=samples,
    )


@dataclass(frozen=True)
class SineResponse:
    """Quantities of the second period of the sine."""

    hottest: float
    """[°C]"""
    rise: float
    """Time of half the quoted stroke on heating [s]."""
    fall: float
    """Time of half the quoted stroke on cooling [s]."""
    stroke: float
    """[m]"""


def read_response(key: str, printed: Printed) -> SineResponse:
    """Return the quantities of a variant."""
    run = sine_run(key, printed)
    times, curves = run.draw_curves(["temperature", "position"])
    start, position = 0.5 * run.times[-1], curves["position"].tolist()
    half = int(np.searchsorted(times, start))
    level = 0.5 * printed.stroke
    top = max(range(half, len(position)), key=position.__getitem__)
    falling = [-x for x in position[top:]]
    return SineResponse(
        hottest=float(curves["temperature"][half:].max()) - ZERO,
        rise=passing_time(times[half : top + 1], position[half : top + 1], level) - start,
        fall=passing_time(times[top:], falling, -level) - start,
        stroke=position[top] - min(position[half:]),
    )


@cache
def actuation_time(
    printed: Printed, ambient: float, values: tuple[tuple[str, float], ...] = (), duration: float = 3.0
) -> float:
    """Return the time from switching on the supply to 95 % of the stroke [s].

    Args:
        printed: supply voltage, and resistance of the wire; nothing is in series.
        ambient: ambient temperature [°C].
        values: changed parameters of the system, by name.
        duration: duration of the run [s], in which the stroke must complete.
    """
    environment = Environment(temperature=ambient + ZERO, cooling=printed_film(printed))
    base = load_scenario().single_system.with_parts(environment=environment, source=VoltageSource())
    system = base.with_values(dict(values))
    wire = cast("Wire", system.element)
    rho = printed.resistance * wire.section() / wire.length
    system = system.with_values({"rho_A": rho, "rho_M": rho})
    supply = Constant(level=printed.supply)
    run = simulate(system, supply, duration, tolerance=_TOLERANCE, samples=1001)
    return run.measure("reach-time(position, share=0.95)")
