"""Piecewise linear curve between knots, with linear ends.

    y = offset + m_1 (r - r_1) + Σ_i (m_i - m_{i-1}) max(r - r_i, 0),
    m_i = (v_{i+1} - v_i) / (r_{i+1} - r_i),    v_1 = 0

r is the input on the scale of its range. The end knots are at the ends of the range; the inner knots are free, and
ordered for any free numbers: the gaps are a softmax with a least gap. Values are relative to the first knot.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

LEAST_KNOT_GAP = 0.02
"""Least gap between two knots, over the mean gap."""
LIKELIEST = 14.0
"""Limit of the logits of gaps."""


@BLOCKS.register("piecewise-linear")
class PiecewiseLinear(AbstractCurve):
    """Lines between knots: any shape with kinks, quickly fitted."""

    short = "pwl"
    shape = ("knots", "inner")

    knots: Number = param("1", "number of knots", low=2.0, high=200.0, default=10.0, typical=4.0)
    inner: str = option("positions of the inner knots", "free", "fixed", default="free")

    def heights(self) -> tuple[str, ...]:
        return tuple(f"value{i}" for i in range(2, int(self.knots) + 1))

    def places(self) -> tuple[str, ...]:
        inner = int(self.knots) - 1 if self.inner == "free" else 1
        return tuple(f"gap{i}" for i in range(2, inner + 1))

    def _gaps(self, xp: Namespace, places: Column) -> list[Scalar]:
        """Return the distances of the knots, with the sum 2."""
        count = int(self.knots) - 1
        logits = [0.0, *places] if self.inner == "free" else [0.0] * count
        sizes = [xp.exp(xp.clip(logit, -LIKELIEST, LIKELIEST)) for logit in logits]
        total = sizes[0]
        for size in sizes[1:]:
            total = total + size
        return [2.0 * (LEAST_KNOT_GAP / count + (1.0 - LEAST_KNOT_GAP) * size / total) for size in sizes]

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        gaps = self._gaps(xp, places)
        total, before, slope, knot = 0.0, 0.0, 0.0, -1.0
        for number, (value, gap) in enumerate(zip(heights, gaps, strict=True)):
            steeper = (value - before) / gap
            reached = xp.maximum(r - knot, 0.0) if number else r - knot
            total = total + (steeper - slope) * reached
            before, slope, knot = value, steeper, knot + gap
        return total

    def line(self, slope: float, offset: float) -> Numbers:
        values = slope * self.half * np.linspace(0.0, 2.0, int(self.knots))[1:]
        return self.join_numbers(offset + slope * self.low, values, np.zeros(len(self.places())))

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        last = len(theta) - len(self.places())
        rise = abs(theta[last - 1])
        theta[self.first : last] += rng.normal(0.0, 0.1, last - self.first) * rise
        theta[last:] = rng.normal(0.0, 0.5, len(theta) - last)
        return theta

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        gaps = self._gaps(floats, [float(v) for v in theta[len(theta) - len(self.places()) :]])
        return self.describe_knots(theta, self.low + self.half * np.concatenate([[0.0], np.cumsum(gaps)]))
