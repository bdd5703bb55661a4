"""Wavelet network: y = offset + L r + Σ_i a_i ψ(b_i (r - c_i)), ψ(q) = (1 - q²) exp(-q²/2).

r is the input on the scale of its range, -1 to 1. Beyond its units it goes on as a line. Units
start on a dyadic frame, levels of 1, 2, 4, … of them, each half as wide as those before, with
height 0; what does not fill a level is spread evenly over it.

Source: Zhang and Benveniste 1992.
"""

from __future__ import annotations

import numpy as np

from martensite.identify.blocks.base import BLOCKS, Numbers
from martensite.identify.operators.networks import AbstractNetwork
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("wavelet-network")
class WaveletNetwork(AbstractNetwork):
    """A line and ripples of free height, width and place, coarse and fine."""

    short = "wavelet"
    cites = ("zhang1992",)

    def unit_shape(self, xp: Namespace, q: Scalar) -> tuple[Scalar, Scalar]:
        """The second derivative of a bell, upside down."""
        square = q * q
        bell = xp.exp(-0.5 * square)
        return (1.0 - square) * bell, (square - 3.0) * q * bell

    def frame(self) -> tuple[Numbers, Numbers]:
        """b = 2.5 · 2^l / range at the 2^l places of level l."""
        steep: list[float] = []
        centres: list[float] = []
        level, left = 0, int(self.units)
        while left > 0:
            full = 2**level
            count = min(full, left)
            places = np.floor((np.arange(count) + 0.5) * full / count)
            centres += [*((2.0 * places + 1.0) / full - 1.0)]
            steep += [float(np.log(1.25 * full))] * count
            level, left = level + 1, left - count
        return np.array(steep), np.array(centres)
