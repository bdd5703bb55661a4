"""Free convection from a horizontal cylinder, after Morgan: power laws of the Rayleigh number.

| Ra | Nu |
| --- | --- |
| 1e-10 to 1e-2 | 0.675 Ra^0.058 |
| 1e-2 to 1e2 | 1.02 Ra^0.148 |
| 1e2 to 1e4 | 0.850 Ra^0.188 |
| 1e4 to 1e7 | 0.480 Ra^0.250 |
| 1e7 to 1e12 | 0.125 Ra^0.333 |

on the diameter. The exponents rise from row to row, so each law is the largest one in its own range, and Nu here is the
largest of the five: the table without its jumps. At the printed limits two neighbours differ by 0.2 %, 0.2 %, less than
0.1 % and 0.8 %; they meet at Ra = 1.02e-2, 95, 1.01e4 and 1.10e7 instead.

Source: Morgan (1975); the table is that of textbooks, recalled.
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, Cylinder
from martensite.physics.thermal.buoyancy import AbstractFreeConvection

LAWS = ((0.675, 0.058), (1.02, 0.148), (0.850, 0.188), (0.480, 0.250), (0.125, 0.333))
"""(C, n) of Nu = C Raⁿ, in the order of rising Ra."""


@COOLING.register("morgan")
class Morgan(AbstractFreeConvection):
    """Free convection from a horizontal wire, five power laws."""

    cites = ("morgan1975",)

    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        """Mean Nusselt number on the diameter [-]."""
        log = xp.log(rayleigh)
        found = LAWS[0][0] * xp.exp(LAWS[0][1] * log)
        for factor, exponent in LAWS[1:]:
            found = xp.maximum(found, factor * xp.exp(exponent * log))
        return found
