"""Start points of a descent: the best of many points spread over the box, or a rough global search.

Points are of a scrambled Sobol' sequence (Owen (1998); SciPy), which leaves no large part of the
box without one. Starts that lie apart do not all lead to the same minimum. Differential evolution
(Storn and Price (1997), Journal of Global Optimization 11) is a start where hardly any point is
good. All numbers are shares of a range, from 0 to 1; costs are asked for in batches, (points,
numbers) -> (points,): many runs at once.
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
"""Costs (points,) of points (points, numbers); infinite or NaN where a run fails."""
START_DISTANCE = 0.2
"""Least distance of two starts, as a share of the diagonal of the box."""


@dataclass(frozen=True)
class Start:
    """A point to start from."""

    values: tuple[float, ...]
    cost: float


def start_sobol(size: int, seed: int = 0) -> Any:
    """Return a sequence of points in `size` numbers; its `random(n)` gives the next n, (n, size)."""
    return import_module("scipy.stats.qmc").Sobol(size, seed=seed)


def draw_points(size: int, count: int, seed: int = 0) -> Numbers:
    """Return the points spread evenly over the box, (count, size); `ParameterError` if no point is asked for."""
    if count < 1:
        raise ParameterError(f"Argument `count` must be at least 1, but is {count}.")
    points = start_sobol(size, seed).random_base2(math.ceil(math.log2(count)))
    return np.asarray(points[:count], np.float64)


def choose_apart(points: Numbers, order: Iterable[int], keep: int, apart: float = START_DISTANCE) -> list[int]:
    """Return the first points (points, size) of an order, the best first, that lie apart from those before them.

    The least distance is a share of the diagonal of the box.
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
    """Return the starts for descents, the best first; fewer than asked for if others are too near.

    A count of points tried that is a power of 2 spreads best; the least distance of two starts is a share of the
    diagonal of the box.

    Raises:
        ParameterError: no point is asked for.
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
    """Return the best point of differential evolution, not polished: follow it with a descent.

    The population has so many points for each number, and is renewed `generations` times at most.

    Raises:
        SolveError: no point has a finite cost.
    """

    def batch(columns: Numbers) -> Numbers:
        values = np.asarray(costs(np.atleast_2d(columns.T)), np.float64)
        return np.where(np.isnan(values), math.inf, values)

    found = import_module("scipy.optimize").differential_evolution(
        batch,
        [(0.0, 1.0)] * size,
        maxiter=generations,
        popsize=population,
        seed=seed,
        polish=False,
        vectorized=True,
        updating="deferred",
    )
    if not math.isfinite(float(found.fun)):
        raise SolveError("No point within the bounds could be simulated; narrow the bounds.")
    return Start(tuple(found.x.tolist()), float(found.fun))
