"""The search for parameters of least cost over a batch of plants.

The cost of `martensite.design.tuning.goals` is followed downhill with its exact derivatives,
which are marched in C beside the values (`martensite.design.tuning.loop_runs`), by the method
L-BFGS-B (Byrd, Lu, Nocedal and Zhu (1995); SciPy) on logarithms of gains, from the best of several
starts. Starts are the numbers of the bench, those that are given, such as gains by rules, and some
scattered around the best of them. Between its switchings a loop is smooth, over them it jumps a
little: where a search ends on such an edge, a cloud of points around it is tried and the best gone
on from. In a loop that swings by itself derivatives grow from swing to swing: they are shortened
to what can be. What acts through a switch alone, such as the band of an ON/OFF controller, has no
derivative; then scattered starts and clouds are all that searches.

Without a compiler the method is that of Nelder and Mead, without derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.errors import SolveError
from martensite.design.tuning.goals import Cost, Numbers
from martensite.design.tuning.loop_runs import LoopRuns, Seen
from martensite.design.tuning.plant_spread import Plants
from martensite.search.free_numbers import FreeNumber

Tell = Callable[[str, float], None]
FAILED_COST = 1e3
"""Cost of a plant whose run fails: far above that of any loop that works."""
STEEPEST_SLOPE = 100.0
"""Steepest slope of a plant that is believed, in costs per unit of a logarithm."""
CLOUD_POINTS, CLOUD_SPREAD, START_SPREAD = 16, 0.15, 1.0
"""Points of a cloud around an end, their spread and that of starts, in logarithms."""


@dataclass(frozen=True)
class TuningSearch:
    """How parameters are searched."""

    scattered: int = 16
    """Starts scattered around the best one that is given."""
    searches: int = 2
    """Starts that are gone on from: the best."""
    iterations: int = 40
    """Of each search."""
    clouds: int = 2
    """How often the neighbourhood of the best end is tried."""
    slopes: int = 16
    """Plants on which a search follows derivatives: the first of those drawn. Where searches begin
    and which end is best is judged on all of them."""
    seed: int = 0


class GainHunt:
    """The search of one tuning: it counts its runs."""

    def __init__(
        self,
        runs: LoopRuns,
        cost: Cost,
        free: Sequence[FreeNumber],
        plants: Plants | None,
        search: TuningSearch,
        watch: Tell | None,
    ) -> None:
        self.runs, self.cost, self.free = runs, cost, free
        self.search, self.watch = search, watch
        self.drawn: Mapping[str, Any] = plants.values if plants else {}
        self.count = plants.count if plants else 1
        self.evaluations = self.gradients = 0
        self.width = np.array([one.width for one in free])
        """Searches run over places z = width · share, so that a step is one of a logarithm."""
        self.moving = [one.path for one in free]
        self.followed = min(max(search.slopes, 1), self.count)

    def best(
        self, starts: Sequence[Mapping[str, float]]
    ) -> tuple[float, Numbers, tuple[float, ...]]:
        """Least cost, where it is (the first start if none is less), and where searches ended."""
        rng = np.random.default_rng(self.search.seed)
        begun = self._choose_starts(starts, rng)
        total = len(begun) + self.search.clouds
        ends = [self._descend(z, k, total) for k, (_, z) in enumerate(begun)]
        for k in range(self.search.clouds):
            least, z = min(ends, key=lambda end: end[0])
            cloud = self._scatter_points(z, CLOUD_POINTS, CLOUD_SPREAD, rng)
            costs = self.values(cloud)
            if costs.min() >= least:
                break
            ends.append(self._descend(cloud[int(costs.argmin())], len(begun) + k, total))
        own = self.place(starts[0])
        kept = float(self.values(own[None, :])[0]), own
        least, z = min([kept, *ends], key=lambda end: end[0])
        return least, z, tuple(sorted(end[0] for end in ends))

    def _choose_starts(
        self, starts: Sequence[Mapping[str, float]], rng: np.random.Generator
    ) -> list[tuple[float, Numbers]]:
        """Starts that are gone on from, best first.

        Raises:
            SolveError: none can be run.
        """
        places = np.array([self.place(start) for start in starts])
        costs = self.values(places)
        if not (costs < FAILED_COST).any():
            raise SolveError(f"None of {len(starts)} starts of the tuning can be run.")
        more = self._scatter_points(
            places[int(costs.argmin())], self.search.scattered, START_SPREAD, rng
        )
        places = np.concatenate([places, more])
        costs = np.concatenate([costs, self.values(more)])
        order = np.argsort(costs, kind="stable")[: max(self.search.searches, 1)]
        return [(float(costs[k]), places[k]) for k in order]

    def _scatter_points(
        self, z: Numbers, count: int, wide: float, rng: np.random.Generator
    ) -> Numbers:
        """Points around one; linear numbers are moved by shares of their range."""
        scale = np.where([one.logarithmic for one in self.free], 1.0, 0.2 * self.width)
        moved = z + wide * scale * rng.standard_normal((count, len(self.free)))
        return np.clip(moved, 0.0, self.width)

    def table(self, values: Mapping[str, float]) -> float:
        """Cost of numbers by path."""
        numbers = {path: [value] for path, value in values.items()}
        return float(self._costs(numbers, 1)[0])

    def numbers(self, places: Numbers) -> dict[str, Numbers]:
        """Free numbers by path at places, shape (..., free)."""
        shares = places / self.width
        return {one.path: one.value(shares[..., k]) for k, one in enumerate(self.free)}

    def place(self, values: Mapping[str, float]) -> Numbers:
        """The nearest place of numbers by path."""
        return self.width * np.array([one.share(values[one.path]) for one in self.free])

    def values(self, places: Numbers) -> Numbers:
        """Costs of points, shape (points, free) -> (points,)."""
        if not len(places):
            return np.zeros(0)
        return self._costs(self.numbers(places), len(places))

    def _costs(self, numbers: Mapping[str, Any], points: int) -> Numbers:
        """Costs of points on all plants, run together."""
        spread = {path: np.repeat(column, self.count) for path, column in numbers.items()}
        drawn = {path: np.tile(column, points) for path, column in self.drawn.items()}
        seen = self.runs.run(self.runs.table({**drawn, **spread}, points * self.count))
        self.evaluations += points * self.count
        costs = np.minimum(self.cost(seen), FAILED_COST).reshape(points, self.count)
        return np.array([self.cost.goal.over_plants(row)[0] for row in costs])

    def gradient(self, z: Numbers) -> tuple[float, Numbers]:
        """Cost at a point and its derivatives, over the plants that are followed."""
        drawn = {path: column[: self.followed] for path, column in self.drawn.items()}
        table = self.runs.table({**drawn, **self.numbers(z)}, self.followed)
        costs, slopes = np.zeros(len(table)), np.zeros((len(table), len(z)))
        shares = (z / self.width).tolist()
        inner = np.array([one.slope(u) for one, u in zip(self.free, shares, strict=True)])
        inner /= self.width
        for k, row in enumerate(table):
            found = self.runs.slopes(row, self.moving)
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
        return least, weights @ slopes

    def _descend(self, begin: Numbers, k: int, total: int) -> tuple[float, Numbers]:
        """One search from a point."""
        self.tell(f"search {k + 1}", k, total)
        optimize = import_module("scipy.optimize")
        bounds = [(0.0, width) for width in self.width]
        steps = 0

        def told(_: Any) -> None:
            nonlocal steps
            steps += 1
            self.tell(f"search {k + 1}", k + steps / self.search.iterations, total)

        if self.runs.native:
            found = optimize.minimize(
                self.gradient,
                begin,
                jac=True,
                method="L-BFGS-B",
                bounds=bounds,
                callback=told,
                options={"maxiter": self.search.iterations, "ftol": 1e-6, "maxls": 12},
            )
        else:
            found = optimize.minimize(
                lambda z: float(self.values(z[None, :])[0]),
                begin,
                method="Nelder-Mead",
                bounds=bounds,
                callback=told,
                options={"maxiter": self.search.iterations, "xatol": 1e-2, "fatol": 1e-6},
            )
        end = np.asarray(found.x)
        return float(self.values(end[None, :])[0]), end

    def tell(self, text: str, done: float, total: int) -> None:
        """Say how far it is."""
        if self.watch is not None:
            self.watch(text, min(done / max(total, 1), 1.0))
