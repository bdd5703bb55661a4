"""Preisach hysteresis in play form: plays of rising thresholds, each followed by a curve.

    y = offset + Σ_i g_i(p_i),    p_i⁺ = max(x - r_i, min(x + r_i, p_i)),    r_0 = 0 … r_L

The operator of a Preisach density ω(r, s) over half widths r and centres s of relays is the integral over r of
q(r, p_r) with ∂q/∂s = 2 ω and the play p_r of threshold r (Brokate and Sprekels 1996; properties: Mayergoyz 2003). Here
r takes the values r_i, and q(r_i, ·) is piecewise linear: a density on lines r = r_i, constant between knots. Wiping
out and congruency of minor loops hold exactly, at a cost of L plays per sample. r_0 = 0 is the part without memory. If
all slopes have one sign, the weights of all relays have it.

Knots of g_i are even over the range of a play of threshold r_i; end segments extend beyond. Initially p_i = x, and the
output is Σ g_i(x). The block is rate independent, carries the size of the output, and is placed like a static block.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.play import FARTHEST, compute_sizes, evaluate_hinges, move_play
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("preisach")
class Preisach(AbstractCurve):
    """Any Preisach operator, on a grid of thresholds and knots."""

    short = "preisach"
    shape = ("levels", "knots", "slopes")
    fixed = ("low", "high", "reach")
    cites = ("brokate1996", "mayergoyz2003")

    levels: Number = param("1", "number L of thresholds above 0", low=1.0, high=200.0, default=8.0, typical=3.0)
    knots: Number = param("1", "number of knots of each curve", low=2.0, high=200.0, default=8.0, typical=3.0)
    reach: Number = param("1", "highest threshold over the range of the input", above=0.0, high=0.45, default=0.25)
    slopes: str = option("signs of the slopes: alike, or free", "alike", "free", default="alike")

    def heights(self) -> tuple[str, ...]:
        if self.slopes == "alike":
            return ("rise",)
        return tuple(f"rise{i}_{k}" for i, k in self._segments())

    def places(self) -> tuple[str, ...]:
        if self.slopes == "free":
            return ()
        return tuple(f"logit{i}_{k}" for i, k in self._segments()[1:])

    def _segments(self) -> list[tuple[int, int]]:
        count = int(self.knots)
        return [(i, k) for i in range(int(self.levels) + 1) for k in range(1, count)]

    def states(self) -> int:
        return int(self.levels)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return [x[0]] * int(self.levels)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        half = self.half
        after = [move_play(xp, x[0], half * self._radius(i + 1), p) for i, p in enumerate(state)]
        heights, places = self._split_parameters(theta)
        total = self._sum(xp, heights, places, [self.unit(p) for p in (x[0], *after)])
        zero = self.curve(xp, heights, places, self.unit(0.0))
        return ((theta[0] + total if self.offset == "yes" else total - zero),), after

    def _split_parameters(self, theta: Column) -> tuple[Column, Column]:
        last = self.first + len(self.heights())
        return theta[self.first : last], theta[last:]

    def _radius(self, level: int) -> Scalar:
        return 2.0 * self.reach * level / int(self.levels)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        return self._sum(xp, heights, places, [r] * (int(self.levels) + 1))

    def _sum(self, xp: Namespace, heights: Column, places: Column, at: Column) -> Scalar:
        """Return the sum of all curves at their plays, 0 for plays in the middle of the range."""
        sizes, factor = self._sizes(xp, heights, places)
        segments = int(self.knots) - 1
        total: Scalar = 0.0
        for level, p in enumerate(at):
            slopes = sizes[level * segments : (level + 1) * segments]
            half = 1.0 - self._radius(level)
            total = total + (evaluate_hinges(xp, slopes, half, p) - evaluate_hinges(xp, slopes, half, 0.0))
        return factor * total

    def _sizes(self, xp: Namespace, heights: Column, places: Column) -> tuple[list[Scalar], Scalar]:
        """Return the slopes of all segments up to a factor, and that factor."""
        if self.slopes == "free":
            return list(heights), 1.0
        sizes, whole = compute_sizes(xp, places)
        return sizes, (int(self.knots) - 1) * heights[0] / whole

    def line(self, slope: float, offset: float) -> Numbers:
        level, rise = offset + slope * self.middle, slope * self.half
        if self.slopes == "alike":
            return self.join_numbers(level, [rise], np.zeros(len(self.places())))
        return self.join_numbers(level, np.full(len(self.heights()), rise / (self.levels + 1.0)))

    def priors(self) -> tuple[Numbers, Numbers]:
        widths = np.zeros(len(self.numbers()))
        widths[len(widths) - len(self.places()) :] = 1.0 / FARTHEST
        return self.start(), widths

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        if self.slopes == "alike":
            first = self.first + 1
            theta[first:] += rng.normal(0.0, 0.7, len(theta) - first)
        else:
            theta[self.first :] *= np.exp(rng.normal(0.0, 0.7, len(theta) - self.first))
        return theta
