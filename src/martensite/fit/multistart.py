"""Where to start a fit: the best of many points spread over the bounds, or a rough global search.

Points are of a scrambled Sobol' sequence (Owen (1998); SciPy), which leaves no large part of the
bounds without one. `multistart` keeps the best of them that are some distance apart, so that
local fits from them do not all find the same minimum. `evolve` is differential evolution (Storn
and Price (1997), Journal of Global Optimization 11), as a start where hardly any point is good.
Costs are asked for in batches, (points, parameters) -> (points,): many runs at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from martensite.base.errors import ParameterError, SolveError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]

Costs = Callable[[Any], Any]
"""Costs (points,) of points (points, parameters); infinite or NaN where a run fails."""
POINTS, STARTS, APART = 64, 4, 0.2
SEED = 0


@dataclass(frozen=True)
class Start:
    """A point to start a fit from."""

    values: tuple[float, ...]
    cost: float

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Evolved:
    """The best point of a rough global search."""

    values: tuple[float, ...]
    cost: float
    evaluations: int
    history: tuple[tuple[int, float], ...]
    """(evaluations, cost) at each improvement."""
    interrupted: bool

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


def sobol_points(
    low: Sequence[float], high: Sequence[float], count: int = POINTS, seed: int = SEED
) -> Matrix:
    """Points spread evenly over the bounds, (count, parameters).

    Raises:
        ParameterError: bounds are not in order, or no point is asked for.
    """
    import numpy as np

    bottom, top = _bounds(low, high)
    if count < 1:
        raise ParameterError(f"Argument `count` must be at least 1, but is {count}.")
    qmc: Any = import_module("scipy.stats.qmc")
    unit = qmc.Sobol(len(bottom), seed=seed).random_base2(math.ceil(math.log2(count)))
    return np.asarray(bottom + (top - bottom) * unit[:count], np.float64)


def multistart(
    costs: Costs,
    low: Sequence[float],
    high: Sequence[float],
    *,
    count: int = POINTS,
    keep: int = STARTS,
    apart: float = APART,
    seed: int = SEED,
) -> tuple[Start, ...]:
    """Starts for local fits, the best first; fewer than asked for if others are too near.

    Args:
        costs: of points.
        low: lower bounds.
        high: upper bounds.
        count: points tried; a power of 2 spreads best.
        keep: starts wanted.
        apart: least distance of two starts: in some parameter, as a share of its range.
        seed: of the points.

    Raises:
        ParameterError: bounds are not in order, or no point is asked for.
        SolveError: no point has a finite cost.
    """
    import numpy as np

    points = sobol_points(low, high, count, seed)
    bottom, top = _bounds(low, high)
    values = np.asarray(costs(points), np.float64)
    kept: list[int] = []
    for i in np.argsort(values, kind="stable").tolist():
        gaps = [np.max(np.abs(points[i] - points[k]) / (top - bottom)) for k in kept]
        if len(kept) < keep and math.isfinite(values[i]) and all(gap >= apart for gap in gaps):
            kept.append(i)
    if not kept:
        raise SolveError(
            f"None of {count} points within the bounds could be run; narrow the bounds."
        )
    return tuple(Start(tuple(points[i].tolist()), float(values[i])) for i in kept)


def evolve(
    costs: Costs,
    low: Sequence[float],
    high: Sequence[float],
    *,
    generations: int = 20,
    population: int = 8,
    seed: int = SEED,
    progress: Callable[[tuple[float, ...], float, int], None] | None = None,
) -> Evolved:
    """Differential evolution over the bounds, not polished: follow it with a local fit.

    A KeyboardInterrupt, from the keyboard or from `progress`, ends it and keeps the best.

    Args:
        costs: of points.
        low: lower bounds.
        high: upper bounds.
        generations: how often the population is renewed, at most.
        population: points for each parameter.
        seed: of all chance.
        progress: called after each batch with the best point, its cost and the evaluations.

    Raises:
        ParameterError: bounds are not in order.
        SolveError: no point has a finite cost.
    """
    import numpy as np

    bottom, top = _bounds(low, high)
    best, history, count = Start((), math.inf), list[tuple[int, float]](), 0

    def batch(columns: Vector) -> Vector:
        nonlocal best, count
        points = np.atleast_2d(columns.T)
        values = np.asarray(costs(points), np.float64)
        values = np.where(np.isnan(values), math.inf, values)
        count += len(points)
        least = int(np.argmin(values))
        if values[least] < best.cost:
            best = Start(tuple(points[least].tolist()), float(values[least]))
            history.append((count, best.cost))
        if progress is not None:
            progress(best.values, best.cost, count)
        return values

    interrupted = False
    try:
        import_module("scipy.optimize").differential_evolution(
            batch, list(zip(bottom, top, strict=True)), maxiter=generations, popsize=population,
            seed=seed, polish=False, vectorized=True, updating="deferred",
        )  # fmt: skip
    except KeyboardInterrupt:
        interrupted = True
    if not best.values:
        raise SolveError("No point within the bounds could be run; narrow the bounds.")
    return Evolved(best.values, best.cost, count, tuple(history), interrupted)


def _bounds(low: Sequence[float], high: Sequence[float]) -> tuple[Vector, Vector]:
    import numpy as np

    bottom, top = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if not 0 < bottom.size == top.size:
        raise ParameterError(
            f"Bounds must be equally many, at least one, but are {bottom.size} and {top.size}."
        )
    if not (np.isfinite([bottom, top]).all() and (bottom < top).all()):
        raise ParameterError("Lower bounds must be below upper bounds, and all finite.")
    return bottom, top
