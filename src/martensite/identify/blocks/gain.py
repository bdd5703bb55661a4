"""Straight line: y = gain x + offset.

Free numbers are the output in the middle of the range of the input and the rise over half of
it, which a fit can tell apart wherever the range lies.

Unit gain: the output is the input.

It has no free numbers, and no offset: it stands beside other blocks where a signal is to pass
unchanged, such as `[poly2 & unit]`.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("gain")
class Gain(AbstractCurve):
    """A gain and an offset."""

    short = "gain"

    def heights(self) -> tuple[str, ...]:
        """Return the rise over half the range."""
        return ("rise",)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        """Return the line through 0 in the middle of the range."""
        return heights[0] * r

    def line(self, slope: float, offset: float) -> Numbers:
        """Return every line."""
        rise = slope * self.half
        return np.array([offset + slope * self.middle, rise] if self.first else [rise])

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the gain, and the output at zero input."""
        return [("gain", float(theta[-1]) / self.half, "1"), *self.offset_shown(theta)]


@BLOCKS.register("unit-gain")
class UnitGain(AbstractBlock):
    """Passes its signal on."""

    short = "unit"

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the input of this sample."""
        return (x[0],), ()
