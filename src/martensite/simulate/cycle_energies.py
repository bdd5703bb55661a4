"""Energies of every cycle of a run (`martensite.simulate.energy`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.actuators.mechanisms.load_line import AbstractLoadLine
from martensite.base.errors import InputError, require_known
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.curve_rows import add_step_rows
from martensite.simulate.energy import EnergyCourses, integrate_energies
from martensite.simulate.result import Result

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class CycleEnergies(EnergyCourses):
    """Energies of every cycle, shape (cycles,) [J]."""

    period: float
    """[s]"""

    @property
    def net_work(self) -> Numbers:
        """Return the work less the returned work."""
        return self.work - self.returned

    @property
    def stored_energy(self) -> Numbers:
        """Return the electrical energy less the heat loss: the energy stored in the elements after a cycle."""
        return self.electrical - self.lost


def compute_cycle_energies(result: Result, period: float, *, pairs: Sequence[Pair] | None = None) -> CycleEnergies:
    """Compute the energies of all whole cycles of a run.

    Args:
        result: a run, of a plant or of a bench.
        period: length of a cycle [s].
        pairs: columns of force and of the coordinate that grows as it pulls, such as a torque and
            an angle; by default force and position of a mechanism with one element on a line.

    Raises:
        InputError: the run has no whole cycle, a column is missing, or the mechanism needs `pairs`.
    """
    result = add_step_rows(result)
    times = np.asarray(result.times)
    cycles = math.floor((times[-1] - times[0]) / period * (1.0 + 1e-9)) if period > 0.0 else 0
    if cycles < 1:
        raise InputError(f"A run of {times[-1] - times[0]:g} s has no whole cycle of {period:g} s.")
    ends = times[0] + period * np.arange(cycles + 1)
    ways = [
        (np.asarray(result.columns[force]), np.asarray(result.columns[coordinate]))
        for force, coordinate in _find_columns(result, pairs)
    ]
    over: Any = integrate_energies(result, ways)
    totals: tuple[Numbers, ...] = over.electrical, over.lost, over.work, over.returned
    reached: list[Numbers] = [np.interp(ends, times, total) for total in totals]
    energies = [np.diff(total) for total in reached]
    electrical, lost, work, returned = energies
    return CycleEnergies(electrical, lost, work, returned, period)


def _find_columns(result: Result, pairs: Sequence[Pair] | None) -> Sequence[Pair]:
    """Return the columns of force and coordinate."""
    if pairs is None:
        if not isinstance(result.system.mechanism, AbstractLoadLine):
            raise InputError("Give `pairs`: which force of this mechanism works along which coordinate.")
        (port,) = result.system.actuators()
        return [(result.system.label(port, "force"), result.coordinate)]
    for name in (one for pair in pairs for one in pair):
        require_known("column", name, result.columns)
    return pairs
