"""Prandtl–Ishlinskii hysteresis: the input and plays of it, weighted.

    y = (1 - Σ a_i) x + Σ a_i p_i,    p_i⁺ = max(x - r_i, min(x + r_i, p_i)),    i = 1 … K

Loops are closed, odd, and the same wherever they start from; a static block before or after it
bends and saturates them. Its gain at rest is 1 and it has no offset: a chain that has no other
static block needs one, `gain` behind it, for the size of its output. Thresholds are shares of the
range of the input; at rest p_i = x. It does not depend on time.

Source: Krasnosel'skii and Pokrovskii 1989 (plays), Kuhnen 2003 (the inverse).
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators.play import FARTHEST, PlaySum, compute_logits, compute_sizes, move_play
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

STEADY = 3.0
"""Standard deviation of logarithms of thresholds."""
PLAYING = 0.5
"""Share of the plays in the output, to start with."""


@BLOCKS.register("prandtl-ishlinskii")
class PrandtlIshlinskii(AbstractRanged):
    """A weighted sum of plays. With positive weights it is monotone and has an exact inverse."""

    short = "pi"
    shape = ("plays", "weights", "thresholds")
    fixed = ("low", "high", "reach")
    cites = ("krasnoselskii1989", "kuhnen2003")

    plays: Number = param("1", "number K of plays", low=1.0, default=12.0, typical=4.0)
    reach: Number = param("1", "highest threshold over the range of the input", above=0.0, high=1.0, default=0.25)
    weights: str = option(
        "whether the weights of input and plays are all positive", "positive", "free", default="positive"
    )
    thresholds: str = option(
        "even with a free reach, even up to the given reach, or all free", "scaled", "even", "free", default="scaled"
    )

    def numbers(self) -> tuple[str, ...]:
        """Return the weights or their logits, then logarithms of the reach or of steps of thresholds."""
        each = [str(i) for i in range(1, int(self.plays) + 1)]
        word = "logit" if self.weights == "positive" else "weight"
        weights = tuple(f"{word}{i}" for i in each)
        if self.thresholds == "free":
            return (*weights, *(f"log_step{i}" for i in each))
        return (*weights, "log_reach") if self.thresholds == "scaled" else weights

    def states(self) -> int:
        """Return the plays."""
        return int(self.plays)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return all plays are where the input is."""
        return [x[0]] * int(self.plays)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the plays, and their sum."""
        radii = self.radii(xp, theta)
        after = [move_play(xp, x[0], r, p) for r, p in zip(radii, state, strict=True)]
        sizes, whole = self._sizes(xp, theta)
        away: Scalar = 0.0
        for size, p in zip(sizes[1:], after, strict=True):
            away = away + size * (p - x[0])
        return (x[0] + away / whole,), after

    def _sizes(self, xp: Namespace, theta: Column) -> tuple[list[Scalar], Scalar]:
        """Return the weights of the input and of the plays, times a number that is returned too."""
        own = theta[: int(self.plays)]
        if self.weights == "positive":
            return compute_sizes(xp, own)
        rest: Scalar = 1.0
        for weight in own:
            rest = rest - weight
        return [rest, *own], 1.0

    def radii(self, xp: Namespace, theta: Column) -> list[Scalar]:
        """Return the thresholds, in the unit of the input."""
        count = int(self.plays)
        step = self.reach * (self.high - self.low) / count
        own = theta[count:]
        if self.thresholds == "free":
            total: Scalar = 0.0
            made: list[Scalar] = []
            for log in own:
                total = total + step * xp.exp(xp.clip(log, -9.0, 9.0))
                made.append(total)
            return made
        if self.thresholds == "scaled":
            step = step * xp.exp(xp.clip(own[0], -9.0, 9.0))
        return [(i + 1.0) * step for i in range(count)]

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the logits within some tens: a play that is not needed would send its own to infinity."""
        count = int(self.plays)
        widths = np.full(len(self.numbers()), 1.0 / STEADY)
        widths[:count] = 1.0 / FARTHEST if self.weights == "positive" else 0.0
        return self.start(), widths

    def start(self) -> Numbers:
        """Return the plays of equal weight with half of the output; thresholds even up to the reach."""
        made = np.zeros(len(self.numbers()))
        count = int(self.plays)
        each = np.full(count, PLAYING / count)
        positive = self.weights == "positive"
        made[:count] = compute_logits(np.array([1.0 - PLAYING, *each])) if positive else each
        return made

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return another share of the plays in the output, and another reach if it is free."""
        made = self.start()
        count = int(self.plays)
        share = rng.uniform(0.05, 0.95)
        each = np.full(count, share / count)
        positive = self.weights == "positive"
        made[:count] = compute_logits(np.array([1.0 - share, *each])) if positive else each
        if self.thresholds == "scaled":
            made[count:] = rng.uniform(-1.5, 0.7)
        return made

    def operator(self, theta: Numbers) -> PlaySum:
        """Return the operator with these numbers, for its inverse."""
        own = [float(value) for value in theta]
        sizes, whole = self._sizes(floats, own)
        return PlaySum(tuple(self.radii(floats, own)), tuple(size / whole for size in sizes))

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the weight of the input, thresholds and weights of the plays."""
        made = self.operator(theta)
        rows = [("weight of the input", made.weights[0], "1")]
        for i, (r, a) in enumerate(zip(made.thresholds, made.weights[1:], strict=True), 1):
            rows += [(f"threshold {i}", r, "1"), (f"weight {i}", a, "1")]
        return rows
