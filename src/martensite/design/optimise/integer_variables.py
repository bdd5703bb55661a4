"""Whole numbers, such as the count of wires: relaxed first, then rounded, then neighbours.

The search runs as if they could be anything. Then the whole numbers on both sides of what it
found are held, one combination after another, and the other numbers are searched anew from there;
from the best combination neighbours are tried, one up and one down, until none is better.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.search.box_search import BoxPoint, BoxSearch
from martensite.search.free_numbers import FreeNumber

Combination: TypeAlias = tuple[int, ...]
Tried: TypeAlias = dict[Combination, BoxPoint]
"""The best design with some whole numbers."""
MOST_COMBINATIONS = 64
"""Combinations that are tried."""
ROUNDS = 3
"""How often the relaxed design is searched anew."""


def round_design(hunt: BoxSearch, free: Sequence[FreeNumber], relaxed: BoxPoint) -> tuple[BoxPoint, Tried, BoxPoint]:
    """The best design whose whole numbers are whole, all that were tried, and the best relaxed one.

    A whole design that is better than the relaxed one shows that this was not the best: it is
    searched anew from there.

    Args:
        hunt: the search, which goes on counting.
        free: numbers of a design.
        relaxed: the best design found if they could be anything.
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
    """Try what lies around the relaxed design, then neighbours of the best, one up or down."""
    counted = [one for one in free if one.whole]
    values = [one.value(float(u)) for one, u in zip(counted, relaxed.z[whole], strict=True)]
    sides = [
        sorted({max(math.floor(v + 1e-9), one.low), min(math.ceil(v - 1e-9), one.high)})
        for v, one in zip(values, counted, strict=True)
    ]
    waiting = [tuple(int(n) for n in row) for row in itertools.product(*sides)]
    begin = relaxed.z
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
        waiting = [
            (*best[:i], best[i] + step, *best[i + 1 :])
            for i, one in enumerate(counted)
            for step in (-1, 1)
            if one.low <= best[i] + step <= one.high
        ]
        waiting = [numbers for numbers in waiting if numbers not in tried]


def _choose_best(tried: Tried) -> Combination:
    found = next(iter(tried))
    for numbers, point in tried.items():
        found = numbers if point.is_better_than(tried[found]) else found
    return found


def _search_from(hunt: BoxSearch, z: NDArray[np.float64], fixed: NDArray[np.bool_]) -> BoxPoint:
    """The best design from a point, whatever was found before."""
    hunt.best = None
    hunt.judge(z[None])
    hunt.descend(z, fixed)
    hunt.look_around(fixed)
    return hunt.found
