"""Pareto fronts: the non-dominated runs of a sweep.

A run dominates another if it is at least as good in every goal and better in one. Equal runs do not dominate each
other. Two goals need a sort; more goals are compared by blocks, the most promising first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, ParameterError
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.signals.sampling.sampled import Numbers

Places: TypeAlias = NDArray[np.int64]
BLOCK = 256
FIRST = 64
"""Rows of the set that are compared first, since they dominate most others."""


@dataclass(frozen=True, eq=False)
class ParetoFront:
    """Non-dominated runs."""

    goals: tuple[SweepColumn, ...]
    most: tuple[bool, ...]
    """True for a goal to maximise."""
    runs: Places
    """Numbers of the runs in the sweep, the best in the first goal first."""
    compared: int
    """Number of compared runs."""

    def columns(self, table: SweepTable) -> dict[str, SweepColumn]:
        """Return the varied parameters and goals by name."""
        return {**table.varied, **{one.name: one for one in self.goals}}


def find_pareto_front(table: SweepTable, minimise: Sequence[str] = (), maximise: Sequence[str] = ()) -> ParetoFront:
    """Return the non-dominated runs of a sweep.

    Args:
        table: runs of the sweep.
        minimise: measures or varied parameters to minimise.
        maximise: measures or varied parameters to maximise.

    Raises:
        UnknownNameError: the measure or parameter does not exist.
        ParameterError: there is no goal, or one twice.
        DataError: no run has all goals.
    """
    goals = tuple(table.column(name) for name in (*minimise, *maximise))
    names = [one.name for one in goals]
    if not goals:
        raise ParameterError("A front needs goals. Add --minimise or --maximise.")
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice:
        raise ParameterError(f"`{twice}` is a goal twice.")
    most = (False,) * len(minimise) + (True,) * len(maximise)
    values = np.stack([-g.values if m else g.values for g, m in zip(goals, most, strict=True)], 1)
    rows = np.flatnonzero(table.good & np.isfinite(values).all(axis=1))
    if not len(rows):
        raise DataError("There is no run that has all goals.")
    best = rows[find_unbeaten(values[rows])]
    order = np.lexsort(values[best].T[::-1])
    return ParetoFront(goals, most, best[order], len(rows))


def find_unbeaten(values: Numbers) -> Places:
    """Return the places of the non-dominated rows, rising.

    Args:
        values: (rows, goals), finite; small is good.
    """
    ranks = np.stack([np.unique(one, return_inverse=True)[1] for one in values.T], axis=1)
    if ranks.shape[1] == 1:
        return np.flatnonzero(ranks[:, 0] == 0)
    if ranks.shape[1] == 2:
        return _find_of_two(ranks)
    return _find_of_many(ranks)


def _find_of_two(ranks: Places) -> Places:
    """Return the rows with less of the second goal than all rows with less of the first."""
    order = np.lexsort((ranks[:, 1], ranks[:, 0]))
    a, b = ranks[order].T
    best = np.minimum.accumulate(b)
    starts = np.r_[True, a[1:] != a[:-1]]
    start = np.maximum.accumulate(np.where(starts, np.arange(len(a)), 0))
    before = np.where(start > 0, best[start - 1], b.max() + 1)
    return np.sort(order[(b == b[start]) & (b < before)])


def _find_of_many(ranks: Places) -> Places:
    """Return the non-dominated rows; only a row with a smaller sum of ranks can dominate."""
    order = np.argsort(ranks.sum(axis=1), kind="stable")
    ordered = np.ascontiguousarray(ranks[order].astype(np.int32))
    front = np.empty(0, np.int64)
    for begin in range(0, len(ordered), BLOCK):
        rows = np.arange(begin, min(begin + BLOCK, len(ordered)))
        for some in (front[:FIRST], front[FIRST:], rows):
            rows = rows[~_mark_beaten(ordered[rows], ordered[some])]
        front = np.concatenate((front, rows))
    return np.sort(order[front])


def _mark_beaten(rows: NDArray[np.int32], by: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return true for each row that one of the others dominates."""
    if not (len(rows) and len(by)):
        return np.zeros(len(rows), bool)
    as_good = np.ones((len(rows), len(by)), bool)
    better = np.zeros((len(rows), len(by)), bool)
    for mine, theirs in zip(rows.T, by.T, strict=True):
        as_good &= theirs <= mine[:, None]
        better |= theirs < mine[:, None]
    return np.any(as_good & better, axis=1)
