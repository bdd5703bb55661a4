"""Static blocks with two free limits c ± h, h = exp(log_half), on the scaled input r.

Saturation: a line between two limits, constant beyond them.

    y = a min(max(r, c - h), c + h) + offset

Dead zone: constant between two limits, lines outside.

    y = a d + offset,    d = r - (c + h) above,  r - (c - h) below,  0 between
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
    """Gain times a shape with two limits."""

    gain: str = option("gain", "free", "one", default="free")

    straight: ClassVar[float]
    """log h of a straight line."""
    widths: ClassVar[tuple[float, float]]
    """Range of random h; a fit starts in the middle, where both limits can move."""

    @abstractmethod
    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """Return the shape, of slope 1 where it is a line."""

    def heights(self) -> tuple[str, ...]:
        return ("rise",) if self.gain == "free" else ()

    def places(self) -> tuple[str, ...]:
        return ("centre", "log_half")

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        half = xp.exp(xp.clip(places[1], -SMALLEST, SMALLEST))
        shape = self.shape_input(xp, places[0] - half, places[0] + half, r)
        return (heights[0] if self.gain == "free" else self.half) * shape

    def line(self, slope: float, offset: float) -> Numbers:
        rise = [slope * self.half][: len(self.heights())]
        return self.join_numbers(offset + slope * self.middle, rise, [0.0, self.straight])

    def start(self) -> Numbers:
        theta = super().start()
        theta[-1] = np.log(np.mean(self.widths))
        return theta

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        theta[-2] = rng.uniform(-0.4, 0.4)
        theta[-1] = np.log(rng.uniform(*self.widths))
        return theta

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        centre, half = float(theta[-2]), float(np.exp(np.clip(theta[-1], -SMALLEST, SMALLEST)))
        limits = [self.middle + self.half * (centre + side * half) for side in (-1.0, 1.0)]
        gain = float(theta[self.first]) / self.half if self.gain == "free" else 1.0
        rows = [("lower limit", limits[0], "1"), ("upper limit", limits[1], "1")]
        return [*rows, ("gain", gain, "1"), *self.offset_shown(theta)]


@BLOCKS.register("saturation")
class Saturation(AbstractInterval):
    """The input between two free limits."""

    short = "sat"
    straight = 0.0
    widths = (0.4, 1.0)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        return xp.clip(r, low, high)


@BLOCKS.register("dead-zone")
class DeadZone(AbstractInterval):
    """The input beyond two free limits; a straight line has a zone of a millionth."""

    short = "deadzone"
    straight = -SMALLEST
    widths = (0.02, 0.4)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        return xp.maximum(r - high, 0.0) + xp.minimum(r - low, 0.0)
