"""Two heat losses at once: h = h₁ + h₂, both to the same ambient temperature.

Meant for convection and radiation, but any two models may stand here, another `combined` among them.
"""

from __future__ import annotations

from martensite.base.parameters import part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder


@COOLING.register("combined")
class CombinedCooling(AbstractCooling):
    """The sum of two heat-loss models, as convection and radiation."""

    convection: AbstractCooling = part("one heat-loss model", COOLING, typical="churchill-chu")
    radiation: AbstractCooling = part("the other heat-loss model", COOLING, typical="radiation")

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)], the sum of both."""
        given = temperature, ambient, shape
        return self.convection.film(xp, *given) + self.radiation.film(xp, *given)
