"""A sweep in a few numbers, read in stretches: memory does not grow with the number of runs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from martensite.base.status import Status
from martensite.design.sweep.store import STATUS, STRETCH, Store

BINS = 1024
NARROWINGS = 6
"""How often the interval of a median is divided by as many bins; then it is a point."""


def count_statuses(store: Store, named: int) -> tuple[Counter[int], dict[int, list[int]]]:
    """Number of runs by status, and the first few runs of each that is not OK."""
    counts, rows = Counter[int](), dict[int, list[int]]()
    for stretch, there in store.stretches():
        found = np.where(there, store.group[STATUS][stretch], -1)
        for status in Status:
            places = np.flatnonzero(found == status)
            counts[status] += len(places)
            if status is not Status.OK and len(places):
                known = rows.setdefault(status, [])
                known += (places[: named - len(known)] + stretch.start).tolist()
    return counts, rows


def count_above(store: Store, column: str, bound: float) -> int:
    """How many numbers of a column are above a bound."""
    stretches = store.stretches()
    return sum(int(np.sum(store.group[column][place][there] > bound)) for place, there in stretches)


def compute_spread(store: Store, column: str, most: int = STRETCH) -> tuple[float, float, float]:
    """Lowest, median and highest of the finite numbers of a column; NaN where there is none.

    Args:
        store: the sweep.
        column: words of a measure.
        most: how many numbers are held at a time to find the median.
    """
    count, low, high = 0, math.inf, -math.inf
    for found in _read_finite(store, column):
        count, low = count + len(found), min(low, float(found.min()))
        high = max(high, float(found.max()))
    if not count:
        return math.nan, math.nan, math.nan
    return low, _find_median(store, column, count, low, high, most), high


def _find_median(
    store: Store, column: str, count: int, low: float, high: float, most: int
) -> float:
    """The mean of the two numbers in the middle: their interval is narrowed until they fit."""
    ranks, inside = [(count - 1) // 2, count // 2], count
    for _ in range(NARROWINGS):
        if inside <= most:
            break
        edges = np.linspace(low, high, BINS + 1)
        bins = np.zeros(BINS, np.int64)
        for found in _read_finite(store, column):
            bins += np.histogram(found, edges)[0]
        above = np.cumsum(bins)
        first, last = (int(np.searchsorted(above, rank, side="right")) for rank in ranks)
        before = int(above[first] - bins[first])
        ranks = [rank - before for rank in ranks]
        low, high = float(edges[first]), float(edges[last + 1])
        inside = int(above[last]) - before
    else:
        return 0.5 * (low + high)
    pieces = [found[(found >= low) & (found <= high)] for found in _read_finite(store, column)]
    return _find_middle(np.sort(np.concatenate(pieces)), ranks)


def _find_middle(sorted_numbers: np.ndarray, ranks: list[int]) -> float:
    return float(0.5 * (sorted_numbers[ranks[0]] + sorted_numbers[ranks[1]]))


def _read_finite(store: Store, column: str) -> Iterator[np.ndarray]:
    """Finite numbers of a column, by stretches that have any."""
    for stretch, there in store.stretches():
        found = store.group[column][stretch][there]
        found = found[np.isfinite(found)]
        if len(found):
            yield found
