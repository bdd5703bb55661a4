"""Start points of a descent: the best of many points in the box, or a rough global search.

Points form a scrambled Sobol' sequence (Owen (1998); SciPy), which covers the box evenly. Distant starts may lead to
different minima. Differential evolution (Storn and Price (1997), Journal of Global Optimization 11) suits a box with
few good points. All values are fractions of a range. Costs are computed in batches, (points, parameters) -> (points,).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError, SolveError

Numbers: TypeAlias = NDArray[np.float64]
Costs: TypeAlias = Callable[[Numbers], Numbers]
"""Function from points (points, parameters) to costs (points,); infinite or NaN for failed runs."""
START_DISTANCE = 0.2
"""Least distance of two starts, as a fraction of the diagonal of the box."""


@dataclass(frozen=True)
class Start:
    """Start point."""

    values: tuple[float, ...]
    cost: float


def start_sobol(size: int, seed: int = 0) -> Any:
    """Return a sequence of points in `size` dimensions, whose `random(n)` returns the next n points, (n, size)."""
    return import_module("scipy.stats.qmc").Sobol(size, seed=seed)


def draw_points(size: int, count: int, seed: int = 0) -> Numbers:
    """Return the points spread evenly over the box, (count, size); `ParameterError` for no points."""
    if count < 1:
        raise ParameterError(f"Argument `count` must be at least 1, but is {count}.")
    points = start_sobol(size, seed).random_base2(math.ceil(math.log2(count)))
    return np.asarray(points[:count], np.float64)


def choose_apart(points: Numbers, order: Iterable[int], keep: int, apart: float = START_DISTANCE) -> list[int]:
    """Return the first points (points, size) of an order, best first, that keep a distance from earlier points.

    The least distance is a fraction of the diagonal of the box.
    """
    least, chosen = apart * math.sqrt(points.shape[1]), list[int]()
    for k in order:
        if len(chosen) == keep:
            break
        if all(np.linalg.norm(points[k] - points[i]) >= least for i in chosen):
            chosen.append(k)
    return chosen


def find_starts(
    costs: Costs, size: int, *, count: int = 64, keep: int = 4, apart: float = START_DISTANCE, seed: int = 0
) -> tuple[Start, ...]:
    """Return the starts for descents, best first; fewer if the distance allows no more.

    A power of 2 is the best number of trial points. The least distance of two starts is a fraction of the diagonal of
    the box.

    Raises:
        ParameterError: no point is requested.
        SolveError: no point has a finite cost.
    """
    points = draw_points(size, count, seed)
    values = np.asarray(costs(points), np.float64)
    order = [k for k in np.argsort(values, kind="stable").tolist() if math.isfinite(values[k])]
    if not order:
        raise SolveError(f"None of {count} points within the bounds could be simulated; narrow the bounds.")
    chosen = choose_apart(points, order, keep, apart)
    return tuple(Start(tuple(points[k].tolist()), float(values[k])) for k in chosen)


def evolve_start(costs: Costs, size: int, *, generations: int = 20, population: int = 8, seed: int = 0) -> Start:
    """Return the best point of differential evolution, to be refined by a descent.

    `population` counts points per parameter; it is renewed at most `generations` times.

    Raises:
        SolveError: no point has a finite cost.
    """

    def batch(columns: Numbers) -> Numbers:
        values = np.asarray(costs(np.atleast_2d(columns.T)), np.float64)
        return np.where(np.isnan(values), math.inf, values)

    solution = import_module("scipy.optimize").differential_evolution(
        batch,
        [(0.0, 1.0)] * size,
        maxiter=generations,
        popsize=population,
        seed=seed,
        polish=False,
        vectorized=True,
        updating="deferred",
    )
    if not math.isfinite(float(solution.fun)):
        raise SolveError("No point within the bounds could be simulated; narrow the bounds.")
    return Start(tuple(solution.x.tolist()), float(solution.fun))
