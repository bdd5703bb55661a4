"""One play: y⁺ = max(x - r, min(x + r, y)), r = exp(log_radius) over half the range of the input.

Backlash of gears, or dry friction. Unit gain, and y = x initially. `prandtl_ishlinskii` is a sum of plays.
Source: Krasnosel'skii and Pokrovskii 1989.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators.play import move_play
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

STRONGEST = 14.0
"""Limit of |log radius|."""
RADII = (0.02, 0.5)
"""Range of random radii over half the range of the input; a fit starts at their geometric mean."""


@BLOCKS.register("play")
class Play(AbstractRanged):
    """Rate-independent backlash of a free width."""

    short = "play"
    cites = ("krasnoselskii1989",)

    def numbers(self) -> tuple[str, ...]:
        return ("log_radius",)

    def states(self) -> int:
        return 1

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return x[:1]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        y = move_play(xp, x[0], self.radius(xp, theta), state[0])
        return (y,), (y,)

    def radius(self, xp: Namespace, theta: Column) -> Scalar:
        """Return half the backlash, in the unit of the input."""
        return self.half * xp.exp(xp.clip(theta[0], -STRONGEST, STRONGEST))

    def start(self) -> Numbers:
        return np.array([0.5 * float(np.log(RADII).sum())])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        low, high = np.log(RADII)
        return rng.uniform(low, high, 1)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return [("radius", float(self.radius(floats, [float(theta[0])])), "1")]
