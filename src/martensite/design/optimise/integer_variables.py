"""Whole numbers, such as the count of wires: relaxed first, then rounded, then neighbours.

The search runs as if they could be anything. Then the whole numbers on both sides of what it
found are held, one combination after another, and the other numbers are searched anew from there;
from the best combination neighbours are tried, one up and one down, until none is better.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.design.optimise.search import DesignHunt, DesignPoint

Numbers: TypeAlias = NDArray[np.float64]
Combination = tuple[int, ...]
MOST_COMBINATIONS = 64
"""Combinations that are tried."""
ROUNDS = 3
"""How often the relaxed design is searched anew."""


@dataclass(frozen=True)
class TriedCombination:
    """The best design with some whole numbers."""

    numbers: Combination
    point: DesignPoint


def round_design(
    hunt: DesignHunt, relaxed: DesignPoint
) -> tuple[DesignPoint, list[TriedCombination], DesignPoint]:
    """The best design whose whole numbers are whole, all that were tried, and the best relaxed one.

    A whole design that is better than the relaxed one shows that this was not the best: it is
    searched anew from there.

    Args:
        hunt: the search, which goes on counting.
        relaxed: the best design found if they could be anything.
    """
    places = [k for k, one in enumerate(hunt.designs.question.free) if one.whole]
    if not places:
        return relaxed, [], relaxed
    tried: dict[Combination, TriedCombination] = {}
    for _ in range(ROUNDS):
        _walk_neighbours(hunt, relaxed, places, tried)
        best = _choose_best(tried).point
        if not best.is_better_than(relaxed):
            break
        relaxed = _search_from(hunt, best.z, np.zeros(hunt.size, np.bool_))
    return _choose_best(tried).point, sorted(tried.values(), key=lambda one: one.numbers), relaxed


def _walk_neighbours(
    hunt: DesignHunt,
    relaxed: DesignPoint,
    places: list[int],
    tried: dict[Combination, TriedCombination],
) -> None:
    """Try what lies around the relaxed design, then neighbours of the best."""
    free, values = hunt.designs.question.free, hunt.designs.numbers(relaxed.z)
    sides = [
        sorted({max(math.floor(v + 1e-9), one.low), min(math.ceil(v - 1e-9), one.high)})
        for v, one in ((values[k], free[k]) for k in places)
    ]
    waiting = [tuple(int(n) for n in row) for row in itertools.product(*sides)]
    begin = relaxed.z
    while waiting and len(tried) < MOST_COMBINATIONS:
        for numbers in waiting:
            hunt.tell(f"whole numbers: {', '.join(map(str, numbers))}", 0.85)
            found = TriedCombination(numbers, _search_held(hunt, begin, places, numbers))
            if numbers not in tried or found.point.is_better_than(tried[numbers].point):
                tried[numbers] = found
        best = _choose_best(tried)
        begin = best.point.z
        waiting = [n for n in _list_neighbours(hunt, places, best.numbers) if n not in tried]


def _choose_best(tried: dict[Combination, TriedCombination]) -> TriedCombination:
    found = next(iter(tried.values()))
    for one in tried.values():
        found = one if one.point.is_better_than(found.point) else found
    return found


def _list_neighbours(
    hunt: DesignHunt, places: list[int], numbers: Combination
) -> list[Combination]:
    """One number one up or down, within bounds."""
    free = hunt.designs.question.free
    found: list[Combination] = []
    for i, k in enumerate(places):
        for step in (-1, 1):
            if free[k].low <= numbers[i] + step <= free[k].high:
                found.append((*numbers[:i], numbers[i] + step, *numbers[i + 1 :]))
    return found


def _search_held(
    hunt: DesignHunt, begin: Numbers, places: list[int], numbers: Combination
) -> DesignPoint:
    """The best design with these numbers."""
    free = hunt.designs.question.free
    fixed = np.zeros(hunt.size, np.bool_)
    fixed[places] = True
    z = begin.copy()
    z[places] = [free[k].share(float(n)) for k, n in zip(places, numbers, strict=True)]
    return _search_from(hunt, z, fixed)


def _search_from(hunt: DesignHunt, z: Numbers, fixed: NDArray[np.bool_]) -> DesignPoint:
    """The best design from a point, whatever was found before."""
    hunt.best = None
    hunt.judge(z[None])
    hunt.descend(z, fixed)
    hunt.clouds(fixed)
    return hunt.found
