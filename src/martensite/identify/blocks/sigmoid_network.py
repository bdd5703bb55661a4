"""Sigmoid network: y = offset + L r + Σ_i a_i / (1 + exp(-b_i (r - c_i))), log b_i free.

r is the input on the scale of its range, -1 to 1. Beyond its units it goes on as a line. Units
start evenly over the range, each as wide as its share, with height 0.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, Numbers
from martensite.identify.operators.networks import AbstractNetwork, compute_logistic
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("sigmoid-network")
class SigmoidNetwork(AbstractNetwork):
    """A line and steps of free height, width and place: smooth, of any shape."""

    short = "sigmoid"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """The logistic function."""
        return compute_logistic(xp, q)

    def frame(self) -> tuple[Numbers, Numbers]:
        """b = 1.5 (n + 1) / range, centres in the middle of n equal shares."""
        count = int(self.units)
        steep = np.full(count, np.log(0.75 * (count + 1)))
        return steep, (2.0 * np.arange(count) + 1.0) / count - 1.0

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Centres anywhere in the range."""
        steep, centres = self.frame()
        return steep + rng.normal(0.0, 0.3, len(steep)), rng.uniform(-1.0, 1.0, len(centres))
