"""Gain y = gain x + offset, and a unit gain without free numbers.

The free numbers are the output in the middle of the range of the input, and the rise over half the range: a fit can
distinguish them for any range. `unit` passes a signal unchanged next to other blocks, as in `[poly2 & unit]`.
"""

from __future__ import annotations

from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.operators.static_curves import AbstractCurve
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("gain")
class Gain(AbstractCurve):
    """A gain and an offset."""

    short = "gain"

    def heights(self) -> tuple[str, ...]:
        return ("rise",)

    def curve(self, xp: Namespace, heights: Column, places: Column, r: Scalar) -> Scalar:
        return heights[0] * r

    def line(self, slope: float, offset: float) -> Numbers:
        return self.join_numbers(offset + slope * self.middle, [slope * self.half])

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return [("gain", float(theta[-1]) / self.half, "1"), *self.offset_shown(theta)]


@BLOCKS.register("unit-gain")
class UnitGain(AbstractBlock):
    """The input itself."""

    short = "unit"

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        return (x[0],), ()
