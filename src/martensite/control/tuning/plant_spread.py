"""Plants around a nominal plant: parameters drawn within declared spreads.

    p = p₀ (1 + s z),       temperatures p = p₀ + s z,       z in [-1, 1]

z is uniform: a scrambled Sobol' sequence (Owen (1998); SciPy) or a Latin hypercube, with a seed. Only the plant is
drawn; models of controllers and observers stay nominal. `compare_over_plants` compares the ITAE of sets of gains.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.loop.bench import Bench
from martensite.control.loop.plant_leaves import PLANT, find_plant_leaf, parse_half_width, require_allowed
from martensite.control.tuning.goals import Course, Numbers
from martensite.control.tuning.loop_runs import LoopRuns
from martensite.control.tuning.measures import compute_itae
from martensite.search.starts import draw_points

METHODS = ("sobol", "latin-hypercube")


@dataclass(frozen=True, eq=False)
class Plants:
    """Plants of one bench."""

    values: Mapping[str, Any]
    """One value per plant, in SI, by path in the bench."""
    count: int
    seed: int

    def bench(self, bench: Bench, k: int) -> Bench:
        """Return the bench with plant k; its controllers and observers keep the nominal model.

        Raises:
            ParameterError: there is no plant k.
        """
        if not 0 <= k < self.count:
            raise ParameterError(f"There are {self.count} plants from 0 on; there is no {k}.")
        return bench.with_values({path: float(row[k]) for path, row in self.values.items()})


def draw_plants(
    bench: Bench, spreads: Mapping[str, float], count: int = 64, seed: int = 0, method: str = "sobol"
) -> Plants:
    """Draw plants around the plant of a bench.

    Args:
        bench: bench with the nominal plant.
        spreads: half widths by path, or unique ending of a path, in the plant: relative, or in K for temperatures.
        count: number of plants; a power of 2 covers the spread best.
        seed: seed of the draw.
        method: sobol or latin-hypercube.

    Raises:
        ParameterError: an unknown name, an invalid spread, a value outside its limits, or no plant.
    """
    if method not in METHODS:
        raise ParameterError(f"There is no draw `{method}`. {suggest_name(method, METHODS)}")
    if count < 1 or not spreads:
        raise ParameterError(
            f"Plants need a spread and must be at least 1, but are {count} with {len(spreads)} spreads."
        )
    unit = _draw_unit(len(spreads), count, seed, method)
    rows = zip(spreads.items(), unit.T, strict=True)
    return Plants(dict(_draw_parameter(bench, name, spread, z) for (name, spread), z in rows), count, seed)


def _draw_unit(width: int, count: int, seed: int, method: str) -> NDArray[np.float64]:
    """Return values in [-1, 1], shape (count, width)."""
    if method == "sobol":
        return 2.0 * draw_points(width, count, seed) - 1.0
    qmc: Any = import_module("scipy.stats.qmc")
    return 2.0 * qmc.LatinHypercube(width, seed=seed).random(count) - 1.0


def _draw_parameter(bench: Bench, name: str, spread: float, z: NDArray[np.float64]) -> tuple[str, NDArray[np.float64]]:
    leaf = find_plant_leaf(bench, name)
    if not (math.isfinite(spread) and spread > 0.0):
        raise ParameterError(f"The spread of `{name}` must be above 0, but is {spread:g}.")
    if leaf.value == 0.0 and leaf.declared.unit != "K":
        raise ParameterError(f"`{name}` is 0, and a relative spread needs another value.")
    values = leaf.value + parse_half_width(leaf, spread) * z
    require_allowed(leaf, float(values.min()), float(values.max()))
    return PLANT + leaf.path, values


@dataclass(frozen=True)
class Ratio:
    """ITAE of one set of parameters over another, on all plants."""

    median: float
    worst: float
    won: float
    """Fraction of the plants with a ratio below 1."""


@dataclass(frozen=True, eq=False)
class OverPlants:
    """ITAE of sets of parameters on plants."""

    itae: dict[str, Numbers]
    """One value per plant, in the unit of the controlled output times s²; infinite for a failed run."""

    def best(self) -> str:
        """Return the set with the least median."""
        return min(self.itae, key=lambda name: float(np.median(self.itae[name])))

    def ratio(self, one: str, other: str) -> Ratio:
        """Return the ratio of two sets; raise `ParameterError` if a set does not exist."""
        for name in (one, other):
            if name not in self.itae:
                raise ParameterError(f"There is no set `{name}`. {suggest_name(name, self.itae)}")
        ratios = self.itae[one] / self.itae[other]
        return Ratio(float(np.median(ratios)), float(ratios.max()), float((ratios < 1.0).mean()))


def compare_over_plants(runs: LoopRuns, sets: Mapping[str, Mapping[str, float]], plants: Plants) -> OverPlants:
    """Run every set of parameters, given by path, on every plant.

    Raises:
        ParameterError: the reference stays where the output begins.
    """
    nominal = runs.run(runs.table({}, 1))
    course = Course(nominal.one(0), runs.bench.period)
    itae: dict[str, Numbers] = {}
    for name, numbers in sets.items():
        outputs = runs.run(runs.table({**plants.values, **numbers}, plants.count))
        values = np.asarray(compute_itae(outputs, course))
        itae[name] = np.where(np.isfinite(values), values, np.inf)
    return OverPlants(itae)
