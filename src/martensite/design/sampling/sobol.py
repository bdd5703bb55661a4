"""A scrambled Sobol' sequence, which fills space evenly (Owen (1998); SciPy).

A power of 2 spreads best.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any

import numpy as np

from martensite.design.sampling.base import DESIGNS, AbstractSample
from martensite.design.sampling.monte_carlo import TINY
from martensite.design.sweep.axes import Numbers


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
