"""Free convection from a vertical thin cylinder, after LeFevre and Ede.

    Nu = (4/3) {7 Ra Pr/[5 (20 + 21 Pr)]}^(1/4) + 4 (272 + 315 Pr) l/[35 (64 + 63 Pr) d]

on the length l, for laminar flow. The second term is that of the curvature. For a wire it gives
most of h, which then hardly depends on l; without it h would be that of a plate, several times
too low. At T = T_a it is all that is left, but for the 0.01 K at which |T - T_a| is held.

The wire must hang vertically; for a horizontal one take `churchill-chu` or `morgan`. The
expression is a series in the curvature cut after two terms, so a long thin wire lies at the end
of its range. Source: LeFevre and Ede (1956), as printed by Kossoski (2018), eq. (3.2).
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, Cylinder
from martensite.physics.thermal.buoyancy import AbstractFreeConvection


@COOLING.register("lefevre-ede")
class LeFevreEde(AbstractFreeConvection):
    """Free convection from a vertical wire."""

    cites = ("lefevre-ede", "kossoski2018")

    def size(self, shape: Cylinder) -> Scalar:
        """The length [m]."""
        return shape.length

    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        """Mean Nusselt number on the length [-]."""
        plate = 7.0 * rayleigh * prandtl / (5.0 * (20.0 + 21.0 * prandtl))
        slenderness = shape.length / shape.diameter
        curvature = 4.0 * (272.0 + 315.0 * prandtl) / (35.0 * (64.0 + 63.0 * prandtl))
        return 4.0 / 3.0 * xp.sqrt(xp.sqrt(plate)) + curvature * slenderness
