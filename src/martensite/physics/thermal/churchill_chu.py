"""Free convection from a horizontal cylinder, after Churchill and Chu.

    Nu = {0.60 + 0.387 Ra^(1/6)/[1 + (0.559/Pr)^(9/16)]^(8/27)}²

on the diameter, for Ra from 1e-5 to 1e12: one smooth curve through laminar and turbulent flow.
In still air it agrees with `morgan` for wires near 0.2 mm; 60 K above the surroundings it lies
11 % lower at 0.381 mm, 19 % lower at 1 mm and 11 % higher at 0.038 mm.

Source: Churchill and Chu (1975); the equation is that of textbooks, recalled.
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, Cylinder
from martensite.physics.thermal.buoyancy import AbstractFreeConvection, raise_constant


@COOLING.register("churchill-chu")
class ChurchillChu(AbstractFreeConvection):
    """Free convection from a horizontal wire, one smooth curve."""

    cites = ("churchill1975",)

    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        """Mean Nusselt number on the diameter [-]."""
        damping = raise_constant(xp, 1.0 + raise_constant(xp, 0.559 / prandtl, 9.0 / 16.0), 8.0 / 27.0)
        root = 0.60 + 0.387 * raise_constant(xp, rayleigh, 1.0 / 6.0) / damping
        return root * root
