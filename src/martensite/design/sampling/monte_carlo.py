"""Independent random numbers (PCG64): any stretch of them is reached without making the others."""

from __future__ import annotations

import numpy as np

from martensite.design.sampling.base import DESIGNS, AbstractSample
from martensite.design.sweep.axes import Numbers

TINY = 2.0**-54


@DESIGNS.register("monte-carlo")
class MonteCarlo(AbstractSample):
    """Independent samples."""

    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Numbers of a stream, from a place in it on; never 0."""
        stream = np.random.PCG64(self.seed)
        stream.advance(first * width)
        return np.maximum(np.random.Generator(stream).random((count, width)), TINY)
