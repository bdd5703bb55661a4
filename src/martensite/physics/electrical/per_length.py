"""Resistance of a phase mixture from values per metre, as wire tables give them."""

from __future__ import annotations

from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import RESISTANCES, AbstractResistance, Conductor


@RESISTANCES.register("per-length")
class PerLengthResistance(AbstractResistance):
    """Linear mixture of two resistances per metre; independent of the diameter."""

    r_A: Scalar = param("ohm/m", "resistance per metre of austenite", above=0.0, high=1e6, typical="20 ohm/m")
    r_M: Scalar = param("ohm/m", "resistance per metre of martensite", above=0.0, high=1e6, typical="23 ohm/m")

    def resistance(
        self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar, shape: Conductor
    ) -> Scalar:
        """R [ohm]."""
        return (self.r_A + fraction * (self.r_M - self.r_A)) * shape.length
