"""Guards of the benchmark: the same for every entry.

sensors     that of all runs that are ranked: checks of all sensors, of the thermometer 20 K below the limit of the
element; they cut for good
default     what a loop has if nothing is said: a bound on the temperature by the nominal plant, which limits
none        nothing, for what would have become of a run that was cut
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from martensite.control.checks.base import Checks
from martensite.control.loop.bench import Bench
from martensite.control.supervisors.default_guard import ANSWER, find_default_bounds
from martensite.control.supervisors.from_sensors import build_sensor_checks
from martensite.control.supervisors.guard import Guard

MARGIN = 20.0
"""How far below the limit of the element the guard cuts, by the reading of a thermometer [K]; assumed."""


def build_guard(bench: Bench) -> Guard:
    """Checks of all sensors, which cut for good."""
    limits = [one.element.limits.temperature_limit for one in bench.plant.actuators().values()]
    return Guard(checks=Checks(**build_sensor_checks(bench, temperature_limit=min(limits) - MARGIN)))


def build_default_guard(bench: Bench) -> Guard:
    """The guard that a loop has if nothing is said."""
    bounds, _ = find_default_bounds(bench.plant, bench.controllers.members())
    return Guard(checks=Checks(**bounds), answer=ANSWER)


SENSORS, DEFAULT, UNGUARDED = "sensors", "default", "none"
GUARDS: Mapping[str, Callable[[Bench], Guard | None]] = {
    SENSORS: build_guard,
    DEFAULT: build_default_guard,
    UNGUARDED: lambda _: None,
}
