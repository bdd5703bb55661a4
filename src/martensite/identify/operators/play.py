"""Plays, the operators of this family of hysteresis, and their weighted sum.

    p⁺ = max(x - r, min(x + r, p))

A play of threshold r holds its value until the input x is more than r away. Sums of plays with positive weights
(Prandtl–Ishlinskii, y = a_0 x + Σ a_i p_i) have an inverse of the same form in closed form (Kuhnen 2003).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import Column, Numbers
from martensite.kernels.namespace import Namespace, Scalar

STRONGEST = 50.0
"""Limit of the size of a logit."""
FARTHEST = 30.0
"""Weak prior standard deviation of logits, so that the logit of an unused weight stays finite."""


def move_play(xp: Namespace, x: Scalar, r: Scalar, p: Scalar) -> Scalar:
    """Return the next value of a play of threshold r ≥ 0 at p."""
    return keep_between(xp, x - r, x + r, p)


def keep_between(xp: Namespace, lower: Scalar, upper: Scalar, p: Scalar) -> Scalar:
    """Return the next value of a play between two bounds, lower ≤ upper."""
    return xp.maximum(lower, xp.minimum(upper, p))


def compute_logistic(xp: Namespace, z: Scalar) -> Scalar:
    """Return 1/(1 + exp(-z))."""
    return 1.0 / (1.0 + xp.exp(xp.clip(-z, -STRONGEST, STRONGEST)))


def compute_sizes(xp: Namespace, logits: Column) -> tuple[list[Scalar], Scalar]:
    """Return positive sizes, the first for the logit 0, and their sum.

    Weights are sizes over the sum. Kernels divide the weighted sum by it, so that each derivative is one product.
    """
    sizes = [1.0, *(xp.exp(xp.clip(z, -STRONGEST, STRONGEST)) for z in logits)]
    whole = sizes[0]
    for size in sizes[1:]:
        whole = whole + size
    return sizes, whole


def evaluate_hinges(xp: Namespace, rises: Sequence[Scalar], half: Scalar, p: Scalar) -> Scalar:
    """Return the curve from 0 at -half with given slopes between even knots up to half, and linear ends."""
    gap = 2.0 * half / len(rises)
    total, before = rises[0] * (p + half), rises[0]
    for k, rise in enumerate(rises[1:], 1):
        total = total + (rise - before) * xp.maximum(p + half - k * gap, 0.0)
        before = rise
    return total


def compute_logits(shares: Numbers) -> Numbers:
    """Return the logits of positive weights."""
    return np.log(shares[1:] / shares[0])


@dataclass(frozen=True)
class PlaySum:
    """Prandtl–Ishlinskii operator y = a_0 x + Σ_i a_i p_i with numbers, and its inverse.

    Args:
        thresholds: r_1 < r_2 < …, above 0, in the unit of the input.
        weights: a_0, a_1, …, one more than thresholds.

    Raises:
        ParameterError: thresholds do not rise from above 0, or the number of weights does not fit.
    """

    thresholds: tuple[float, ...]
    weights: tuple[float, ...]

    cites = ("kuhnen2003",)

    def __post_init__(self) -> None:
        rising = np.all(np.diff((0.0, *self.thresholds)) > 0.0)
        if not rising or len(self.weights) != len(self.thresholds) + 1:
            raise ParameterError(
                "A sum of plays needs rising thresholds above 0 and one weight more than "
                f"thresholds, but has thresholds {self.thresholds} and weights {self.weights}."
            )

    @cached_property
    def _arrays(self) -> tuple[Numbers, Numbers]:
        return np.array(self.thresholds), np.array(self.weights)

    def rest(self, x: float) -> Numbers:
        """Return the initial plays under a constant input."""
        return np.full(len(self.thresholds), float(x))

    def step(self, state: Numbers, x: float) -> tuple[float, Numbers]:
        """Return the output of this sample, and the plays."""
        r, a = self._arrays
        p = np.maximum(x - r, np.minimum(x + r, state))
        return float(a[0] * x + a[1:] @ p), p

    def simulate(self, inputs: Sequence[float] | Numbers, state: Numbers | None = None) -> Numbers:
        """Return the outputs for inputs of shape (samples,), by default from the initial state."""
        outputs = np.empty(len(inputs))
        state = self.rest(inputs[0]) if state is None else state
        for t, x in enumerate(inputs):
            outputs[t], state = self.step(state, x)
        return outputs

    def inverse(self) -> PlaySum:
        """Return the inverse operator, for feed-forward.

            s_i = Σ_{j<i} a_j (r_i - r_j),   b_0 = 1/a_0,
            b_i = -a_i / ((a_0 + … + a_i)(a_0 + … + a_{i-1}))

        with r_0 = 0. It starts from the state of `matching`.

        Raises:
            ParameterError: a sum a_0 + … + a_i is not above 0.
        """
        r, a = self._arrays
        slopes = np.cumsum(a)
        if not np.all(slopes > 0.0):
            raise ParameterError(
                "This sum of plays has no inverse: its weights must have sums a_0 + … + a_i "
                f"above 0, but the least is {slopes.min():.6g}."
            )
        steps = np.diff(r, prepend=0.0)
        b = -a[1:] / (slopes[1:] * slopes[:-1])
        return PlaySum(tuple(np.cumsum(slopes[:-1] * steps).tolist()), (float(1.0 / a[0]), *b.tolist()))

    def matching(self, state: Numbers) -> Numbers:
        """Return the state of the inverse for a reachable state of this operator."""
        a = self._arrays[1]
        slopes = np.cumsum(a)[1:]
        beyond = a[1:] * state
        return slopes * state + beyond.sum() - np.cumsum(beyond)
