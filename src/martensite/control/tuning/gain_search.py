"""The search for parameters of least cost over a batch of plants.

The cost of `martensite.control.tuning.goals` is followed downhill with its exact derivatives,
which are marched in C beside the values (`martensite.control.tuning.loop_runs`), on logarithms of
gains (`martensite.search.box_search`), from the best of several starts. Starts are the numbers of
the bench, those that are given, such as gains by rules, and some scattered around the best of them.
Between its switchings a loop is smooth, over them it jumps a little: where a descent ends on such
an edge, a cloud of points around it is tried and the best gone on from. In a loop that swings by
itself derivatives grow from swing to swing: they are shortened to what can be. What acts through a
switch alone, such as the band of an ON/OFF controller, has no derivative; then scattered starts and
clouds are all that searches. Without a compiler there are no derivatives.

Free gains are texts of `martensite.search.free_text`: `Kp`, `Ki=0.1..10`. A gain that begins
away from 0 keeps its sign and is searched on its logarithm. Bounds that are not asked for are a hundredth of the
least to the hundredfold of the largest start, or what is declared of a number that begins at 0.
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
from martensite.control.tuning.loop_runs import LoopRuns, Seen
from martensite.control.tuning.plant_spread import Plants
from martensite.search.box_search import BoxSearch, JudgedPoints, PointSlopes, Tell
from martensite.search.free_numbers import FreeNumber, SearchRange, Target, build_free, choose_bounds
from martensite.search.free_text import is_bare, parse_free

BOX_FACTOR = 100.0
"""Box around the starts, as a factor."""


def build_free_gains(bench: Bench, texts: Sequence[str], starts: Sequence[Mapping[str, float]]) -> list[FreeNumber]:
    """Return free numbers of the controllers of a bench, with the `starts` of searches.

    Texts are paths, or unique endings of paths among controllers, such as `drive.Kp` or `Kp`, with bounds if they are
    not to be chosen.

    Raises:
        ParameterError: an unknown name, a number without a sign or bounds, or invalid bounds.
    """
    if not texts:
        raise ParameterError("Nothing is free: name parameters of controllers, such as Kp and Ki.")
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    found: list[FreeNumber] = []
    for text in texts:
        words = parse_free(text)
        path = "controllers." + bench.controllers.resolve(words.name.removeprefix("controllers."))
        target = Target.from_leaf(leaves[path])
        wanted = replace(SearchRange.read(words, target.unit, _convert_to(target.unit)), name=path)
        begun = [target.value, *(start[path] for start in starts if path in start)]
        low, high = choose_bounds(wanted, target, begun, BOX_FACTOR)
        scale = wanted.scale or ("log" if low * high > 0.0 else "linear")
        wanted = replace(wanted, low=low, high=high, scale=scale)
        found.append(build_free(wanted, [target], path))
    return found


def _convert_to(unit: str) -> Callable[[str], float]:
    """Return a reader of bounds; without a unit they are in SI."""
    return lambda text: float(text) if is_bare(text) else units.parse_quantity(text, unit)


FAILED_COST = 1e3
"""Cost of a plant whose run fails: far above that of any loop that works."""
STEEPEST_SLOPE = 100.0
"""Steepest slope of a plant that is believed, in costs per unit of a logarithm."""
CLOUD_SPREAD, LINEAR_SPREAD, START_SPREAD = 0.15, 0.03, 1.0
"""Spread of a cloud in logarithms, or in shares of a linear range; that of starts in logarithms."""


@dataclass(frozen=True)
class TuningSearch:
    """Settings of the search for parameters."""

    scattered: int = 16
    """Starts scattered around the best one that is given."""
    searches: int = 2
    """Starts that are gone on from: the best."""
    iterations: int = 40
    """Iterations of each search."""
    clouds: int = 2
    """Number of tries around the best end."""
    slopes: int = 16
    """Plants on which a search follows derivatives: the first of those drawn. Where searches begin
    and which end is best is judged on all of them."""
    seed: int = 0


class GainCosts:
    """Costs of places z = width · share of gains, so that a step is one of a logarithm."""

    def __init__(
        self, runs: LoopRuns, cost: Cost, free: Sequence[FreeNumber], plants: Plants | None, most: int
    ) -> None:
        """Prepare runs; derivatives are taken on so many plants at most."""
        self.loop, self.cost, self.free = runs, cost, free
        self.drawn: Mapping[str, Any] = plants.values if plants else {}
        self.count = plants.count if plants else 1
        self.evaluations = self.gradients = 0
        self.widths = np.array([one.width for one in free])
        log = [one.logarithmic for one in free]
        self.scatter = np.where(log, CLOUD_SPREAD, LINEAR_SPREAD * self.widths)
        self.followed = min(max(most, 1), self.count)
        self.differentiable, self.partial = runs.native, self.followed < self.count

    @property
    def runs(self) -> int:
        """Runs so far, one per plant."""
        return self.evaluations + self.gradients

    def numbers(self, places: Numbers) -> dict[str, Numbers]:
        """Return free numbers by path at places, shape (..., free)."""
        shares = places / self.widths
        return {one.path: one.value(shares[..., k]) for k, one in enumerate(self.free)}

    def place(self, values: Mapping[str, float]) -> Numbers:
        """Return the nearest place of numbers by path."""
        return self.widths * np.array([one.share(values[one.path]) for one in self.free])

    def judge(self, z: Numbers) -> JudgedPoints:
        """Return the costs of places (points, free) over all plants."""
        return JudgedPoints(self.compute_costs(self.numbers(z), len(z)), np.zeros((len(z), 0)))

    def compute_costs(self, numbers: Mapping[str, Any], points: int) -> Numbers:
        """Return the costs (points,) of numbers by path on all plants, run together."""
        spread = {path: np.repeat(column, self.count) for path, column in numbers.items()}
        drawn = {path: np.tile(column, points) for path, column in self.drawn.items()}
        seen = self.loop.run(self.loop.table({**drawn, **spread}, points * self.count))
        self.evaluations += points * self.count
        costs = np.minimum(self.cost(seen), FAILED_COST).reshape(points, self.count)
        return np.array([self.cost.goal.over_plants(row)[0] for row in costs])

    def differentiate(self, z: Numbers) -> PointSlopes:
        """Return the cost at a place and its derivatives, over the plants that are followed."""
        drawn = {path: column[: self.followed] for path, column in self.drawn.items()}
        table = self.loop.table({**drawn, **self.numbers(z)}, self.followed)
        costs, slopes = np.zeros(len(table)), np.zeros((len(table), len(z)))
        shares = (z / self.widths).tolist()
        inner = np.array([one.slope(u) for one, u in zip(self.free, shares, strict=True)])
        inner /= self.widths
        for k, row in enumerate(table):
            found = self.loop.slopes(row, [one.path for one in self.free])
            if found is None:
                costs[k] = FAILED_COST
                continue
            seen, changes = found
            costs[k] = min(float(self.cost(Seen(*(c[None, :] for c in seen)))[0]), FAILED_COST)
            slopes[k] = self.cost.slope(seen, changes) * inner
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
    """Return the least cost, where it is (the first start if none is less), and where descents ended.

    Raises:
        SolveError: no start can be run.
    """
    hunt = BoxSearch(costs, iterations=search.iterations, clouds=search.clouds, seed=search.seed, watch=watch)
    if keep is not None:
        hunt.keep = lambda point: keep({path: float(value) for path, value in costs.numbers(point.z).items()})
    begun = hunt.judge(np.array([costs.place(start) for start in starts]))
    if hunt.found.goal >= FAILED_COST:
        raise SolveError(f"None of {len(starts)} starts of the tuning can be run.")
    wide = START_SPREAD / CLOUD_SPREAD
    begun += hunt.judge(hunt.scatter_points(hunt.found.z, search.scattered, wide))
    begun = sorted(begun, key=lambda point: point.goal)[: max(search.searches, 1)]
    for k, start in enumerate(begun):
        hunt.tell(f"search {k + 1}", k / (len(begun) + 1))
        hunt.descend(start.z)
    hunt.tell("looking around", len(begun) / (len(begun) + 1))
    hunt.look_around()
    return hunt.found.goal, hunt.found.z, tuple(sorted(hunt.ends))
