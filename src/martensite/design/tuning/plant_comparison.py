"""Gains beside each other on many plants: who has the smaller ITAE, how often and by how much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from martensite.base.errors import ParameterError, suggest_name
from martensite.design.tuning.goals import Course, Numbers
from martensite.design.tuning.loop_runs import LoopRuns
from martensite.design.tuning.measures import compute_itae
from martensite.design.tuning.plant_spread import Plants


@dataclass(frozen=True)
class Ratio:
    """ITAE of one set of numbers over that of another, plant by plant."""

    median: float
    worst: float
    """Largest."""
    won: float
    """Share of the plants on which it is below 1."""


@dataclass(frozen=True, eq=False)
class OverPlants:
    """ITAE of sets of numbers on plants."""

    itae: dict[str, Numbers]
    """One number per plant, in the unit of what is controlled times s²; infinite where a run
    fails."""

    def best(self) -> str:
        """The set with the least median."""
        return min(self.itae, key=lambda name: float(np.median(self.itae[name])))

    def ratio(self, one: str, other: str) -> Ratio:
        """How one set does beside another.

        Raises:
            ParameterError: there is no such set.
        """
        for name in (one, other):
            if name not in self.itae:
                raise ParameterError(f"There is no set `{name}`. {suggest_name(name, self.itae)}")
        found = self.itae[one] / self.itae[other]
        return Ratio(float(np.median(found)), float(found.max()), float((found < 1.0).mean()))


def compare_over_plants(runs: LoopRuns, sets: Mapping[str, Mapping[str, float]], plants: Plants) -> OverPlants:
    """Run every set of numbers, given by path, on every plant.

    Raises:
        ParameterError: the reference asks for nothing.
    """
    nominal = runs.run(runs.table({}, 1))
    course = Course(nominal.one(0), runs.bench.period)
    found: dict[str, Numbers] = {}
    for name, numbers in sets.items():
        seen = runs.run(runs.table({**plants.values, **numbers}, plants.count))
        values = np.asarray(compute_itae(seen, course))
        found[name] = np.where(np.isfinite(values), values, np.inf)
    return OverPlants(found)
