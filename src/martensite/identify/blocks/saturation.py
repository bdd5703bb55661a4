"""Saturation: a line between two limits, constant beyond them.

    y = a min(max(r, c - h), c + h) + offset,    h = exp(log_half)

r is the input on the scale of its range. Both limits and the gain are free; the lower limit is
below the upper one whatever the free numbers are.
"""

from __future__ import annotations

from martensite.identify.blocks.base import BLOCKS
from martensite.identify.operators.limits import AbstractInterval
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("saturation")
class Saturation(AbstractInterval):
    """Follows its input between two free limits."""

    short = "sat"
    straight = 0.0
    begun = (0.4, 1.0)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """The input within the limits."""
        return xp.clip(r, low, high)
