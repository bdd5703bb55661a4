"""Resistance of a phase mixture from resistivities: R = [ρ_A + ξ (ρ_M - ρ_A)] l/A.

Both resistivities are parameters: published tables and measurements disagree on the sign of
their difference, so none is assumed.
"""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import RESISTANCES, AbstractResistance, Conductor


@RESISTANCES.register("mixture")
class MixtureResistance(AbstractResistance):
    """Linear mixture of two resistivities; geometry at its nominal size."""

    rho_A: Scalar = param("ohm*m", "resistivity of austenite", above=0.0, high=1e-4, typical="8e-7 ohm m")
    rho_M: Scalar = param("ohm*m", "resistivity of martensite", above=0.0, high=1e-4, typical="9e-7 ohm m")

    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """R [ohm]."""
        return (self.rho_A + fraction * (self.rho_M - self.rho_A)) * (shape.length / shape.area)
