"""Highest temperature of an element for any wanted signals, with a guard and without.

With the largest power P̂, the heat capacity C without latent heat, the least conductance G and the surroundings T_a of
the plant (`martensite.control.supervisors.from_plant`), no signal leads beyond

    T_a + P̂/G                                  without a guard
    T_lim                                      by a bound that is told no less than this
    T_r + P̂/C (τ + d + 4 σ_d + t_s + 2 t)      by a measured temperature: lag, delay, jitter, sample time, period

T_r is the temperature that reads as the limit at rest, at the least with noise of 4 σ and rounding. While it is read as
less, T - T_r grows at P̂/C at most: with a lag, to P̂ τ/C. All of them are for elements of one temperature, sensors that
work and readings on a straight line with it. A switch that closes for a share D of a period t heats by up to P̂ t/(4 C)
above its mean. While martensite is left an element may still reach the end of its transformation: the checks bound it
to that at its `stress_limit`, if it has one, where it is higher.
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
"""Departure of a reading from a straight line that counts as zero, as a fraction of its change."""
SPAN = 100.0
"""Temperatures between which readings are looked at [K]."""
ROUNDED = 1e-9
SLOW, LEFT = 1e3, 1e-3
"""Duration of a heating in which rates have settled [s], and martensite fraction that counts as zero."""
BEYOND, HALVINGS = 300.0, 10
"""Range above a limit in which the end of a transformation is searched [K], and number of halvings."""


class WorstCase(NamedTuple):
    """Highest temperatures [K] of the element of a drive, under all signals."""

    guarded: float
    """With the guard; as without where no check bounds it."""
    check: str
    """Name of the check that bounds it; empty for none."""
    free: float
    """Without a guard."""


def find_worst_case(bench: Bench, drive: str, full: float) -> WorstCase:
    """Return the worst case of one drive, whose largest signal is given in the unit of its source.

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
        found = bound_by_check(bench, one, port, check, most)
        if found is not None and isinstance(guard, Guard):
            least = find_transformation_end(one, found), most.settled_bound(floats, guard.safe)
            rows.append((max(found, *least), name))
    guarded, name = min(rows)
    return WorstCase(guarded + pulses, name, free + pulses)


def bound_by_check(bench: Bench, one: Actuator, port: str, check: AbstractCheck, most: ThermalBound) -> float | None:
    """Return the highest temperature [K] that a check admits, if it bounds it; `most` is its worst case."""
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
    """Return the temperature [K] above which an element is austenite at its stress limit; at least the given one."""
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


def _is_covered(told: ThermalBound, own: ThermalBound) -> bool:
    """Return whether a bound assumes no less heat than the plant can bring."""
    more = told.power >= own.power * (1.0 - ROUNDED) and told.ambient >= own.ambient - ROUNDED
    slower = told.capacity <= own.capacity * (1.0 + ROUNDED) and told.conductance <= own.conductance * (1.0 + ROUNDED)
    return more and slower and told.rises == own.rises


def _find_felt_temperature(mounted: MountedSensor, limit: float, ambient: float) -> float | None:
    """Return the highest temperature [K] at rest that may read as a limit; None if that is not known."""
    sensor: Any = mounted.sensor

    def read(temperature: float) -> float:
        truth = [temperature, *(ambient for _ in mounted.sees()[1:])]
        return float(sensor.step(floats, sensor.rest(floats, truth), truth, -WORST, 0.0)[0]) - 0.5 * sensor.resolution

    low, middle, high = (read(ambient + share * SPAN) for share in (0.0, 0.5, 1.0))
    bent = abs(low + high - 2.0 * middle) > STRAIGHT * abs(high - low)
    drifts, top = getattr(sensor, "drift", 0.0) != 0.0, sensor.limits()
    if bent or high <= low or drifts or (top is not None and top[1] <= limit):
        return None
    return ambient + SPAN * (limit - low) / (high - low)
