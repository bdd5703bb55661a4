"""Generalised plays: hysteresis between two curves, for rising and for falling input.

    p_i⁺ = max(g_l(x) - r_i, min(g_u(x) + r_i, p_i)),    y = offset + rise Σ a_i p_i

The curves are piecewise linear and rise from -1 to 1 over the range of the input: rising input follows the lower curve
g_l, falling input the upper curve g_u. Loops may be asymmetric and saturate; they close at the ends of the range but
for the thresholds. At the knots, on a scale from 0 to 1,

    u_k = u_{k-1} + (1 - u_{k-1}) σ(α_k),    l_k = l_{k-1} + (u_k - l_{k-1}) σ(β_k),

with the logistic function σ, so that both rise and never cross. Weights a_i are positive with the sum 1, thresholds are
even from r_1 = 0. Beyond the range the curves cross, so the range must hold all inputs. Initially plays are half way
between the curves. The block is rate independent, carries the size of the output, and is placed like a static block.

Source: Al Janaideh, Rakheja and Su 2011 (with two different envelopes).
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, param
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.play import FARTHEST, compute_logistic, compute_sizes, evaluate_hinges, keep_between
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar

OPEN = 0.15
"""Initial half height of the loop over the rise; at most 1/4."""


@BLOCKS.register("generalised-prandtl-ishlinskii")
class GeneralisedPrandtlIshlinskii(AbstractCurve):
    """Asymmetric, saturating loops with few numbers."""

    short = "gpi"
    shape = ("plays", "knots")
    fixed = ("low", "high", "reach")
    cites = ("aljanaideh2011",)

    plays: Number = param("1", "number of plays", low=1.0, high=200.0, default=4.0, typical=3.0)
    knots: Number = param("1", "number of knots of each curve", low=2.0, high=200.0, default=8.0, typical=3.0)
    reach: Number = param(
        "1", "upper bound of the thresholds, over the rise of the curves", above=0.0, high=1.0, default=0.25
    )

    def heights(self) -> tuple[str, ...]:
        return ("rise",)

    def places(self) -> tuple[str, ...]:
        names = [f"weight{i}" for i in range(2, int(self.plays) + 1)]
        for curve in ("upper", "lower"):
            names += [f"{curve}{k}" for k in range(2, int(self.knots))]
        return tuple(names)

    def states(self) -> int:
        return int(self.plays)

    def _split_parameters(self, theta: Column) -> tuple[Scalar, Column, Column]:
        """Return the rise, the logits of weights, and the logits of both curves."""
        own = theta[self.first + 1 :]
        count = int(self.plays) - 1
        return theta[self.first], own[:count], own[count:]

    def curves(self, xp: Namespace, logits: Column, r: Scalar) -> tuple[Scalar, Scalar]:
        """Return the lower and the upper curve on the scale of the range."""
        count = int(self.knots) - 2
        above, below = [0.0], [0.0]
        for alpha, beta in zip(logits[:count], logits[count:], strict=True):
            above.append(above[-1] + (1.0 - above[-1]) * compute_logistic(xp, alpha))
            below.append(below[-1] + (above[-1] - below[-1]) * compute_logistic(xp, beta))
        lower, upper = (evaluate_hinges(xp, self._slopes([*values, 1.0]), 1.0, r) - 1.0 for values in (below, above))
        return xp.minimum(lower, upper), xp.maximum(lower, upper)

    def _slopes(self, values: Column) -> list[Scalar]:
        pairs = zip(values[1:], values[:-1], strict=True)
        return [(int(self.knots) - 1.0) * (after - before) for after, before in pairs]

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        lower, upper = self.curves(xp, places[int(self.plays) - 1 :], r)
        return heights[0] * 0.5 * (lower + upper)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        lower, upper = self.curves(xp, self._split_parameters(theta)[2], self.unit(x[0]))
        return [0.5 * (lower + upper)] * int(self.plays)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        rise, weights, logits = self._split_parameters(theta)
        lower, upper = self.curves(xp, logits, self.unit(x[0]))
        gap = 2.0 * self.reach / int(self.plays)
        after = [keep_between(xp, lower - i * gap, upper + i * gap, p) for i, p in enumerate(state)]
        sizes, whole = compute_sizes(xp, weights)
        total: Scalar = 0.0
        for size, p in zip(sizes, after, strict=True):
            total = total + size * p
        y = rise * total / whole
        zero = self.curve(xp, [rise], theta[self.first + 1 :], self.unit(0.0))
        return ((theta[0] + y if self.offset == "yes" else y - zero),), after

    def line(self, slope: float, offset: float) -> Numbers:
        weights = np.zeros(int(self.plays) - 1)
        rise = [slope * self.half]
        return self.join_numbers(offset + slope * self.middle, rise, weights, *self._open_curves(OPEN))

    def _open_curves(self, half: float) -> tuple[Numbers, Numbers]:
        """Return the logits of curves on both sides of a line, separated by a parabola."""
        position = np.linspace(0.0, 1.0, int(self.knots))
        gap = 4.0 * half * position * (1.0 - position)
        above, below = position + gap, position - gap
        upper = np.diff(above)[:-1] / (1.0 - above[:-2])
        lower = np.diff(below)[:-1] / (above[1:-1] - below[:-2])
        return np.log(upper / (1.0 - upper)), np.log(lower / (1.0 - lower))

    def priors(self) -> tuple[Numbers, Numbers]:
        widths = np.zeros(len(self.numbers()))
        widths[self.first + 1 :] = 1.0 / FARTHEST
        return self.start(), widths

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        curves = np.concatenate(self._open_curves(rng.uniform(0.02, 0.24)))
        theta[len(theta) - len(curves) :] = curves
        theta[self.first + 1 :] += rng.normal(0.0, 0.5, len(self.places()))
        return theta
