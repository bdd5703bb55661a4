"""Bouc–Wen hysteresis: a straight line and an element that yields and recovers, side by side.

    y = α x + (1 - α) w/ϱ,    dw/dx = ϱ (1 - σ |w| sgn(w dx/dt) + (σ - 1) |w|)

the normalised form of Ikhouane and Rodellar with exponent n = 1, on an input scaled by half its
range. w stays between -1 and 1 and the slope of y at w = 0 is 1. On a way of one direction w
follows exponentials, one before it passes 0 and one after, so that steps of any size are exact.
With ϱ > 0 and σ > 1/2, which their logarithms ensure, every model is bounded and passive.
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
    """One input, one output of slope 1 at rest, where w = 0; rate independent."""

    short = "boucwen"
    cites = ("wen1976", "ikhouane2007")

    def numbers(self) -> tuple[str, ...]:
        """Logit of α, log ϱ, log (2σ - 1)."""
        return ("logit_line", "log_stiffness", "log_recovery")

    def states(self) -> int:
        """Return the input before, and w."""
        return 2

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Unstrained: w = 0."""
        return x[0], 0.0

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Along two exponentials."""
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
        """Return half a line; yields within a third of the range; σ = 1."""
        return np.array([0.0, np.log(3.0), 0.0])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return any share of the line; yields within all of the range or a tenth."""
        low, high = np.array([-2.0, 0.0, -2.0]), np.array([2.0, np.log(10.0), 1.0])
        return rng.uniform(low, high)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """α, 1/ϱ in units of the input, σ."""
        half = self.half
        return [
            ("line", float(1.0 / (1.0 + np.exp(-theta[0]))), "1"),
            ("yield", half * float(np.exp(-theta[1])), "1"),
            ("sigma", 0.5 + 0.5 * float(np.exp(theta[2])), "1"),
        ]


def _yield_way(xp: Namespace, v: Scalar, way: Scalar, recovery: Scalar) -> Scalar:
    """v = ±w after a way ≥ 0: dv = (1 - c v) below 0, then dv = 1 - v; c = 2σ - 1."""
    below, above = xp.minimum(v, 0.0), xp.maximum(v, 0.0)
    to_zero = xp.log(1.0 - recovery * below) / recovery
    first = xp.minimum(way, to_zero)
    gone = minus_expm1(xp, recovery * first)
    v = above + below + (1.0 - recovery * below) * gone / recovery
    return v + (1.0 - v) * minus_expm1(xp, way - first)
