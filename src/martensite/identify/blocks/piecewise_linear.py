"""Piecewise linear: values at knots, lines between them, the end lines going on beyond.

    y = offset + m_1 (r - r_1) + Σ_i (m_i - m_{i-1}) max(r - r_i, 0),
    m_i = (v_{i+1} - v_i) / (r_{i+1} - r_i),    v_1 = 0

r is the input on the scale of its range. The end knots stay at the ends of the range; those
between them are free, and sorted whatever the free numbers are: the gaps are shares of the
range, a softmax with a least share. Values are held relative to that at the first knot.
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
    """Lines between knots: any shape, quickly found, with kinks."""

    short = "pwl"
    shape = ("knots", "inner")

    knots: Number = param("1", "number of knots", low=2.0, high=200.0, default=10.0, typical=4.0)
    inner: str = option("whether the knots between the ends move", "free", "fixed", default="free")

    def heights(self) -> tuple[str, ...]:
        """Return the values at the knots but the first, relative to it."""
        return tuple(f"value{i}" for i in range(2, int(self.knots) + 1))

    def places(self) -> tuple[str, ...]:
        """Return the logits of the gaps but the first, if knots move."""
        inner = int(self.knots) - 1 if self.inner == "free" else 1
        return tuple(f"gap{i}" for i in range(2, inner + 1))

    def _gaps(self, xp: Namespace, places: Column) -> list[Scalar]:
        """Return the distances of the knots; they add up to 2."""
        count = int(self.knots) - 1
        logits = [0.0, *places] if self.inner == "free" else [0.0] * count
        sizes = [xp.exp(xp.clip(logit, -LIKELIEST, LIKELIEST)) for logit in logits]
        total = sizes[0]
        for size in sizes[1:]:
            total = total + size
        return [2.0 * (LEAST_KNOT_GAP / count + (1.0 - LEAST_KNOT_GAP) * size / total) for size in sizes]

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Return a line and a hinge at every inner knot."""
        gaps = self._gaps(xp, places)
        total, before, slope, knot = 0.0, 0.0, 0.0, -1.0
        for number, (value, gap) in enumerate(zip(heights, gaps, strict=True)):
            steeper = (value - before) / gap
            reached = xp.maximum(r - knot, 0.0) if number else r - knot
            total = total + (steeper - slope) * reached
            before, slope, knot = value, steeper, knot + gap
        return total

    def line(self, slope: float, offset: float) -> Numbers:
        """Return every line, with even knots."""
        count = int(self.knots)
        level = (offset + slope * self.low,)[: self.first]
        values = slope * self.half * np.linspace(0.0, 2.0, count)[1:]
        return np.concatenate([level, values, np.zeros(len(self.places()))])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return the values off the line by about a tenth of its rise, uneven knots."""
        made = self.start()
        last = len(made) - len(self.places())
        rise = abs(made[last - 1])
        made[self.first : last] += rng.normal(0.0, 0.1, last - self.first) * rise
        made[last:] = rng.normal(0.0, 0.5, len(made) - last)
        return made

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the knots in units of the input, and the outputs there."""
        numbers = [float(v) for v in theta]
        gaps = self._gaps(floats, numbers[len(numbers) - len(self.places()) :])
        shares = np.concatenate([[0.0], np.cumsum(gaps)])
        rows: list[tuple[str, float, str]] = []
        for i, share in enumerate(shares):
            knot = self.low + self.half * float(share)
            rows.append((f"knot{i + 1}", knot, "1"))
            rows.append((f"output{i + 1}", float(self.value(floats, numbers, knot)), "1"))
        return rows
