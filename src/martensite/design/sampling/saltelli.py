"""Blocks of runs from which Sobol' indices follow, as SALib expects them.

Two independent samples A and B of N points are made, from the first and the second half of the
coordinates of a scrambled Sobol' sequence. Block n has point n of A, then for every axis that point
with the coordinate of B, then point n of B: d + 2 runs (Saltelli et al. (2010), Comput. Phys.
Commun. 181, radial design without second order). A power of 2 spreads best.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.base.errors import ParameterError
from martensite.design.sampling.base import DESIGNS, MOST_RUNS, AbstractSample
from martensite.design.sampling.sobol import Sobol
from martensite.design.sweep.axes import Numbers, SweepAxis


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
                f"`saltelli:{self.count}` of {len(axes)} axes has {found:,} runs; at most "
                f"{MOST_RUNS:,} are allowed."
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
