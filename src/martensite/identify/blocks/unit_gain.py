"""Unit gain: the output is the input.

It has no free numbers, and no offset: it stands beside other blocks where a signal is to pass
unchanged, such as `[poly2 & unit]`.
"""

from __future__ import annotations

from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("unit-gain")
class UnitGain(AbstractBlock):
    """Passes its signal on."""

    short = "unit"

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """The input of this sample."""
        return (x[0],), ()
