r"""Elahinia–Ashrafiuon law ("enhanced" model): cosine kinetics, modulus of the phase mixture.

With u = T - σ/C_M and w = T - σ/C_A the conditions of the transformations hold for stress and
temperature that change together:

    forward  du = dT - dσ/C_M < 0  and  M_f < u < M_s
    reverse  dw = dT - dσ/C_A > 0  and  A_s < w < A_f

on the curves of Liang and Rogers, in ratio form:

    forward  1 - ξ = (1 - ξ₀) sin²(θ_M/2)/sin²(θ_M0/2),   θ_M = π (u - M_f)/(M_s - M_f)
    reverse      ξ = ξ₀ cos²(θ_A/2)/cos²(θ_A0/2),         θ_A = π (w - A_s)/(A_f - A_s)

Young's modulus is that of the mixture, and the constitutive equation is integrated:

    ε = [σ - Θ (T - T_ref)]/E(ξ) + ε_L ξ,        E(ξ) = E_A + ξ (E_M - E_A)
    dσ = E dε - ε_L E dξ + (E_M - E_A)(ε - ε_L ξ) dξ + Θ dT

The rate form is often printed without its third term; then it is the differential of no stress
function, and closed loops leave a spurious strain. Both conditions can hold together where the
strips overlap (C_A > C_M), for which the paper has no rule: one process acts, the branch in
progress, else the one met first, else reverse (`martensite.physics.kinetics.history`).

Two statements that are printed about this model: "reduces to Liang–Rogers at constant stress" is
true for ξ; strains agree up to E(ξ), and fully with its option `modulus = "mixture"`. "Reduces
to Brinson when isothermal" is false: it starts to transform at a stress lower by Brinson's start
stress of detwinning, and it does not detwin. Θ > 0 means that a free bar shrinks on heating.

Source: Elahinia and Ashrafiuon (2002), J. Vib. Acoust. 124, as restated by Kossoski (2018); the
original was not seen. The history rules `resume` and `restart` are this package's.
"""

from __future__ import annotations

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.strips import AbstractStripLaw, compute_cosine_rest
from martensite.physics.laws.base import LAWS, Fractions


@LAWS.register("elahinia")
class Elahinia(AbstractStripLaw):
    """Cosine kinetics decided by du and dw, with Young's modulus of the phase mixture."""

    cites = ("elahinia2002", "kossoski2018")

    def left(self, xp: Namespace, distance: Scalar) -> Scalar:
        """sin²(π/2 · distance)."""
        return compute_cosine_rest(xp, distance)

    def young(self, fractions: Fractions) -> Scalar:
        """E_A + ξ (E_M - E_A) [Pa]."""
        return self.mixture(fractions)
