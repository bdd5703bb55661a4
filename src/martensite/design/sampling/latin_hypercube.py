"""A Latin hypercube: every axis is cut into as many strata as there are runs, and each is met once.

McKay, Beckman and Conover (1979). The order of the strata of every axis is kept in memory, 4 bytes
per run and axis.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.design.sampling.base import DESIGNS, AbstractSample
from martensite.design.sampling.monte_carlo import TINY
from martensite.design.sweep.axes import Numbers

MOST_NUMBERS = 20_000_000


@DESIGNS.register("latin-hypercube")
class LatinHypercube(AbstractSample):
    """Points of a Latin hypercube, at random places in their strata."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` unless it is known how many, and they fit into memory."""
        super().__post_init__()
        if (self.count or 0) > MOST_NUMBERS:
            raise ParameterError(
                f"A Latin hypercube has at most {MOST_NUMBERS:,} runs, not {self.count:,}; take "
                "`sobol`."
            )

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Strata of all axes, and places in them."""
        stream = np.random.PCG64([self.seed, 1])
        stream.advance(first * width)
        inside = np.random.Generator(stream).random((count, width))
        strata = [
            _draw_strata(self.count or 0, self.seed, k)[first : first + count] for k in range(width)
        ]
        return np.maximum((np.stack(strata, axis=1) + inside) / (self.count or 1), TINY)


@lru_cache(maxsize=64)
def _draw_strata(count: int, seed: int, axis: int) -> NDArray[np.int32]:
    """Strata of one axis in the order of the runs."""
    rng = np.random.Generator(np.random.PCG64([seed, 2, axis]))
    return rng.permutation(count).astype(np.int32)
