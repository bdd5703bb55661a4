"""Samples of the unit cube, any stretch of which is reached without making the others.

    monte-carlo        independent random numbers (PCG64)
    latin-hypercube    every axis is cut into as many strata as there are runs, and each is met once
                       (McKay, Beckman and Conover (1979)); the order of the strata of every axis is
                       kept in memory, 4 bytes per run and axis
    sobol              a scrambled Sobol' sequence, which fills space evenly (Owen (1998); SciPy)
    saltelli           blocks of runs from which Sobol' indices follow, in the order of SALib

For the last, two independent samples A and B of N points are made, from the first and the second
half of the coordinates of a scrambled Sobol' sequence. Block n has point n of A, then for every
axis that point with the coordinate of B, then point n of B: d + 2 runs (Saltelli et al. (2010),
Comput. Phys. Commun. 181, radial design without second order). A power of 2 spreads the last two
best.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.design.sampling.base import DESIGNS, MOST_RUNS, AbstractSample
from martensite.design.sweep.axes import Numbers, SweepAxis

TINY = 2.0**-54
MOST_STRATA = 20_000_000
"""Runs of the largest Latin hypercube."""


@DESIGNS.register("monte-carlo")
class MonteCarlo(AbstractSample):
    """Independent samples."""

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Numbers of a stream, from a place in it on; never 0."""
        stream = np.random.PCG64(self.seed)
        stream.advance(first * width)
        return np.maximum(np.random.Generator(stream).random((count, width)), TINY)


@DESIGNS.register("latin-hypercube")
class LatinHypercube(AbstractSample):
    """Points of a Latin hypercube, at random places in their strata."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` unless it is known how many, and they fit into memory."""
        super().__post_init__()
        if (self.count or 0) > MOST_STRATA:
            raise ParameterError(
                f"A Latin hypercube has at most {MOST_STRATA:,} runs, not {self.count:,}; take `sobol`."
            )

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Strata of all axes, and places in them."""
        stream = np.random.PCG64([self.seed, 1])
        stream.advance(first * width)
        inside = np.random.Generator(stream).random((count, width))
        strata = [_draw_strata(self.count or 0, self.seed, k)[first : first + count] for k in range(width)]
        return np.maximum((np.stack(strata, axis=1) + inside) / (self.count or 1), TINY)


@lru_cache(maxsize=64)
def _draw_strata(count: int, seed: int, axis: int) -> NDArray[np.int32]:
    """Strata of one axis in the order of the runs."""
    rng = np.random.Generator(np.random.PCG64([seed, 2, axis]))
    return rng.permutation(count).astype(np.int32)


@DESIGNS.register("sobol")
class Sobol(AbstractSample):
    """Points of a scrambled Sobol' sequence."""

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Points from a place in the sequence on; never 0."""
        qmc: Any = import_module("scipy.stats.qmc")
        sequence = qmc.Sobol(width, seed=self.seed)
        if first:
            sequence.fast_forward(first)
        with warnings.catch_warnings():  # it says at every stretch that a power of 2 spreads best
            warnings.simplefilter("ignore", UserWarning)
            found = sequence.random(count)
        return np.maximum(np.asarray(found, float), TINY)


@DESIGNS.register("saltelli")
class Saltelli(AbstractSample):
    """N base points, and N (d + 2) runs of d axes."""

    def size(self, axes: Sequence[SweepAxis]) -> int:
        """All runs of all blocks.

        Raises:
            ParameterError: they are too many.
        """
        found = (self.count or 0) * count_block_runs(len(axes))
        if found > MOST_RUNS:
            raise ParameterError(
                f"`saltelli:{self.count}` of {len(axes)} axes has {found:,} runs; at most {MOST_RUNS:,} are allowed."
            )
        return found

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Runs from any one on, which need not be the first of its block."""
        size = count_block_runs(width)
        rows = np.arange(first, first + count)
        begin, end = first // size, (first + count - 1) // size + 1
        points = Sobol(self.count, self.seed).cube(2 * width, begin, end - begin)
        a, b = points[rows // size - begin, :width], points[rows // size - begin, width:]
        member = (rows % size)[:, None]
        return np.where((member == np.arange(1, width + 1)) | (member == size - 1), b, a)


def count_block_runs(width: int) -> int:
    """Runs in a block of some axes."""
    return width + 2
