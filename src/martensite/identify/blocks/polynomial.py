"""Polynomial: y = θ_0 + Σ_k θ_k (r^k - r_0^k) of the input r on the scale of its range.

r_0 is r at zero input, so that θ_0 is the output there; without offset it is 0.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, AbstractStatic, Column, Numbers
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("polynomial")
class Polynomial(AbstractStatic):
    """Powers of the input up to a degree."""

    short = "poly"
    shape = ("degree",)

    degree: Number = param("1", "highest power", low=1.0, high=15.0, default=2.0)

    def numbers(self) -> tuple[str, ...]:
        powers = tuple(f"c{k}" for k in range(1, int(self.degree) + 1))
        return ("offset", *powers) if self.offset == "yes" else powers

    def value(self, xp: Namespace, theta: Column, x: Scalar) -> Scalar:
        r, zero = self.unit(x), self.unit(0.0)
        free = int(self.offset == "yes")
        total: Scalar = theta[0] if free else 0.0
        power, at_zero = r, zero
        for coefficient in theta[free:]:
            total = total + coefficient * (power - at_zero)
            power, at_zero = power * r, at_zero * zero
        return total

    def line(self, slope: float, offset: float) -> Numbers:
        theta = np.zeros(len(self.numbers()))
        free = int(self.offset == "yes")
        theta[:free] = offset
        theta[free] = slope * self.half
        return theta

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        first = 1 + (self.offset == "yes")
        theta[first:] = rng.uniform(-0.3, 0.3, len(theta) - first) * theta[first - 1]
        return theta
