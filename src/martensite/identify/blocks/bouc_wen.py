"""Bouc–Wen hysteresis: a line in parallel with an element that yields and recovers.

    y = α x + (1 - α) w/ϱ,    dw/dx = ϱ (1 - σ |w| sgn(w dx/dt) + (σ - 1) |w|)

Normalised form of Ikhouane and Rodellar with exponent n = 1, on an input scaled by half its range. w stays between -1
and 1, and the slope of y at w = 0 is 1. In one direction w follows exponentials, one before and one after it passes 0,
so that steps of any size are exact. Free numbers are the logarithms of ϱ > 0 and of 2σ - 1 > 0, so every model is
bounded and passive.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators.branches import compute_logistic
from martensite.identify.operators.sections import minus_expm1
from martensite.kernels.namespace import Namespace, Scalar

STRONGEST = 9.0
"""Limit of |log ϱ| and |log (2σ - 1)|."""


@BLOCKS.register("bouc-wen")
class BoucWen(AbstractRanged):
    """Rate-independent hysteresis with initial slope 1 at w = 0."""

    short = "boucwen"
    cites = ("wen1976", "ikhouane2007")

    def numbers(self) -> tuple[str, ...]:
        return ("logit_line", "log_stiffness", "log_recovery")

    def states(self) -> int:
        return 2

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return x[0], 0.0

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        before, w = state
        half = self.half
        line = compute_logistic(xp, theta[0])
        stiffness = xp.exp(xp.clip(theta[1], -STRONGEST, STRONGEST))
        recovery = xp.exp(xp.clip(theta[2], -STRONGEST, STRONGEST))
        upward = x[0] > before
        v = xp.where(upward, w, -w)
        v = _yield_way(xp, v, stiffness * xp.abs(x[0] - before) / half, recovery)
        w = xp.where(upward, v, -v)
        return (line * x[0] + (1.0 - line) * half * w / stiffness,), (x[0], w)

    def start(self) -> Numbers:
        return np.array([0.0, np.log(3.0), 0.0])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        low, high = np.array([-2.0, 0.0, -2.0]), np.array([2.0, np.log(10.0), 1.0])
        return rng.uniform(low, high)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        half = self.half
        return [
            ("line", float(1.0 / (1.0 + np.exp(-theta[0]))), "1"),
            ("yield", half * float(np.exp(-theta[1])), "1"),
            ("sigma", 0.5 + 0.5 * float(np.exp(theta[2])), "1"),
        ]


def _yield_way(xp: Namespace, v: Scalar, way: Scalar, recovery: Scalar) -> Scalar:
    """Return v = ±w after a way ≥ 0: dv = (1 - c v) below 0, then dv = 1 - v; c = 2σ - 1."""
    below, above = xp.minimum(v, 0.0), xp.maximum(v, 0.0)
    to_zero = xp.log(1.0 - recovery * below) / recovery
    first = xp.minimum(way, to_zero)
    decay = minus_expm1(xp, recovery * first)
    v = above + below + (1.0 - recovery * below) * decay / recovery
    return v + (1.0 - v) * minus_expm1(xp, way - first)
