"""Constant film coefficient: Q = h S (T - T_a)."""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder


@COOLING.register("constant")
class ConstantCooling(AbstractCooling):
    """A film coefficient that depends on nothing."""

    h: Scalar = param("W/m^2/K", "film coefficient", low=0.0, high=1e5, typical="100 W/m^2/K")

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """The constant h [W/(m² K)]."""
        return self.h
