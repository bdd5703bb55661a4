"""Pareto sets: the rows that no other beats.

A row beats another if it is at least as good in every goal and better in one. Equal rows do not
beat each other. Two goals take a sort; more are compared by blocks, the most promising first.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
Places: TypeAlias = NDArray[np.int64]
BLOCK = 256
FIRST = 64
"""Rows of the set that are tried first: they beat most others."""


def find_unbeaten(values: Numbers) -> Places:
    """Places of the rows that no other beats, rising.

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
    """With two goals: whoever has less of the second than all that have less of the first."""
    order = np.lexsort((ranks[:, 1], ranks[:, 0]))
    a, b = ranks[order].T
    best = np.minimum.accumulate(b)
    starts = np.r_[True, a[1:] != a[:-1]]
    start = np.maximum.accumulate(np.where(starts, np.arange(len(a)), 0))
    before = np.where(start > 0, best[start - 1], b.max() + 1)
    return np.sort(order[(b == b[start]) & (b < before)])


def _find_of_many(ranks: Places) -> Places:
    """With more: a row can only be beaten by one of a smaller sum of ranks, so these come first."""
    order = np.argsort(ranks.sum(axis=1), kind="stable")
    ordered = np.ascontiguousarray(ranks[order].astype(np.int32))
    kept = np.empty(0, np.int64)
    for begin in range(0, len(ordered), BLOCK):
        rows = np.arange(begin, min(begin + BLOCK, len(ordered)))
        for some in (kept[:FIRST], kept[FIRST:], rows):
            rows = rows[~_mark_beaten(ordered[rows], ordered[some])]
        kept = np.concatenate((kept, rows))
    return np.sort(order[kept])


def _mark_beaten(rows: NDArray[np.int32], by: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Which rows are beaten by one of others."""
    if not (len(rows) and len(by)):
        return np.zeros(len(rows), bool)
    as_good = np.ones((len(rows), len(by)), bool)
    better = np.zeros((len(rows), len(by)), bool)
    for mine, theirs in zip(rows.T, by.T, strict=True):
        as_good &= theirs <= mine[:, None]
        better |= theirs < mine[:, None]
    return np.any(as_good & better, axis=1)
