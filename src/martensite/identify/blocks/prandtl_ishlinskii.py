"""Prandtl–Ishlinskii hysteresis: a weighted sum of the input and its plays.

    y = (1 - Σ a_i) x + Σ a_i p_i,    p_i⁺ = max(x - r_i, min(x + r_i, p_i)),    i = 1 … K

Loops are closed, odd, and independent of their starting point; a static block before or after bends and saturates
them. The static gain is 1 without offset: a chain without another static block needs a `gain`. Thresholds are fractions
of the range of the input; initially p_i = x. The block is rate independent.

Sources: Krasnosel'skii and Pokrovskii 1989 (plays), Kuhnen 2003 (inverse).
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators.play import FARTHEST, PlaySum, compute_logits, compute_sizes, move_play
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

STEADY = 3.0
"""Prior standard deviation of logarithms of thresholds."""
PLAYING = 0.5
"""Initial weight of all plays."""


@BLOCKS.register("prandtl-ishlinskii")
class PrandtlIshlinskii(AbstractRanged):
    """A weighted sum of plays; with positive weights it is monotone and has an exact inverse."""

    short = "pi"
    shape = ("plays", "weights", "thresholds")
    fixed = ("low", "high", "reach")
    cites = ("krasnoselskii1989", "kuhnen2003")

    plays: Number = param("1", "number K of plays", low=1.0, default=12.0, typical=4.0)
    reach: Number = param("1", "highest threshold over the range of the input", above=0.0, high=1.0, default=0.25)
    weights: str = option("signs of the weights of input and plays", "positive", "free", default="positive")
    thresholds: str = option(
        "even with a free reach, even up to the given reach, or all free", "scaled", "even", "free", default="scaled"
    )

    def numbers(self) -> tuple[str, ...]:
        each = [str(i) for i in range(1, int(self.plays) + 1)]
        word = "logit" if self.weights == "positive" else "weight"
        weights = tuple(f"{word}{i}" for i in each)
        if self.thresholds == "free":
            return (*weights, *(f"log_step{i}" for i in each))
        return (*weights, "log_reach") if self.thresholds == "scaled" else weights

    def states(self) -> int:
        return int(self.plays)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return [x[0]] * int(self.plays)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        radii = self.radii(xp, theta)
        after = [move_play(xp, x[0], r, p) for r, p in zip(radii, state, strict=True)]
        sizes, whole = self._sizes(xp, theta)
        away: Scalar = 0.0
        for size, p in zip(sizes[1:], after, strict=True):
            away = away + size * (p - x[0])
        return (x[0] + away / whole,), after

    def _sizes(self, xp: Namespace, theta: Column) -> tuple[list[Scalar], Scalar]:
        """Return the weights of input and plays times a number, and that number."""
        logits = theta[: int(self.plays)]
        if self.weights == "positive":
            return compute_sizes(xp, logits)
        rest: Scalar = 1.0
        for weight in logits:
            rest = rest - weight
        return [rest, *logits], 1.0

    def radii(self, xp: Namespace, theta: Column) -> list[Scalar]:
        """Return the thresholds, in the unit of the input."""
        count = int(self.plays)
        step = self.reach * (self.high - self.low) / count
        logits = theta[count:]
        if self.thresholds == "free":
            total: Scalar = 0.0
            thresholds: list[Scalar] = []
            for log in logits:
                total = total + step * xp.exp(xp.clip(log, -9.0, 9.0))
                thresholds.append(total)
            return thresholds
        if self.thresholds == "scaled":
            step = step * xp.exp(xp.clip(logits[0], -9.0, 9.0))
        return [(i + 1.0) * step for i in range(count)]

    def priors(self) -> tuple[Numbers, Numbers]:
        count = int(self.plays)
        widths = np.full(len(self.numbers()), 1.0 / STEADY)
        widths[:count] = 1.0 / FARTHEST if self.weights == "positive" else 0.0
        return self.start(), widths

    def start(self) -> Numbers:
        return self._spread_weights(PLAYING)

    def _spread_weights(self, fraction: float) -> Numbers:
        theta, count = np.zeros(len(self.numbers())), int(self.plays)
        each = np.full(count, fraction / count)
        positive = self.weights == "positive"
        theta[:count] = compute_logits(np.array([1.0 - fraction, *each])) if positive else each
        return theta

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self._spread_weights(rng.uniform(0.05, 0.95))
        if self.thresholds == "scaled":
            theta[int(self.plays) :] = rng.uniform(-1.5, 0.7)
        return theta

    def operator(self, theta: Numbers) -> PlaySum:
        """Return the operator with these numbers."""
        numbers = [float(value) for value in theta]
        sizes, whole = self._sizes(floats, numbers)
        return PlaySum(tuple(self.radii(floats, numbers)), tuple(size / whole for size in sizes))

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        operator = self.operator(theta)
        rows = [("weight of the input", operator.weights[0], "1")]
        for i, (r, a) in enumerate(zip(operator.thresholds, operator.weights[1:], strict=True), 1):
            rows += [(f"threshold {i}", r, "1"), (f"weight {i}", a, "1")]
        return rows
