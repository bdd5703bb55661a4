"""Brute force beside a search: all designs of a grid over the box, marched in batches.

It asks for n^k runs where a search asks for some hundreds, and is as good as its grid is fine: it
is the check of a search, not a way to find designs.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.design.optimise.evaluate import DesignEvaluator, RunCounts
from martensite.search.box_search import JudgedPoints

Numbers: TypeAlias = NDArray[np.float64]
BATCH = 1024
"""Designs that are judged together."""
MOST_DESIGNS = 1_000_000
"""Designs of the largest grid."""


@dataclass(frozen=True)
class DesignScan:
    """The designs of a grid."""

    z: Numbers
    """(designs, free)"""
    judged: JudgedPoints
    shape: tuple[int, ...]
    best: int | None
    """The design that keeps all constraints and has the least goal; None if none keeps all."""
    numbers: tuple[float, ...]
    """Its free numbers [SI]; of the one that misses least where none keeps all."""
    values: tuple[float, ...]
    """What it is judged by, mean over the cases [SI]."""

    def cells(self, z: Numbers) -> tuple[float, ...]:
        """How far a design is from the best of the grid, in cells of it."""
        place = self.z[self.judged.order()[0]]
        wide = [1.0 / max(n - 1, 1) for n in self.shape]
        return tuple(float(abs(a - b)) / w for a, b, w in zip(z, place, wide, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "simulations": len(self.z),
            "shape": list(self.shape),
            "kept": int(self.judged.kept.sum()),
            "numbers": list(self.numbers),
            "values": list(self.values),
        }


def scan_designs(
    designs: DesignEvaluator, points: int | Sequence[int], watch: Callable[[float], None] | None = None
) -> DesignScan:
    """Judge all designs of a grid, even on the scale of each free number.

    Args:
        designs: ready to be judged.
        points: along each free number; of a whole one all its numbers if they are fewer.
        watch: called with the share that is done.

    Raises:
        ParameterError: there are too many, or fewer than two along a number.
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
        first if judged.kept[first] else None,
        tuple(designs.numbers(z[first]).tolist()),
        tuple(values[first].mean(axis=0).tolist()),
    )


def _evaluate_grid(designs: DesignEvaluator, z: Numbers, watch: Callable[[float], None] | None) -> Numbers:
    """Values of all designs, which do not count as those of a search."""
    counts, designs.counts = designs.counts, RunCounts()
    found: list[Numbers] = []
    try:
        for k in range(0, len(z), BATCH):
            found.append(designs.values(z[k : k + BATCH]))
            if watch is not None:
                watch(min(k + BATCH, len(z)) / len(z))
    finally:
        designs.counts = counts
    return np.concatenate(found)


def _space_axis(designs: DesignEvaluator, k: int, count: int) -> Numbers:
    """Places of the points along a free number."""
    one = designs.question.free[k]
    if not one.whole:
        return np.linspace(0.0, 1.0, count)
    whole = np.unique(np.round(np.linspace(one.low, one.high, count)))
    return np.array([one.share(float(number)) for number in whole])
