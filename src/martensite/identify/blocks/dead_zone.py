"""Dead zone: no answer between two limits, a line outwards from each.

    y = a d + offset,    d = r - (c + h) above,  r - (c - h) below,  0 between,    h = exp(log_half)

r is the input on the scale of its range. Both limits and the gain are free; the lower limit is
below the upper one whatever the free numbers are.
"""

from __future__ import annotations

from martensite.identify.blocks.base import BLOCKS
from martensite.identify.operators.limits import SMALLEST, AbstractInterval
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("dead-zone")
class DeadZone(AbstractInterval):
    """Answers its input beyond two free limits; a line of it has a zone of a millionth."""

    short = "deadzone"
    straight = -SMALLEST
    begun = (0.02, 0.4)

    def shape_input(self, xp: Namespace, low: Scalar, high: Scalar, r: Scalar) -> Scalar:
        """How far the input is beyond a limit."""
        return xp.maximum(r - high, 0.0) + xp.minimum(r - low, 0.0)
