"""Search for parameters of least cost over a batch of plants.

The search descends the cost of `martensite.control.tuning.goals` with its exact derivatives (`martensite.control.
tuning.loop_runs`), on logarithms of gains (`martensite.search.box_search`), from the best of several starts: the
parameters of the bench, given starts such as gains by rules, and points scattered around the best of them. Between its
switchings a loop is smooth; at a switching it jumps a little. Where a descent ends at such an edge, a cloud of points
around it is tried, and the best one continues. Derivatives of an oscillating loop grow with time and are limited. A
parameter that acts through a switch alone, such as the band of an on/off controller, has no derivative; then only
scattered starts and clouds search. Without a compiler there are no derivatives.

Free gains are texts of `martensite.search.free_text`: `Kp`, `Ki=0.1..10`. A gain that starts away from 0 keeps its sign
and is searched on its logarithm. Default bounds are a hundredth of the least to a hundred times the largest start, or
the declared bounds of a parameter that starts at 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.base import units
from martensite.base.errors import ParameterError, SolveError
from martensite.control.loop.bench import Bench
from martensite.control.tuning.goals import Cost, Numbers
from martensite.control.tuning.loop_runs import LoopOutputs, LoopRuns
from martensite.control.tuning.plant_spread import Plants
from martensite.search.box_search import BoxSearch, JudgedPoints, PointSlopes, Tell
from martensite.search.free_numbers import FreeNumber, SearchRange, Target, build_free, choose_bounds
from martensite.search.free_text import is_bare, parse_free

BOX_FACTOR = 100.0
"""Factor of the default bounds around the starts."""


def build_free_gains(bench: Bench, texts: Sequence[str], starts: Sequence[Mapping[str, float]]) -> list[FreeNumber]:
    """Return the free parameters of the controllers of a bench.

    Args:
        bench: the bench.
        texts: paths, or unique endings of paths among controllers, such as `drive.Kp` or `Kp`, optionally with bounds.
        starts: starts of the search, as parameters by path.

    Raises:
        ParameterError: an unknown name, a parameter without a sign or bounds, or invalid bounds.
    """
    if not texts:
        raise ParameterError("Nothing is free: name parameters of controllers, such as Kp and Ki.")
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    parameters: list[FreeNumber] = []
    for text in texts:
        words = parse_free(text)
        path = "controllers." + bench.controllers.resolve(words.name.removeprefix("controllers."))
        target = Target.from_leaf(leaves[path])
        wanted = replace(SearchRange.read(words, target.unit, _convert_to(target.unit)), name=path)
        values = [target.value, *(start[path] for start in starts if path in start)]
        low, high = choose_bounds(wanted, target, values, BOX_FACTOR)
        scale = wanted.scale or ("log" if low * high > 0.0 else "linear")
        wanted = replace(wanted, low=low, high=high, scale=scale)
        parameters.append(build_free(wanted, [target], path))
    return parameters


def _convert_to(unit: str) -> Callable[[str], float]:
    """Return a reader of bounds; bounds without a unit are in SI."""
    return lambda text: float(text) if is_bare(text) else units.parse_quantity(text, unit)


FAILED_COST = 1e3
"""Cost of a plant whose run fails, far above the cost of a working loop."""
STEEPEST_SLOPE = 100.0
"""Largest accepted slope of a plant, over its cost, per unit of a logarithm."""
CLOUD_SPREAD, LINEAR_SPREAD, START_SPREAD = 0.15, 0.03, 1.0
"""Spread of a cloud in logarithms, or over a linear range; spread of starts in logarithms."""


@dataclass(frozen=True)
class TuningSearch:
    """Settings of the search for parameters."""

    random_starts: int = 16
    """Number of starts scattered around the best given start."""
    searches: int = 2
    """Number of best starts that are continued."""
    iterations: int = 40
    clouds: int = 2
    slopes: int = 16
    """Number of plants, the first of the drawn ones, for derivatives. Starts and ends are compared on all plants."""
    seed: int = 0


class GainCosts:
    """Costs at places z = width · fraction of gains, so that a step is a step of the logarithm."""

    def __init__(
        self, runs: LoopRuns, cost: Cost, free: Sequence[FreeNumber], plants: Plants | None, most: int
    ) -> None:
        """Prepare runs; derivatives use at most `most` plants."""
        self.loop, self.cost, self.free = runs, cost, free
        self.plant_values: Mapping[str, Any] = plants.values if plants else {}
        self.count = plants.count if plants else 1
        self.evaluations = self.gradients = 0
        self.widths = np.array([one.width for one in free])
        log = [one.logarithmic for one in free]
        self.scatter = np.where(log, CLOUD_SPREAD, LINEAR_SPREAD * self.widths)
        self.followed = min(max(most, 1), self.count)
        self.differentiable, self.partial = runs.native, self.followed < self.count

    @property
    def runs(self) -> int:
        """Return the number of runs, one per plant."""
        return self.evaluations + self.gradients

    def numbers(self, places: Numbers) -> dict[str, Numbers]:
        """Return the free parameters by path at places, shape (..., free)."""
        fractions = places / self.widths
        return {one.path: one.value(fractions[..., k]) for k, one in enumerate(self.free)}

    def place(self, values: Mapping[str, float]) -> Numbers:
        """Return the nearest place of parameters by path."""
        return self.widths * np.array([one.share(values[one.path]) for one in self.free])

    def judge(self, z: Numbers) -> JudgedPoints:
        """Return the costs of places, shape (points, free), over all plants."""
        return JudgedPoints(self.compute_costs(self.numbers(z), len(z)), np.zeros((len(z), 0)))

    def compute_costs(self, numbers: Mapping[str, Any], points: int) -> Numbers:
        """Return the costs, shape (points,), of parameters by path on all plants, run as one batch."""
        spread = {path: np.repeat(column, self.count) for path, column in numbers.items()}
        plant_values = {path: np.tile(column, points) for path, column in self.plant_values.items()}
        outputs = self.loop.run(self.loop.table({**plant_values, **spread}, points * self.count))
        self.evaluations += points * self.count
        costs = np.minimum(self.cost(outputs), FAILED_COST).reshape(points, self.count)
        return np.array([self.cost.goal.over_plants(row)[0] for row in costs])

    def differentiate(self, z: Numbers) -> PointSlopes:
        """Return the cost at a place and its derivatives, over the plants for derivatives."""
        plant_values = {path: column[: self.followed] for path, column in self.plant_values.items()}
        table = self.loop.table({**plant_values, **self.numbers(z)}, self.followed)
        costs, slopes = np.zeros(len(table)), np.zeros((len(table), len(z)))
        fractions = (z / self.widths).tolist()
        inner = np.array([one.slope(u) for one, u in zip(self.free, fractions, strict=True)])
        inner /= self.widths
        for k, row in enumerate(table):
            run = self.loop.slopes(row, [one.path for one in self.free])
            if run is None:
                costs[k] = FAILED_COST
                continue
            outputs, changes = run
            costs[k] = min(float(self.cost(LoopOutputs(*(c[None, :] for c in outputs)))[0]), FAILED_COST)
            slopes[k] = self.cost.slope(outputs, changes) * inner
            size = float(np.linalg.norm(slopes[k]))
            slopes[k] *= min(1.0, STEEPEST_SLOPE * costs[k] / size) if size > 0.0 else 1.0
        self.gradients += len(table)
        least, weights = self.cost.goal.over_plants(costs)
        return PointSlopes(least, np.zeros(0), weights @ slopes, np.zeros((0, len(z))))


def search_gains(
    costs: GainCosts,
    starts: Sequence[Mapping[str, float]],
    search: TuningSearch,
    watch: Tell | None,
    keep: Callable[[dict[str, float]], None] | None = None,
) -> tuple[float, Numbers, tuple[float, ...]]:
    """Return the least cost, its place, and the costs at the ends of descents.

    Raises:
        SolveError: no start can be run.
    """
    hunt = BoxSearch(costs, iterations=search.iterations, clouds=search.clouds, seed=search.seed, watch=watch)
    if keep is not None:
        hunt.keep = lambda point: keep({path: float(value) for path, value in costs.numbers(point.z).items()})
    points = hunt.judge(np.array([costs.place(start) for start in starts]))
    if hunt.best_point.goal >= FAILED_COST:
        raise SolveError(f"None of {len(starts)} starts of the tuning can be run.")
    wide = START_SPREAD / CLOUD_SPREAD
    points += hunt.judge(hunt.scatter_points(hunt.best_point.z, search.random_starts, wide))
    points = sorted(points, key=lambda point: point.goal)[: max(search.searches, 1)]
    for k, start in enumerate(points):
        hunt.tell(f"search {k + 1}", k / (len(points) + 1))
        hunt.descend(start.z)
    hunt.tell("looking around", len(points) / (len(points) + 1))
    hunt.look_around()
    return hunt.best_point.goal, hunt.best_point.z, tuple(sorted(hunt.ends))
