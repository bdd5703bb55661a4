"""Laws with one martensite fraction and two strips: Liang–Rogers, Tanaka, Elahinia–Ashrafiuon.

With u = T - σ/C_M and w = T - σ/C_A they share the strips and the constitutive equation of
`martensite.physics.kinetics.strips`, in integrated form so that elastic loops close,

    ε = [σ - Θ (T - T_ref)]/E + ε_L ξ,

and differ in their curves and in Young's modulus E. Forward requires du = dT - dσ/C_M < 0, reverse dw = dT - dσ/C_A >
0; the sign of dT alone does not decide. Θ > 0 means that a free bar shrinks on heating. The cosines in ratio form
(exact, without 0/0 at the strip ends) are

    forward  1 - ξ = (1 - ξ₀) sin²(θ_M/2)/sin²(θ_M0/2),   θ_M = π (u - M_f)/(M_s - M_f),   M_f < u < M_s
    reverse      ξ = ξ₀ cos²(θ_A/2)/cos²(θ_A0/2),         θ_A = π (w - A_s)/(A_f - A_s),   A_s < w < A_f

The history rules `resume` and `restart` are this package's (`martensite.physics.kinetics.history`). If the strips
overlap (C_A > C_M), one process acts: the branch in progress, else the process met first, else reverse.
"""

import math

from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.physics.kinetics.diagram import AbstractShapes
from martensite.physics.kinetics.hardening import invert_hardening, remove_waist
from martensite.physics.kinetics.strip_legs import StripCurve
from martensite.physics.kinetics.strips import AbstractCosineLaw, AbstractStripLaw
from martensite.physics.laws.base import LAWS, Fractions


@LAWS.register("liang-rogers")
class LiangRogers(AbstractCosineLaw, AbstractShapes):
    """Liang–Rogers kinetics (cosines) with a constant or ξ-dependent Young's modulus.

    With a transformation stress linear in ξ, σ = E ε + Ω ξ + Θ (T - T_ref) and Ω = -ε_L E(1). This differs only between
    the phases, and only if E depends on ξ.

    Source: Liang and Rogers (1990), J. Intell. Mater. Syst. Struct. 1.
    """

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

    hardening: str = option(
        "how ξ runs over a strip: as a cosine, or as `lagoudas` has it, rounded by n_1 to n_4, or waisted as well",
        "cosine",
        "smooth",
        "waisted",
        default="cosine",
    )
    surfaces: str = option(
        "lines of the strips: straight, or bent and spread by stress with four numbers",
        "straight",
        "curved",
        default="straight",
    )
    sigma_cal: Number = param("Pa", "stress at which C_A and C_M hold, if curved", low=0.0, high=2e9, default=0.0)

    def remaining_fraction_of(self, xp: Namespace, distance: Scalar, ahead: Flag) -> Scalar:
        """Return sin²(π/2 · distance), or 1 - ξ with h(ξ) = 1 - distance forward, ξ with h(ξ) = distance reverse."""
        if self.hardening == "cosine":
            return self.remaining_fraction(xp, distance)
        forward, reverse = (self.n_2, self.n_1, self.waist_f), (self.n_3, self.n_4, self.waist_r)
        first, last, waist = (xp.where(ahead, *pair) for pair in zip(forward, reverse, strict=True))
        share = remove_waist(xp, distance, waist) if self.hardening == "waisted" else distance
        return invert_hardening(xp, share, first, last)

    @override
    def curves(self) -> tuple[StripCurve | tuple[()], StripCurve | tuple[()]]:
        if self.surfaces == "straight":
            return (), ()
        return (
            StripCurve(self.curvature_f, self.sigma_cal, self.widening_f),
            StripCurve(self.curvature_r, self.sigma_cal, -self.widening_r),
        )

    @override
    def cautions(self) -> list[str]:
        cautions = super().cautions() + self.describe_unused(self.hardening, self.surfaces)
        for name, slope, curve in zip(("M_f", "A_s"), (self.C_M, self.C_A), self.curves(), strict=True):
            falls = _find_fall(slope, curve) if curve else None
            if falls is not None:
                cautions.append(
                    f"Above {falls / 1e6:.4g} MPa `{name}` falls with stress: true of cycles at constant stress, not "
                    "shown for loading at constant temperature."
                )
        return cautions

    @override
    def young(self, fractions: Fractions) -> Scalar:
        if self.modulus == "mixture":
            return self.mixture(fractions)
        return self.E_A if self.modulus == "austenite" else self.E_M

    def transformation_strain(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return ε_L ξ, or -Ω ξ/E with Ω = -ε_L E(1) [-]."""
        strain = super().transformation_strain(xp, fractions)
        if self.transformation == "strain":
            return strain
        return strain * (self.young(Fractions(1.0, 1.0)) / self.young(fractions))


ENOUGH = 2e9
"""Highest stress [Pa] at which falling lines are reported."""


def _find_fall(slope: float, curve: StripCurve) -> float | None:
    """Return the stress [Pa] above which the cool end of a strip falls; 1/C + 2c (σ - σ_cal) - w/2 is linear."""
    rate, more = 1.0 / slope - 2.0 * curve.bend * curve.calm - 0.5 * abs(curve.growth), 2.0 * curve.bend
    if rate < 0.0:
        return 0.0
    falls = -rate / more if more < 0.0 else ENOUGH
    return falls if falls < ENOUGH else None


STEEPNESS = 2.0 * math.log(10.0)
"""Exponent of a whole strip, which leaves 1 %."""


@LAWS.register("tanaka")
class Tanaka(AbstractStripLaw):
    """Tanaka kinetics with a constant Young's modulus.

        forward  1 - ξ = (1 - ξ₀) exp[-a_M (u₀ - u)],     a_M = 2 ln 10/(M_s - M_f),     u ≤ M_s
        reverse      ξ = ξ₀ exp[-a_A (w - w₀)],           a_A = 2 ln 10/(A_f - A_s),     w ≥ A_s

    with u₀ = M_s and w₀ = A_s for a process that starts on its start line. 99 % is complete on the finish line; the
    tail beyond it is not cut off. If the strips overlap, the branch in progress continues to its finish line, then the
    other to its own.

    Source: Tanaka (1986), Res Mechanica 18, as restated by Kossoski (2018), where ξ₀ in the forward curve, the signs of
    the exponents and the temperature width in the stress factors are misprinted; the original was not seen.
    """

    cites = ("tanaka1986", "kossoski2018")
    endless = True

    modulus: str = option("Young's modulus, constant", "austenite", "martensite", default="austenite")

    def remaining_fraction(self, xp: Namespace, distance: Scalar) -> Scalar:
        """Return exp[-2 ln 10 (1 - distance)]."""
        return xp.exp(-STEEPNESS * (1.0 - distance))

    @override
    def young(self, fractions: Fractions) -> Scalar:
        return self.E_A if self.modulus == "austenite" else self.E_M


@LAWS.register("elahinia")
class Elahinia(AbstractCosineLaw):
    """Cosine kinetics decided by du and dw, with Young's modulus of the phase mixture.

        E(ξ) = E_A + ξ (E_M - E_A)
        dσ = E dε - ε_L E dξ + (E_M - E_A)(ε - ε_L ξ) dξ + Θ dT

    The rate form is often printed without its third term. It then is not the differential of a stress function, and
    closed loops leave a spurious strain. The paper has no rule for overlapping strips.

    Two printed statements about this model: "reduces to Liang–Rogers at constant stress" is true for ξ; strains agree
    up to E(ξ), and fully with the option `modulus = "mixture"`. "Reduces to Brinson when isothermal" is false:
    transformation starts at a stress lower by Brinson's start stress of detwinning, and there is no detwinning.

    Source: Elahinia and Ashrafiuon (2002), J. Vib. Acoust. 124, as restated by Kossoski (2018); the original was not
    seen.
    """

    cites = ("elahinia2002", "kossoski2018")
