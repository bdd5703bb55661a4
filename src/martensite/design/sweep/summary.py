"""A sweep in a few numbers: how runs ended, and the spread of a column."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from martensite.base.status import Status
from martensite.design.sweep.store import STATUS, Store


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


def compute_spread(store: Store, column: str) -> tuple[float, float, float]:
    """Lowest, median and highest of the finite numbers of a column; NaN where there is none."""
    kept = np.concatenate([store.group[column][place][there] for place, there in store.stretches()])
    found = kept[np.isfinite(kept)]
    if not len(found):
        return math.nan, math.nan, math.nan
    return float(found.min()), float(np.median(found)), float(found.max())
