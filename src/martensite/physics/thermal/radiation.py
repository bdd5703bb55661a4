"""Radiation to surroundings at the ambient temperature, as a film coefficient.

    h = ε σ_SB (T² + T_a²)(T + T_a)          so that   h (T - T_a) = ε σ_SB (T⁴ - T_a⁴)

for a grey surface that is small beside what it sees. h → 4 ε σ_SB T³ as T_a → T. It is about 6 W/(m² K) for a black
wire at room temperature: little beside the convection from a thin wire. Combine it with that by `combined`.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder

STEFAN_BOLTZMANN = 5.670374419e-8
"""σ_SB [W/(m² K⁴)]"""


@COOLING.register("radiation")
class Radiation(AbstractCooling):
    """Radiation of a grey wire to its surroundings."""

    emissivity: Scalar = param("1", "emissivity of the surface", low=0.0, high=1.0, typical=0.6)

    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        """h [W/(m² K)]; the shape does not matter."""
        squares = temperature * temperature + ambient * ambient
        return self.emissivity * STEFAN_BOLTZMANN * squares * (temperature + ambient)
