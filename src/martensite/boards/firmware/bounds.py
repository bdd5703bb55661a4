"""Temperature bounds of the guard of a loop, for the firmware around it.

The loop counts one period per sample. The firmware adds the heating of late samples, keeps the bound while the loop
does not run, and starts it at its limit after a reset, when the temperature of the element is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.bench import Bench
from martensite.control.loop.realtime import trace_loop
from martensite.control.supervisors.guard import OWN, Guard

NEAR = 1.0
"""Distance of a bound to the ambient temperature that counts as cold [K]."""


@dataclass(frozen=True)
class FirmwareBound:
    """A temperature bound: b' = rate |u| - cooling (b - ambient)."""

    state: int
    """Place in the state of the loop."""
    drive: int
    rate: float
    """Heating at a duty cycle of 1, without losses [K/s]."""
    cooling: float
    """[1/s]"""
    ambient: float
    """[K]"""
    limit: float
    """[K]"""

    @property
    def cooling_time(self) -> float:
        """Return the time from the limit until the bound is cold [s]."""
        return max(0.0, math.log((self.limit - self.ambient) / NEAR)) / self.cooling

    def find_margin(self, period: float) -> float:
        """Return the largest heating in one period [K], by which a late sample may pass the limit."""
        return self.rate * period


def list_bounds(bench: Bench) -> tuple[FirmwareBound, ...]:
    """Return the temperature bounds of a bench; empty without a guard."""
    return tuple(_find_bounds(bench, bench.supervisor)) if isinstance(bench.supervisor, Guard) else ()


def _find_bounds(bench: Bench, guard: Guard) -> Iterator[FirmwareBound]:
    drives, checks = [one.name for one in bench.plant.drives()], guard.checks.members().values()
    own = sum(OWN + one.size for one in checks)
    place = trace_loop(bench).size - len(drives) - 1 - own  # memory of the guard, alarm, signals
    for one in checks:
        if isinstance(one, ThermalBound):
            rate = float(one.power / one.capacity / one.full)
            cooling = float(one.conductance / one.capacity)
            state = place + OWN
            yield FirmwareBound(state, drives.index(one.drive), rate, cooling, float(one.ambient), float(one.limit))
        place += OWN + one.size
