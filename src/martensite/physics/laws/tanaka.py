r"""Tanaka law: one martensite fraction, exponential kinetics that never complete.

With u = T - σ/C_M and w = T - σ/C_A, forward for u ≤ M_s and du < 0, reverse for w ≥ A_s and
dw > 0:

    forward  1 - ξ = (1 - ξ₀) exp[-a_M (u₀ - u)],     a_M = 2 ln 10/(M_s - M_f)
    reverse      ξ = ξ₀ exp[-a_A (w - w₀)],           a_A = 2 ln 10/(A_f - A_s)

with u₀ = M_s and w₀ = A_s for a process that starts on its start line. The constants mean that
99 % is done on the finish line; the rest follows beyond it and is not cut off. Young's modulus
is constant, and the constitutive equation is integrated:

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ

Where the strips overlap (C_A > C_M) one process acts: the branch in progress until its finish
line, then the other until its own, else reverse. Θ > 0 means that a free bar shrinks on heating.

Source: Tanaka (1986), Res Mechanica 18, as restated by Kossoski (2018), where ξ₀ in the forward
curve, the signs of the exponents and the temperature width in the stress factors are misprinted;
the original was not seen. The history rules `resume` and `restart` are this package's.
"""

from __future__ import annotations

import math

from martensite.base.parameters import option
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.strips import AbstractStripLaw
from martensite.physics.laws.base import LAWS, Fractions

STEEPNESS = 2.0 * math.log(10.0)
"""Exponent of a whole strip: it leaves 1 %."""


@LAWS.register("tanaka")
class Tanaka(AbstractStripLaw):
    """Tanaka kinetics with a constant Young's modulus."""

    cites = ("tanaka1986", "kossoski2018")
    endless = True

    modulus: str = option("Young's modulus, constant", "austenite", "martensite", default="austenite")

    def left(self, xp: Namespace, distance: Scalar) -> Scalar:
        """exp[-2 ln 10 (1 - distance)]."""
        return xp.exp(-STEEPNESS * (1.0 - distance))

    def young(self, fractions: Fractions) -> Scalar:
        """Young's modulus [Pa] of the chosen phase."""
        return self.E_A if self.modulus == "austenite" else self.E_M
