"""One play: y⁺ = max(x - r, min(x + r, y)), r = exp(log_radius) over half the range of the input.

Backlash of gear teeth, or dry friction that holds an end in place. Unit gain, and y = x at rest.
A sum of many is `prandtl_ishlinskii`. Source: Krasnosel'skii and Pokrovskii 1989.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators.play import move_play
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar

STRONGEST = 14.0
"""Limit of |log radius|."""
BEGUN = (0.02, 0.5)
"""Between which radii are drawn, over half the range; a fit begins with their geometric mean."""


@BLOCKS.register("play")
class Play(AbstractRanged):
    """Backlash of a free width; rate independent."""

    short = "play"
    cites = ("krasnoselskii1989",)

    def numbers(self) -> tuple[str, ...]:
        """Return the radius."""
        return ("log_radius",)

    def states(self) -> int:
        """Return the output."""
        return 1

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """In the middle of the backlash."""
        return x[:1]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Pushed along, or left."""
        y = move_play(xp, x[0], self.radius(xp, theta), state[0])
        return (y,), (y,)

    def radius(self, xp: Namespace, theta: Column) -> Scalar:
        """Return half the backlash, in the unit of the input."""
        return self.half * xp.exp(xp.clip(theta[0], -STRONGEST, STRONGEST))

    def start(self) -> Numbers:
        """Return a tenth of half the range."""
        return np.array([0.5 * float(np.log(BEGUN).sum())])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return any size that would be noticed."""
        low, high = np.log(BEGUN)
        return rng.uniform(low, high, 1)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the radius, in the unit of the input."""
        return [("radius", float(self.radius(floats, [float(theta[0])])), "1")]
