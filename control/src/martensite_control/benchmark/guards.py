"""The guard of the benchmark: the same for every entry, made from the sensors of the plant."""

from __future__ import annotations

from martensite.control.checks.base import Checks
from martensite.control.loop.bench import Bench
from martensite.control.supervisors.from_sensors import checks_for
from martensite.control.supervisors.guard import Guard

MARGIN = 20.0
"""How far below the limit of the element the guard cuts, by the reading of a thermometer [K]; assumed."""


def build_guard(bench: Bench) -> Guard:
    """Checks of all sensors, which cut for good."""
    limits = [one.element.limits.temperature_limit for one in bench.plant.actuators().values()]
    return Guard(checks=Checks(**checks_for(bench, temperature_limit=min(limits) - MARGIN)))
