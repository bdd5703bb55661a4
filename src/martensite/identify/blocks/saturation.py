"""Static blocks with something special between two free limits, and a line besides.

The limits are c ± h on the scale r of the range of the input, h = exp(log_half), so that the
lower one is below the upper one whatever the free numbers are.

Saturation: a line between two limits, constant beyond them.

    y = a min(max(r, c - h), c + h) + offset,    h = exp(log_half)

r is the input on the scale of its range. Both limits and the gain are free; the lower limit is
below the upper one whatever the free numbers are.

Dead zone: no answer between two limits, a line outwards from each.

    y = a d + offset,    d = r - (c + h) above,  r - (c - h) below,  0 between,    h = exp(log_half)

r is the input on the scale of its range. Both limits and the gain are free; the lower limit is
below the upper one whatever the free numbers are.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from martensite.base.parameters import option
from martensite.identify.blocks.base import BLOCKS, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar

SMALLEST = 14.0
"""Limit of |log h|."""


class AbstractInterval(AbstractCurve):
    """Gain times a shape between two limits."""

    gain: str = option("whether the gain is free, or one", "free", "one", default="free")

    straight: ClassVar[float]
    """log h of a straight line."""
    begun: ClassVar[tuple[float, float]]
    """Between which h is drawn; a fit begins in their middle, where it can move both limits."""

    @abstractmethod
    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """Return the shape, of slope 1 where it is a line."""

    def heights(self) -> tuple[str, ...]:
        """Return the rise over half the range, if the gain is free."""
        return ("rise",) if self.gain == "free" else ()

    def places(self) -> tuple[str, ...]:
        """Return the middle between the limits, and logarithm of half their distance."""
        return ("centre", "log_half")

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Rise times shape."""
        half = xp.exp(xp.clip(places[1], -SMALLEST, SMALLEST))
        shape = self.shape_input(xp, places[0] - half, places[0] + half, r)
        return (heights[0] if self.gain == "free" else self.half) * shape

    def line(self, slope: float, offset: float) -> Numbers:
        """Return a line within the range; one of slope 1 if the gain is."""
        level = (offset + slope * self.middle,)[: self.first]
        rise = (slope * self.half,)[: len(self.heights())]
        return np.array([*level, *rise, 0.0, self.straight])

    def start(self) -> Numbers:
        """Return the identity but for limits inside the range, where samples are on both sides."""
        made = super().start()
        made[-1] = np.log(np.mean(self.begun))
        return made

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return the limits anywhere."""
        made = self.start()
        made[-2] = rng.uniform(-0.4, 0.4)
        made[-1] = np.log(rng.uniform(*self.begun))
        return made

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the limits in units of the input, gain and output at zero input."""
        centre, half = float(theta[-2]), float(np.exp(np.clip(theta[-1], -SMALLEST, SMALLEST)))
        limits = [self.middle + self.half * (centre + side * half) for side in (-1.0, 1.0)]
        gain = float(theta[self.first]) / self.half if self.gain == "free" else 1.0
        rows = [("lower limit", limits[0], "1"), ("upper limit", limits[1], "1")]
        return [*rows, ("gain", gain, "1"), *self.offset_shown(theta)]


@BLOCKS.register("saturation")
class Saturation(AbstractInterval):
    """Follows its input between two free limits."""

    short = "sat"
    straight = 0.0
    begun = (0.4, 1.0)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """Return the input within the limits."""
        return xp.clip(r, low, high)


@BLOCKS.register("dead-zone")
class DeadZone(AbstractInterval):
    """Answers its input beyond two free limits; a line of it has a zone of a millionth."""

    short = "deadzone"
    straight = -SMALLEST
    begun = (0.02, 0.4)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """Return the distance of the input beyond a limit."""
        return xp.maximum(r - high, 0.0) + xp.minimum(r - low, 0.0)
