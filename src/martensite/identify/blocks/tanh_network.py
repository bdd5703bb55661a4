"""Neural network of one hidden layer: y = offset + L r + Σ_i a_i tanh(w_i r + v_i).

r is the input on the scale of its range, -1 to 1. Weights may have either sign. Units start with
their steepest points spread evenly over the range and with height 0.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, Numbers
from martensite.identify.operators.networks import AbstractNetwork, compute_logistic
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("tanh-network")
class TanhNetwork(AbstractNetwork):
    """A line and hyperbolic tangents of weights and biases."""

    short = "tanh"

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """The hyperbolic tangent, from an exponential."""
        share, slope = compute_logistic(xp, 2.0 * q)
        return 2.0 * share - 1.0, 4.0 * slope

    def argument(self, xp: Namespace, first: Scalar, second: Scalar, r: Scalar) -> Scalar:
        """Weight and bias."""
        return first * r + second

    def places(self) -> tuple[str, ...]:
        """Weights, then biases."""
        units = range(1, int(self.units) + 1)
        return (*(f"weight{i}" for i in units), *(f"bias{i}" for i in units))

    def frame(self) -> tuple[Numbers, Numbers]:
        """As steep as their number asks for, at even distances."""
        count = int(self.units)
        weights = np.full(count, 0.5 * (count + 1.0))
        return weights, -weights * ((2.0 * np.arange(count) + 1.0) / count - 1.0)

    def spread(self, rng: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Weights of the size of those of the frame, their steepest points in the range."""
        weights = self.frame()[0] * rng.normal(0.0, 1.0, int(self.units))
        return weights, -weights * rng.uniform(-1.0, 1.0, len(weights))
