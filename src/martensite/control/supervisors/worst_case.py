"""Highest temperature of an element for all signals, with and without a guard.

With the largest power P̂, the heat capacity C without latent heat, the least conductance G and the ambient temperature
T_a of the plant (`martensite.control.supervisors.from_plant`), the temperature never exceeds

    T_a + P̂/G                                  without a guard
    T_lim                                      with a `thermal-bound` of at least these values
    T_r + P̂/C (τ + d + 4 σ_d + t_s + 2 t)      with a measured temperature: lag, delay, jitter, sample time, period

T_r is the temperature that reads as the limit in the steady state with noise of 4 σ and rounding. Below it, T - T_r
grows at P̂/C at most: with a lag, to P̂ τ/C. The formulas hold for elements of one temperature, and for working sensors
with a linear reading. A switch with duty cycle D and period t exceeds its mean by up to P̂ t/(4 C). While martensite is
left, the checks bound an element only to the end of its transformation at its `stress_limit`, if that is higher.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from martensite.actuators.assembly import Actuator
from martensite.actuators.elements.limits import MELTING
from martensite.control.checks.base import AbstractCheck
from martensite.control.checks.reading import Overheat
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import WORST, MountedSensor
from martensite.control.supervisors.from_plant import find_bound
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.physics.laws.base import Fractions

STRAIGHT = 1e-6
"""Relative deviation from a straight line below which a reading is linear."""
SPAN = 100.0
"""Range of temperatures above ambient in which readings are compared [K]."""
ROUNDED = 1e-9
SLOW, LEFT = 1e3, 1e-3
"""Duration of a heating that is slow for all rates [s], and martensite fraction that counts as zero."""
BEYOND, HALVINGS = 300.0, 10
"""Range above a limit in which the end of a transformation is searched [K], and number of bisections."""


class WorstCase(NamedTuple):
    """Highest temperatures of the element of a drive under all signals [K]."""

    guarded: float
    """Temperature with the guard; equal to `free` if no check bounds it."""
    check: str
    """Name of the check that bounds the temperature; empty without such a check."""
    free: float


def find_worst_case(bench: Bench, drive: str, full: float) -> WorstCase:
    """Return the worst case of a drive; `full` is its largest signal in the unit of its source.

    Raises:
        InputError: the element has several temperatures, or its source heats without a signal.
    """
    port = next(port for port in bench.plant.actuators() if bench.plant.drive_at(port) == drive)
    one = bench.plant.actuators()[port]
    most = find_bound(one, drive, MELTING, full)
    free = most.settled_bound(floats, full)
    pulses = 0.25 * most.power * bench.period / bench.turns / most.capacity if bench.switching == "pulses" else 0.0
    rows = [(free, "")]
    guard = bench.supervisor
    for name, check in guard.checks.members().items() if isinstance(guard, Guard) else ():
        bound = bound_by_check(bench, one, port, check, most)
        if bound is not None and isinstance(guard, Guard):
            least = find_transformation_end(one, bound), most.settled_bound(floats, guard.safe)
            rows.append((max(bound, *least), name))
    guarded, name = min(rows)
    return WorstCase(guarded + pulses, name, free + pulses)


def bound_by_check(bench: Bench, one: Actuator, port: str, check: AbstractCheck, most: ThermalBound) -> float | None:
    """Return the highest temperature that a check allows [K], or None; `most` is the bound without a limit."""
    if most.drive not in (check.cuts() or (most.drive,)):
        return None
    if isinstance(check, ThermalBound):
        own = find_bound(one, most.drive, check.limit, check.full)
        return check.limit if check.drive == most.drive and _is_covered(check, own) else None
    mounted = bench.sensors.members().get(getattr(check, "reading", ""))
    if not isinstance(check, Overheat) or mounted is None:
        return None
    if mounted.sees()[0] not in {bench.plant.label(port, name) for name in ("temperature", "hottest")}:
        return None
    felt = _find_felt_temperature(mounted, check.limit, one.environment.temperature)
    if felt is None:
        return None
    late = getattr(mounted.sensor, "lag", 0.0) + mounted.delay + WORST * mounted.jitter
    wait = late + mounted.sample_time + 2.0 * bench.period
    return felt + most.power / most.capacity * wait


def find_transformation_end(one: Actuator, least: float) -> float:
    """Return the temperature above which an element is austenite at its stress limit, at least `least` [K]."""
    law, stress, cold = one.element.law, one.element.limits.stress_limit, one.environment.temperature
    if not math.isfinite(stress):
        return least

    def remains(temperature: float) -> bool:
        memory = law.init(floats, Fractions(1.0, 1.0), stress, cold)
        return law.kinetics(floats, memory, stress, temperature, SLOW)[1].martensite > LEFT

    low, high = least, least + BEYOND
    if not remains(low):
        return least
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if remains(middle) else (low, middle)
    return high


def _is_covered(assumed: ThermalBound, own: ThermalBound) -> bool:
    """Return whether a bound assumes at least the heat of the plant."""
    more = assumed.power >= own.power * (1.0 - ROUNDED) and assumed.ambient >= own.ambient - ROUNDED
    slower = assumed.capacity <= own.capacity * (1.0 + ROUNDED) and assumed.conductance <= own.conductance * (
        1.0 + ROUNDED
    )
    return more and slower and assumed.rises == own.rises


def _find_felt_temperature(mounted: MountedSensor, limit: float, ambient: float) -> float | None:
    """Return the highest steady temperature that may read as a limit [K]; None if it is unknown."""
    sensor: Any = mounted.sensor

    def read(temperature: float) -> float:
        truth = [temperature, *(ambient for _ in mounted.sees()[1:])]
        return float(sensor.step(floats, sensor.rest(floats, truth), truth, -WORST, 0.0)[0]) - 0.5 * sensor.resolution

    low, middle, high = (read(ambient + fraction * SPAN) for fraction in (0.0, 0.5, 1.0))
    bent = abs(low + high - 2.0 * middle) > STRAIGHT * abs(high - low)
    drifts, top = getattr(sensor, "drift", 0.0) != 0.0, sensor.limits()
    if bent or high <= low or drifts or (top is not None and top[1] <= limit):
        return None
    return ambient + SPAN * (limit - low) / (high - low)
