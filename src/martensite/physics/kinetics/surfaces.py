"""Transformation surfaces of the Boyd–Lagoudas model, and their calibration.

With ΔS = 1/E_M - 1/E_A, the current transformation strain H(σ) and the hardening functions h of
`martensite.physics.kinetics.hardening`, transformation requires (forward; reverse, with Λ = ε_t/ξ)

    (1 - D) H σ + ½ ΔS σ² + ρΔs₀ T - ρΔu₀ - a₁ h_f(ξ) - a₃ - Y₀ = 0
    (1 + D) Λ σ + ½ ΔS σ² + ρΔs₀ T - ρΔu₀ - a₂ h_r(ξ) + a₃ + Y₀ = 0

Seven constants follow from measured quantities. At σ = 0 the surfaces lie at M_s (ξ = 0) and M_f (ξ = 1), at A_f (ξ =
0) and A_s (ξ = 1):

    a₁ = ρΔs₀ (M_f - M_s),   a₂ = ρΔs₀ (A_s - A_f),   ρΔu₀ = ½ ρΔs₀ (M_s + A_f),
    Y₀ + a₃ = ½ ρΔs₀ (M_s - A_f),

and equal hardening energy in both directions, ∫(a₁ h_f + a₃) dξ = ∫(a₂ h_r - a₃) dξ, gives the last:

    4 a₃ = a₂ (1 + 1/(n₃+1) - 1/(n₄+1)) - a₁ (1 + 1/(n₁+1) - 1/(n₂+1))

or, with other functions h, 2 a₃ = a₂ ∫h_r dξ - a₁ ∫h_f dξ. At σ_cal the lines of constant ξ have the slopes dσ/dT = C_M
and C_A. With G = d(Hσ)/dσ there (Λ = H(σ): cycles at constant stress), -ρΔs₀ = C_M [(1-D) G + σ ΔS] = C_A [(1+D) G + σ
ΔS], so

    ρΔs₀ = -2 C_M C_A (G + σ ΔS)/(C_M + C_A),     D = (C_M - C_A)(G + σ ΔS)/[(C_M + C_A) G].

Divided by ρΔs₀ the surfaces are temperatures: forward runs while T - s_f(σ) falls below M_s - (M_s - M_f) h_f, reverse
while T - s_r(σ, Λ) rises above A_f - (A_f - A_s) h_r. Tension is positive; in compression H = H_min without the elastic
term, so that stress never works against martensite.

Measured loops have neither straight lines nor constant widths. With the option `surfaces = "curved"`, for tension, M =
½ (M_s + M_f) and A = ½ (A_s + A_f),

    forward   M + s_f(σ) + c_f σ (σ - 2 σ_cal) - T = (h_f - ½) (M_s - M_f + w_f σ)
    reverse   A + s_r(σ, Λ) + c_r σ (σ - 2 σ_cal) - T = (h_r - ½) (A_f - A_s + w_r σ)

with c = `curvature`, w = `widening`: c bends the middle line and w widens the range; temperatures at zero stress and
slopes at σ_cal keep their meaning.

Sources: Boyd and Lagoudas (1996); Lagoudas et al. (2012), Int. J. Plasticity 32–33, with the smooth hardening of Hartl
and Lagoudas; derivation by this package. The options `hardening = "waisted"` (`martensite.physics.kinetics.hardening`)
and `surfaces = "curved"` are this package's extensions.
"""

from collections.abc import Iterator
from typing import NamedTuple, Self

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp
from martensite.physics.kinetics.asymmetry import NONE
from martensite.physics.kinetics.diagram import WIDTHS, AbstractShapes, AbstractSidedLaw, require_order
from martensite.physics.kinetics.hardening import apply_waist, compute_hardening, remove_waist, waist_energy
from martensite.physics.laws.base import Doubt

SAMPLES = 201
"""Fractions at which the order of the surfaces is checked."""
SOUGHT, STEPS = 25e6, 40
"""Step [Pa] and number of stresses at which curved surfaces are checked."""
MEETING, PEAK = 6, 8
"""Newton steps."""


class Constants(NamedTuple):
    """Calibrated constants, in the symbols of the module's equations."""

    rho_Delta_s0: Scalar
    """Entropy difference per volume, martensite less austenite [J/m³/K]; negative."""
    rho_Delta_u0: Scalar
    """Difference of internal energy per volume [J/m³]."""
    a_1: Scalar
    a_2: Scalar
    a_3: Scalar
    """Hardening [J/m³]."""
    Y_0: Scalar
    """Dissipation threshold at zero stress [J/m³]."""
    D: Scalar
    """Growth of the threshold with the work of transformation [-]."""


class WorkScale(NamedTuple):
    """Factors from work to temperature shifts."""

    forward: Scalar
    """(1 - D)/(-ρΔs₀) [m³ K/J]."""
    reverse: Scalar
    """(1 + D)/(-ρΔs₀) [m³ K/J]."""
    elastic: Scalar
    """ΔS/(-ρΔs₀) [K/Pa²]."""


class StraightPath(NamedTuple):
    """Straight path in stress [Pa] and temperature [K]: start and total change."""

    stress: Scalar
    temperature: Scalar
    more: Scalar
    warmer: Scalar

    @classmethod
    def between(cls, start: tuple[Scalar, Scalar], end: tuple[Scalar, Scalar]) -> Self:
        """Return the path between two points of stress [Pa] and temperature [K]."""
        return cls(*start, end[0] - start[0], end[1] - start[1])

    def at(self, part: Scalar) -> tuple[Scalar, Scalar]:
        """Return the stress [Pa] and temperature [K] after a fraction of the path."""
        return self.stress + part * self.more, self.temperature + part * self.warmer


class TransformationRange(NamedTuple):
    """Temperatures of a surface under a stress."""

    start: Scalar
    """Highest temperature at zero stress [K]."""
    shift: Scalar
    """Shift by stress [K]."""
    width: Scalar
    """From the lowest to the highest temperature [K]."""

    def share(self, temperature: Scalar) -> Scalar:
        """Return the unlimited hardening function h [-] at a temperature."""
        return (self.start - temperature + self.shift) / self.width

    def temperature(self, share: Scalar) -> Scalar:
        """Return the temperature [K] of a value of h."""
        return self.start + self.shift - self.width * share


class AbstractSurfaceLaw(AbstractSidedLaw, AbstractShapes):
    """Parameters, constants and surfaces; subclasses add memory and flow."""

    orders = (*WIDTHS, ("M_f", "A_s"), ("M_s", "A_f"))

    C_A: Number = param("Pa/K", "slope of the reverse surface at sigma_cal", low=1e5, high=1e9, typical="8 MPa/K")
    C_M: Number = param("Pa/K", "slope of the forward surface at sigma_cal", low=1e5, high=1e9, typical="8 MPa/K")
    sigma_cal: Number = param("Pa", "stress at which both slopes hold", low=0.0, high=2e9, typical="150 MPa")
    H_min: Number = param("1", "transformation strain up to sigma_crit", low=0.0, high=0.2, typical=0.05)
    H_sat: Number = param("1", "transformation strain at high stress", above=0.0, high=0.2, typical=0.05)
    H_sat_compression: Number = param("1", "H_sat in compression; 0: as in tension", low=0.0, high=0.2, default=0.0)
    H_k: Number = param("1/Pa", "rate at which H approaches H_sat", low=0.0, high=1e-5, typical="2e-8 1/Pa")
    sigma_crit: Number = param("Pa", "stress at which H begins to grow", low=0.0, high=1e9, default=0.0)
    hardening: str = option(
        "shape of the shares h(ξ): smooth, or drawn together in the middle by `waist_f`, `waist_r`",
        "smooth",
        "waisted",
        default="smooth",
    )
    surfaces: str = option(
        "what stress does to the surfaces: shifts them by its work, or also bends and widens them by four numbers",
        "work",
        "curved",
        default="work",
    )

    # These laws have no kinks. In a trial of 12 runs, kinks saved half of the rejected steps, but the error of one
    # sample next to the start of a reverse transformation was 1.2 times its bound.
    sided = (*AbstractSidedLaw.sided, "H_sat")
    by_ratios = False

    def on_side(self, xp: Namespace, side: Scalar) -> Self:
        """Return the law of tension [+1] or compression [-1]; unoriented martensite counts as tension."""
        law = super().on_side(xp, side)
        law.__dict__.update(H_min=side * self.H_min, reorients=self.compression != NONE)
        return law

    @override
    def check(self) -> None:
        require_order(self, *self.orders)
        if self.H_min > self.H_sat:
            raise ParameterError(
                f"Parameter `H_min` of `lagoudas` must not exceed `H_sat`, but is {self.H_min} against {self.H_sat}."
            )
        sides = (1.0,) if self.compression == NONE else (1.0, -1.0)
        if not all(self.on_side(floats, side)._work(floats, self.sigma_cal) > 0.0 for side in sides):
            raise ParameterError(
                "Parameter `sigma_cal` of `lagoudas` must be a stress at which H(sigma)*sigma "
                f"grows, but is {self.sigma_cal} Pa, where H = {self.H_min}."
            )
        constants = self.constants(floats)
        if not (constants.rho_Delta_s0 < 0.0 and abs(constants.D) < 1.0):
            raise ParameterError(
                "Parameters `C_A` and `C_M` of `lagoudas` must give an entropy difference below 0 "
                f"and a ratio D between -1 and 1, but give {constants.rho_Delta_s0:.4g} J/m^3/K "
                f"and {constants.D:.4g}; bring `C_A` nearer to `C_M`, or `E_M` nearer to `E_A`."
            )
        if self.gap() <= 0.0:
            raise ParameterError(
                "Parameters `n_1` to `n_4` of `lagoudas` must keep the reverse surface above the "
                f"forward surface at every fraction, but let them cross by {-self.gap():.3g} K."
            )

    def gap(self) -> float:
        """Return the smallest distance from the forward to the reverse surface at zero stress [K]."""
        return next(self._find_gaps(0.0))

    def _find_gaps(self, *stresses: float) -> Iterator[float]:
        """Yield the smallest distance [K] at each stress [Pa], for cycles at this stress."""
        parts = [i / (SAMPLES - 1) for i in range(SAMPLES)]
        shares = [(self.forward_hardening(floats, xi), self.reverse_hardening(floats, xi)) for xi in parts]
        scale = self.scale(floats)
        for stress in stresses:
            forward = self._forward_line(floats, scale, stress)
            reverse = self._reverse_line(floats, scale, self.current(floats, stress), stress)
            yield min(reverse.temperature(back) - forward.temperature(forth) for forth, back in shares)

    def cautions(self) -> list[str]:
        """Return cautions about stiff martensite, unused parameters and falling finish temperatures."""
        cautions = ["E_M is above E_A: martensite is usually the softer phase."] if self.E_M > self.E_A else []
        cautions += self.describe_unused(self.hardening, self.surfaces)
        falling = self._find_falling_finish()
        if falling is not None:
            cautions.append(
                f"Above {falling / 1e6:.4g} MPa a range widens faster than stress shifts it, so that M_f or A_s falls: "
                "true of cycles at constant stress, not shown for loading at constant temperature."
            )
        return cautions

    def _find_falling_finish(self) -> float | None:
        """Return the stress [Pa] above which M_f or A_s falls, for cycles at this stress; None if nowhere."""
        scale, before = self.scale(floats), (self.M_f, self.A_s)
        for k in range(1, STEPS + 1 if self.surfaces == "curved" else 1):
            at = k * SOUGHT
            reverse = self._reverse_line(floats, scale, self.current(floats, at), at)
            ends = self._forward_line(floats, scale, at).temperature(1.0), reverse.temperature(1.0)
            if min(b - a for a, b in zip(before, ends, strict=True)) < 0.0:
                return at - SOUGHT
            before = ends
        return None

    def doubt(self) -> Doubt | None:
        """Return a doubt if the surfaces meet under stress."""
        if self.surfaces == "curved":
            stresses = [k * SOUGHT for k in range(1, STEPS + 1)]
            pairs = zip(stresses, self._find_gaps(*stresses), strict=True)
            limit = next((stress for stress, gap in pairs if gap <= 0.0), 0.0)
            text = f"forward and reverse surface meet at about {limit / 1e6:.4g} MPa, where loops lose their width."
            return Doubt(limit, text) if limit else None
        constants = self.constants(xp)
        if not constants.D < 0.0:
            return None
        limit = constants.rho_Delta_s0 * self.gap() / (2.0 * constants.D * self.H_sat)
        return Doubt(
            limit,
            f"C_A > C_M: forward and reverse surface meet above {limit / 1e6:.4g} MPa, where "
            "loops lose their width; prefer equal slopes there.",
        )

    def constants(self, xp: Namespace) -> Constants:
        """Return the seven constants, from temperatures at zero stress and slopes at `sigma_cal`."""
        work = self._work(xp, self.sigma_cal)
        softer = work + self.sigma_cal * self.softening()
        share = softer / (self.C_M + self.C_A)
        entropy = -2.0 * self.C_M * self.C_A * share
        a_1 = entropy * (self.M_f - self.M_s)
        a_2 = entropy * (self.A_s - self.A_f)
        forward = 1.0 + 1.0 / (self.n_1 + 1.0) - 1.0 / (self.n_2 + 1.0)
        reverse = 1.0 + 1.0 / (self.n_3 + 1.0) - 1.0 / (self.n_4 + 1.0)
        if self.hardening == "waisted":
            forward = forward + self.waist_f * waist_energy(xp, self.n_1, self.n_2)
            reverse = reverse + self.waist_r * waist_energy(xp, self.n_3, self.n_4)
        a_3 = 0.25 * (a_2 * reverse - a_1 * forward)
        energy = 0.5 * entropy * (self.M_s + self.A_f)
        threshold = 0.5 * entropy * (self.M_s - self.A_f) - a_3
        return Constants(entropy, energy, a_1, a_2, a_3, threshold, (self.C_M - self.C_A) * share / work)

    def scale(self, xp: Namespace) -> WorkScale:
        """Return the factors of the surfaces."""
        constants = self.constants(xp)
        per_entropy = -1.0 / constants.rho_Delta_s0
        return WorkScale(
            forward=(1.0 - constants.D) * per_entropy,
            reverse=(1.0 + constants.D) * per_entropy,
            elastic=self.softening() * per_entropy,
        )

    def current(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return H(σ) [-], the strain of martensite that forms under a stress [Pa]."""
        excess = xp.maximum(stress - self.sigma_crit, 0.0)
        return self.H_min + (self.H_sat - self.H_min) * (1.0 - xp.exp(-self.H_k * excess))

    def trained_share(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return H(σ)/H_sat [-]."""
        if self.compression == NONE:
            return self.current(xp, stress) / self.H_sat
        side = xp.where(stress < 0.0, -1.0, 1.0)
        return side * self.on_side(xp, side).trained_share(xp, side * stress)

    def forward_hardening(self, xp: Namespace, fraction: Scalar) -> Scalar:
        """Return h_f(ξ) [-]."""
        share = compute_hardening(xp, fraction, self.n_1, self.n_2)
        return apply_waist(share, self.waist_f) if self.hardening == "waisted" else share

    def reverse_hardening(self, xp: Namespace, fraction: Scalar) -> Scalar:
        """Return h_r(ξ) [-]."""
        share = compute_hardening(xp, fraction, self.n_3, self.n_4)
        return apply_waist(share, self.waist_r) if self.hardening == "waisted" else share

    def smooth(self, xp: Namespace, share: Scalar, waist: Scalar) -> Scalar:
        """Return h [-] of smooth hardening for a value with waist."""
        return remove_waist(xp, share, waist) if self.hardening == "waisted" else share

    def forward_share(self, xp: Namespace, scale: WorkScale, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the unlimited h_f that forward transformation would reach at (σ, T) [-]."""
        return self._forward_line(xp, scale, stress).share(temperature)

    def reverse_share(
        self, xp: Namespace, scale: WorkScale, strain: Scalar, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        """Return the unlimited h_r that reverse transformation of martensite of strain Λ would leave [-]."""
        return self._reverse_line(xp, scale, strain, stress).share(temperature)

    def _forward_line(self, xp: Namespace, scale: WorkScale, stress: Scalar) -> TransformationRange:
        shift = scale.forward * self.current(xp, stress) * stress
        return self._place_range(xp, scale, (self.M_f, self.M_s), shift, stress, self.curvature_f, self.widening_f)

    def _reverse_line(self, xp: Namespace, scale: WorkScale, strain: Scalar, stress: Scalar) -> TransformationRange:
        shift = scale.reverse * strain * stress
        return self._place_range(xp, scale, (self.A_s, self.A_f), shift, stress, self.curvature_r, self.widening_r)

    def _place_range(
        self,
        xp: Namespace,
        scale: WorkScale,
        ends: tuple[Scalar, Scalar],
        shift: Scalar,
        stress: Scalar,
        curvature: Scalar,
        widening: Scalar,
    ) -> TransformationRange:
        """Return a range at a stress [Pa]; `ends` [K] hold at zero stress, `shift` [K] is by work."""
        low, high = ends
        tension = xp.maximum(stress, 0.0)
        shift = shift + 0.5 * scale.elastic * tension * tension
        width = high - low
        if self.surfaces == "curved":
            growth = widening * tension
            shift = shift + curvature * tension * (tension - 2.0 * self.sigma_cal) + 0.5 * growth
            width = width + growth
        return TransformationRange(high, shift, width)

    def forward_meeting(self, xp: Namespace, scale: WorkScale, way: StraightPath, share: Scalar) -> Scalar:
        """Return the fraction of a path at which `forward_share` rises beyond a value; 1 if nowhere.

        The search starts at the end of the path, because the value may fall before it rises.
        """

        def beyond(xp: Namespace, part: Scalar) -> Scalar:
            return self.forward_share(xp, scale, *way.at(part)) - share + 1e-13 * part  # avoids a zero slope

        rises = self.forward_share(xp, scale, *way.at(1.0)) > share
        part = solve_bracketed(xp, beyond, 1.0, (-1.0, 2.0), MEETING, rises)
        return xp.where(rises, xp.clip(part, 0.0, 1.0), 1.0)

    def forward_peak(self, xp: Namespace, scale: WorkScale, way: StraightPath) -> Scalar:
        """Return the fraction of a path at which `forward_share` may have a maximum inside.

        Over t = k σ the slope of s_f falls at most near t = 3; from there Newton's iteration to the slope of the leg is
        monotone. Without a maximum any point is valid. A maximum below sigma_crit (E_M above E_A) is not found, and a
        widening range uses the peak of its middle: both are errors of large steps only.
        """
        moves = xp.abs(way.more) > 1.0
        size = xp.where(moves, way.more, 1.0)
        rate = xp.maximum(self.H_k, 1e-15)
        first = rate * self.sigma_crit
        spread = scale.forward * (self.H_sat - self.H_min)
        bend, slope = scale.elastic / rate, scale.forward * self.H_sat
        if self.surfaces == "curved":
            bend, slope = bend + 2.0 * self.curvature_f / rate, slope - 2.0 * self.curvature_f * self.sigma_cal
        rest = slope - way.warmer / size
        t = xp.maximum(first, 3.0)
        for _ in range(PEAK):
            decay = spread * xp.exp(first - t)
            falls = decay * (t - 2.0) - bend
            usable = falls > 0.0
            step = (rest + decay * (t - 1.0) + bend * t) / xp.where(usable, falls, 1.0)
            t = xp.clip(t + xp.where(usable, step, 0.0), first, first + 100.0)
        return xp.where(moves, xp.clip((t / rate - way.stress) / size, 0.0, 1.0), 0.0)

    def reverse_peak(self, xp: Namespace, scale: WorkScale, way: StraightPath, strain: Scalar) -> Scalar:
        """Return the fraction of a path at which `reverse_share` has its minimum, if inside."""
        curve, slope = scale.elastic, scale.reverse * strain
        if self.surfaces == "curved":
            curve, slope = curve + 2.0 * self.curvature_r, slope - 2.0 * self.curvature_r * self.sigma_cal
        bend = curve * way.more * way.more
        bends = bend > 1e-30
        part = (way.warmer - (slope + curve * way.stress) * way.more) / xp.where(bends, bend, 1.0)
        return xp.where(bends, xp.clip(part, 0.0, 1.0), 0.0)

    def softening(self) -> Scalar:
        """Return ΔS [1/Pa]."""
        return 1.0 / self.E_M - 1.0 / self.E_A

    def _work(self, xp: Namespace, stress: Scalar) -> Scalar:
        """Return G = d(Hσ)/dσ [-]."""
        excess = stress - self.sigma_crit
        steep = self.H_k * xp.exp(-self.H_k * xp.maximum(excess, 0.0))
        grows = xp.where(excess > 0.0, (self.H_sat - self.H_min) * steep, 0.0)
        return self.current(xp, stress) + grows * stress
