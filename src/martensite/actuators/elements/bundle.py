"""Bundle: equal strands side by side, each with its part of the force.

    F = n F₁,   x = x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

A wire led through a pulley and back is a bundle of two in series. Strands that stand so close
that they warm each other are no bundle but a `ribbon`.
"""

from __future__ import annotations

from martensite.actuators.elements.base import ELEMENTS, AbstractElement
from martensite.actuators.elements.rows import AbstractRow
from martensite.base.parameters import part
from martensite.kernels.namespace import Scalar


@ELEMENTS.register("bundle")
class Bundle(AbstractRow):
    """Equal strands side by side."""

    strand: AbstractElement = part("one of the strands", ELEMENTS)

    @property
    def one(self) -> AbstractElement:
        """The strand."""
        return self.strand

    def beside(self) -> Scalar:
        """Every strand carries its part of the force."""
        return self.count
