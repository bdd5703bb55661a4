"""Straight wire: stress = force/section, strain = elongation/length.

Geometry enters at its nominal size (no lateral contraction).
"""

from __future__ import annotations

from martensite.actuators.elements.base import ELEMENTS, Spring
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.actuators.elements.round_wire import AbstractRoundWire
from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import Fractions


@ELEMENTS.register("wire")
class Wire(AbstractRoundWire, AbstractLumped, init=False):
    """A straight wire that transforms uniformly along its length."""

    length: Scalar = param("m", "length at zero strain", above=0.0, high=1e3, typical="200 mm")

    def wire_length(self) -> Scalar:
        """Length of the wire [m]."""
        return self.length

    def spring(self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar) -> Spring:
        """The wire as a linear spring at frozen fractions and temperature [K]."""
        free = self.law.free_strain(xp, fractions, temperature)
        compliance = self.law.compliance(xp, fractions)
        return Spring(free * self.length, compliance * (self.length / self.section()))

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Axial stress [Pa]."""
        return force * (1.0 / self.section())

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Axial strain [-]."""
        return elongation * (1.0 / self.length)
