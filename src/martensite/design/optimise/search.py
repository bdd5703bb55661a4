"""Search for the best design: a sample of the box, then descents from its best points.

A Sobol sample is judged in one batch. Descents start from its best points, which lie apart, and from the design of the
scenario (`martensite.search.box_search`). Derivatives are 0 where a wire does not transform, so no descent leaves such
a region. The sample grows until one of its points keeps all constraints.

Whole numbers, such as the count of wires, are continuous at first. Then each combination of the neighbouring whole
numbers is fixed, and the other parameters are searched again. From the best combination neighbours are tried, one up
and one down, until none is better.

A grid of n points over each of k parameters needs n^k runs, a search some hundreds. The grid serves to check a search.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError, SolveError
from martensite.design.optimise.evaluate import DesignEvaluator, Numbers, RunCounts
from martensite.design.optimise.question import DesignQuestion
from martensite.search.box_search import FAILED_GOAL, BoxPoint, BoxSearch, JudgedPoints, Tell
from martensite.search.free_numbers import FreeNumber
from martensite.search.starts import choose_apart, start_sobol

BATCH = 1024
"""Designs of a grid that are judged together."""
MOST_DESIGNS = 1_000_000
"""Designs of the largest grid."""


@dataclass(frozen=True)
class DesignSearch:
    """Options of the search for designs."""

    sample: int = 64
    """Points of the sample, a power of 2."""
    more: int = 3
    """Largest number of doublings of the sample while none of its points keeps all constraints."""
    descents: int = 3
    """Points of the sample that start a descent."""
    iterations: int = 50
    """Iterations of each descent, and half of its maximum number of runs with derivatives."""
    clouds: int = 2
    """Searches of the neighbourhood of the best design."""
    seed: int = 0


Keep = Callable[[DesignQuestion, Sequence[float], bool], None]
"""Receives the question, the free parameters [SI] of a better design, and true if it keeps all constraints."""


def start_search(
    designs: DesignEvaluator, search: DesignSearch, watch: Tell | None = None, keep: Keep | None = None
) -> BoxSearch:
    """Return a search that has judged no design."""
    hunt = BoxSearch(designs, iterations=search.iterations, clouds=search.clouds, seed=search.seed, watch=watch)
    best: list[BoxPoint] = []

    def keep_better(point: BoxPoint) -> None:
        """Pass on a point that is better than the last one; a rounded design may be worse."""
        if keep is not None and not (best and best[-1].is_better_than(point)):
            best.append(point)
            keep(designs.question, designs.numbers(point.z).tolist(), point.feasible)

    hunt.keep = keep_better
    return hunt


def search_designs(
    designs: DesignEvaluator, begin: Numbers, search: DesignSearch, watch: Tell | None = None, keep: Keep | None = None
) -> BoxSearch:
    """Search the box from a sample and one design; `SolveError` if no run of the sample succeeds."""
    hunt = start_search(designs, search, watch, keep)
    starts = _choose_starts(_sample_box(hunt, designs, begin, search), search.descents)
    for k, start in enumerate(starts):
        hunt.tell(f"descent {k + 1} of {len(starts)}", 0.1 + 0.6 * k / len(starts))
        hunt.descend(start.z)
    hunt.tell("looking around", 0.7)
    hunt.look_around()
    return hunt


def _sample_box(hunt: BoxSearch, designs: DesignEvaluator, begin: Numbers, search: DesignSearch) -> list[BoxPoint]:
    """Return the scenario and a sample, enlarged until one of its points keeps all constraints."""
    sobol = start_sobol(hunt.size, search.seed)
    hunt.tell("sampling", 0.0)
    first = np.concatenate([begin[None], sobol.random(search.sample)])
    values = designs.values(first)
    designs.set_size(values)
    points = hunt.note_points(first, designs.judge_values(values))
    for k in range(search.more):
        if any(point.feasible for point in points):
            break
        hunt.tell("sampling more", 0.03 * (k + 1))
        points += hunt.judge(sobol.random(len(points) - 1))
    if all(point.goal >= FAILED_GOAL for point in points):
        raise SolveError(
            f"None of {len(points)} designs in the box can be run and judged; narrow the "
            "bounds, or try the scenario by itself."
        )
    return points


def _choose_starts(points: Sequence[BoxPoint], count: int) -> list[BoxPoint]:
    """Return the design of the scenario and the best points that lie apart."""
    judged = JudgedPoints(np.array([p.goal for p in points]), -np.array([[p.violation] for p in points]))
    places = np.stack([point.z for point in points])
    chosen = [points[k] for k in choose_apart(places, judged.order(), count)]
    own = points[0]
    return chosen if any(one is own for one in chosen) else [*chosen, own]


# ---------------------------------------------------------------- whole numbers


Combination: TypeAlias = tuple[int, ...]
Tried: TypeAlias = dict[Combination, BoxPoint]
"""Best design by whole numbers."""
MOST_COMBINATIONS = 64
"""Largest number of combinations."""
ROUNDS = 3
"""Repetitions of the search of the relaxed design."""


def round_design(hunt: BoxSearch, free: Sequence[FreeNumber], relaxed: BoxPoint) -> tuple[BoxPoint, Tried, BoxPoint]:
    """Return the best design with whole numbers, all tried ones, and the best relaxed design.

    A whole design that is better than the relaxed one starts another search.
    """
    whole = np.array([one.whole for one in free])
    tried: Tried = {}
    if not whole.any():
        return relaxed, tried, relaxed
    for _ in range(ROUNDS):
        _walk_neighbours(hunt, free, relaxed, whole, tried)
        best = tried[_choose_best(tried)]
        if not best.is_better_than(relaxed):
            break
        relaxed = _search_from(hunt, best.z, np.zeros(hunt.size, np.bool_))
    return tried[_choose_best(tried)], dict(sorted(tried.items())), relaxed


def _walk_neighbours(
    hunt: BoxSearch, free: Sequence[FreeNumber], relaxed: BoxPoint, whole: NDArray[np.bool_], tried: Tried
) -> None:
    """Try the neighbours of the relaxed design, then of the best, one up or down."""
    counted = [one for one in free if one.whole]
    values = [one.value(float(u)) for one, u in zip(counted, relaxed.z[whole], strict=True)]
    waiting, begin = _list_corners(values, counted), relaxed.z
    while waiting and len(tried) < MOST_COMBINATIONS:
        for numbers in waiting:
            hunt.tell(f"whole numbers: {', '.join(map(str, numbers))}", 0.85)
            z = begin.copy()
            z[whole] = [one.share(float(n)) for one, n in zip(counted, numbers, strict=True)]
            point = _search_from(hunt, z, whole)
            if numbers not in tried or point.is_better_than(tried[numbers]):
                tried[numbers] = point
        best = _choose_best(tried)
        begin = tried[best].z
        waiting = [numbers for numbers in _list_neighbours(best, counted) if numbers not in tried]


def _list_corners(values: Sequence[float], counted: Sequence[FreeNumber]) -> list[Combination]:
    """Return the combinations of whole numbers on both sides of values."""
    sides = [
        sorted({max(math.floor(v + 1e-9), one.low), min(math.ceil(v - 1e-9), one.high)})
        for v, one in zip(values, counted, strict=True)
    ]
    return [tuple(int(n) for n in row) for row in itertools.product(*sides)]


def _list_neighbours(best: Combination, counted: Sequence[FreeNumber]) -> list[Combination]:
    """Return the combinations with one number up or down."""
    return [
        (*best[:i], best[i] + step, *best[i + 1 :])
        for i, one in enumerate(counted)
        for step in (-1, 1)
        if one.low <= best[i] + step <= one.high
    ]


def _choose_best(tried: Tried) -> Combination:
    best = next(iter(tried))
    for numbers, point in tried.items():
        best = numbers if point.is_better_than(tried[best]) else best
    return best


def _search_from(hunt: BoxSearch, z: NDArray[np.float64], fixed: NDArray[np.bool_]) -> BoxPoint:
    """Return the best design from a point, regardless of earlier results."""
    hunt.best = None
    hunt.judge(z[None])
    hunt.descend(z, fixed)
    hunt.look_around(fixed)
    return hunt.best_point


# ---------------------------------------------------------------- brute force beside it


@dataclass(frozen=True)
class DesignScan:
    """Designs of a grid."""

    z: Numbers
    """(designs, free)"""
    judged: JudgedPoints
    shape: tuple[int, ...]
    best: int | None
    """Design with the best goal that keeps all constraints, or None."""
    numbers: tuple[float, ...]
    """Free parameters of the best design [SI], or of the smallest violation."""
    values: tuple[float, ...]
    """Mean of the aims over the cases [SI]."""

    def cells(self, z: Numbers) -> tuple[float, ...]:
        """Return the distance of a design from the best grid point, in cells of the grid."""
        place = self.z[self.judged.order()[0]]
        wide = [1.0 / max(n - 1, 1) for n in self.shape]
        return tuple(float(abs(a - b)) / w for a, b, w in zip(z, place, wide, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "simulations": len(self.z),
            "shape": list(self.shape),
            "feasible": int(self.judged.feasible.sum()),
            "numbers": list(self.numbers),
            "values": list(self.values),
        }


def scan_designs(
    designs: DesignEvaluator, points: int | Sequence[int], watch: Callable[[float], None] | None = None
) -> DesignScan:
    """Judge all designs of a grid, evenly spaced on the scale of each free parameter.

    Args:
        designs: evaluator of the designs.
        points: number of points along each free parameter; a whole number has no more points than values.
        watch: called with the finished fraction.

    Raises:
        ParameterError: there are too many points, or fewer than two along a parameter.
    """
    free = designs.question.free
    counts = [points] * len(free) if isinstance(points, int) else list(points)
    axes = [_space_axis(designs, k, count) for k, count in enumerate(counts)]
    shape = tuple(len(axis) for axis in axes)
    if min(counts) < 2 or int(np.prod(shape)) > MOST_DESIGNS:
        raise ParameterError(
            f"A grid must have at least 2 points along each number and {MOST_DESIGNS:,} in all, "
            f"but has {' x '.join(map(str, counts))}."
        )
    z = np.array(list(itertools.product(*axes)))
    values = _evaluate_grid(designs, z, watch)
    judged = designs.judge_values(values)
    first = judged.order()[0]
    return DesignScan(
        z,
        judged,
        shape,
        first if judged.feasible[first] else None,
        tuple(designs.numbers(z[first]).tolist()),
        tuple(values[first].mean(axis=0).tolist()),
    )


def _evaluate_grid(designs: DesignEvaluator, z: Numbers, watch: Callable[[float], None] | None) -> Numbers:
    """Return the values of all designs, without counting the runs."""
    counts, designs.counts = designs.counts, RunCounts()
    values: list[Numbers] = []
    try:
        for k in range(0, len(z), BATCH):
            values.append(designs.values(z[k : k + BATCH]))
            if watch is not None:
                watch(min(k + BATCH, len(z)) / len(z))
    finally:
        designs.counts = counts
    return np.concatenate(values)


def _space_axis(designs: DesignEvaluator, k: int, count: int) -> Numbers:
    """Return the places of the points along a free parameter."""
    one = designs.question.free[k]
    if not one.whole:
        return np.linspace(0.0, 1.0, count)
    whole = np.unique(np.round(np.linspace(one.low, one.high, count)))
    return np.array([one.share(float(number)) for number in whole])
