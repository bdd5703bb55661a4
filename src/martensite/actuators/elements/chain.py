"""Chain: equal links end to end, each with its part of the elongation.

    F = F₁,   x = n x₁,   R = n R₁ (wired in series) or R₁/n (in parallel)

Links wired in parallel need the n-th part of the voltage and n times the current.
"""

from __future__ import annotations

from martensite.actuators.elements.base import ELEMENTS, AbstractElement
from martensite.actuators.elements.rows import AbstractRow
from martensite.base.parameters import part
from martensite.kernels.namespace import Scalar


@ELEMENTS.register("chain")
class LinkChain(AbstractRow):
    """Equal links end to end."""

    link: AbstractElement = part("one of the links", ELEMENTS)

    @property
    def one(self) -> AbstractElement:
        """The link."""
        return self.link

    def behind(self) -> Scalar:
        """Every link gives its part of the elongation."""
        return self.count
