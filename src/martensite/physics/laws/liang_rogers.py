r"""Liang–Rogers law: one martensite fraction, cosine kinetics.

With u = T - σ/C_M and w = T - σ/C_A, forward in M_f < u < M_s, reverse in A_s < w < A_f:

    forward  1 - ξ = (1 - ξ₀) sin²(θ_M/2)/sin²(θ_M0/2),   θ_M = π (u - M_f)/(M_s - M_f)
    reverse      ξ = ξ₀ cos²(θ_A/2)/cos²(θ_A0/2),         θ_A = π (w - A_s)/(A_f - A_s)

which is the ratio form of the published cosines (exact, and free of 0/0 at the strip ends).
Forward needs du < 0, reverse dw > 0: the sign of dT alone never decides. Constitutive
equation in integrated form, so that elastic loops close:

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ

or, with a transformation stress that is linear in ξ, σ = E ε + Ω ξ + Θ (T - T_ref) and Ω =
-ε_L E(1). The two differ only between the phases, and only if E depends on ξ.

Source: Liang and Rogers (1990), J. Intell. Mater. Syst. Struct. 1. The history rules
`resume` and `restart` are this package's. Θ > 0 means that a free bar shrinks on heating.
"""

from __future__ import annotations

from martensite.base.parameters import option
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.strips import AbstractStripLaw, compute_cosine_rest
from martensite.physics.laws.base import LAWS, Fractions


@LAWS.register("liang-rogers")
class LiangRogers(AbstractStripLaw):
    """Liang–Rogers kinetics with a constant or ξ-dependent Young's modulus."""

    cites = ("liang1990",)

    modulus: str = option(
        "Young's modulus: constant, or the mixture E_A + ξ (E_M - E_A)",
        "austenite",
        "martensite",
        "mixture",
        default="austenite",
    )
    transformation: str = option(
        "what is linear in ξ: the transformation strain ε_L ξ, or the transformation stress Ω ξ",
        "strain",
        "stress",
        default="strain",
    )

    def left(self, xp: Namespace, distance: Scalar) -> Scalar:
        """sin²(π/2 · distance)."""
        return compute_cosine_rest(xp, distance)

    def young(self, fractions: Fractions) -> Scalar:
        """Young's modulus [Pa] by the chosen rule."""
        if self.modulus == "mixture":
            return self.mixture(fractions)
        return self.E_A if self.modulus == "austenite" else self.E_M

    def transformation_strain(self, fractions: Fractions) -> Scalar:
        """ε_L ξ, or -Ω ξ/E with Ω = -ε_L E(1) [-]."""
        strain = super().transformation_strain(fractions)
        if self.transformation == "strain":
            return strain
        return strain * (self.young(Fractions(1.0, 1.0)) / self.young(fractions))
