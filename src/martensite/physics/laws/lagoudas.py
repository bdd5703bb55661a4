"""Lagoudas law: Boyd–Lagoudas surfaces, smooth hardening, transformation strain H(σ).

One-dimensional form. `martensite.physics.kinetics.surfaces` has the surfaces, their calibration and sources,
`martensite.physics.kinetics.hardening` the hardening functions h:

    ε = σ [1/E_A + ξ (1/E_M - 1/E_A)] + ε_t + [α_A + ξ (α_M - α_A)] (T - T_ref)
    dε_t = H(σ) dξ (forward),     dε_t = (ε_t/ξ) dξ (reverse),
    H(σ) = H_min + (H_sat - H_min)(1 - exp[-k (σ - σ_crit)]) above σ_crit, else H_min

Both surfaces are inverted for the fraction, which makes ξ a play operator of (σ, T):

    ξ₁ = max{ξ_f(σ, T), min[ξ_r(σ, T, Λ), ξ₀]},        Λ = ε_t/ξ

with ξ_f on the forward and ξ_r on the reverse surface, for steps of any size. Any initial state is valid; a state
outside its surfaces moves onto them at once. If both processes could act (unoriented martensite under high stress),
forward is stronger: martensite stays if it would form again at once.

ε_t is exact on reverse (Λ is constant) and at constant stress. On forward under changing stress ∫H dξ has no closed
form; H is a parabola in h (without waist) over the part of the path on which ξ grows, and the corners of h(ξ) are
integrated exactly. The error is of fourth order in the step along prescribed legs, and affects ξ through Λ in the next
reverse transformation only.

The waist is an unpublished extension: a cubic in h for each direction. It makes the middle of a branch steeper and its
tails longer than exponents can, as in measured isobaric cycles of trained wires.

Not included: reorientation (martensite keeps its strain until it transforms), compression, plasticity, R-phase, the
contribution σ (α_M - α_A) to the driving force.
"""

from typing import ClassVar, NamedTuple

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.kernels.nested import choose_tuple, find_largest
from martensite.physics.kinetics.diagram import find_side_strain
from martensite.physics.kinetics.hardening import apply_waist, compute_hardening, hardening_integral, invert_hardening
from martensite.physics.kinetics.surfaces import AbstractSurfaceLaw, StraightPath, WorkScale
from martensite.physics.laws.base import LAWS, Fractions

MOST_PIECES = 5
"""Largest number of pieces of a leg."""
ROUNDING = 1e-12
"""Overshoot of a surface [-] that counts as rounding at the start of a leg."""


class LagoudasMemory(NamedTuple):
    """Memory of the law."""

    fraction: Scalar
    ratio: Scalar
    """Oriented fraction of the martensite, ε_t/(ξ H_sat) [-]; constant on reverse."""
    stress: Scalar
    temperature: Scalar


class LagoudasProcess(NamedTuple):
    """Previous state, and the part of a straight path on which ξ grows."""

    fraction: Scalar
    ratio: Scalar
    stress: Scalar
    temperature: Scalar
    grows_from: Scalar
    """Fraction of the path at which the forward surface is met [-]."""
    grows_to: Scalar
    """Fraction of the path at which all is martensite [-]; 1 if not reached."""

    def way(self, stress: Scalar, temperature: Scalar) -> StraightPath:
        """Return the straight path from the previous state to a point."""
        return StraightPath.between((self.stress, self.temperature), (stress, temperature))


@LAWS.register("lagoudas")
class Lagoudas(AbstractSurfaceLaw):
    """Boyd–Lagoudas law with smooth hardening and stress-dependent transformation strain.

    With `hardening = "waisted"` branches have steeper middles and longer tails (unpublished extension).
    """

    cites = ("lagoudas2012", "boyd1996", "hartl2010")
    has_twins: ClassVar[bool] = True
    one_way: ClassVar[bool] = False
    reorients: ClassVar[bool] = False
    """True with compression: martensite may be oriented against the stress."""

    alpha_A: Number = param("1/K", "thermal expansion of austenite", low=-1e-4, high=1e-4, default=0.0)
    alpha_M: Number = param("1/K", "thermal expansion of martensite", low=-1e-4, high=1e-4, default=0.0)
    T_ref: Number = param("K", "temperature of zero thermal strain", low=0.0, high=1000.0, default=293.15)

    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> LagoudasMemory:
        """Return the memory of a phase state; ε_t is `oriented` times H_sat."""
        some = fractions.martensite > 0.0
        ratio = fractions.oriented / xp.where(some, fractions.martensite, 1.0)
        ratio = xp.where(some, xp.clip(ratio, -1.0, 1.0), 0.0)
        return LagoudasMemory(fractions.martensite, ratio, stress, temperature)

    def relocate(
        self, xp: Namespace, memory: LagoudasMemory, fractions: Fractions, stress: Scalar, temperature: Scalar
    ) -> LagoudasMemory:
        """Return the memory as if the path began there; without martensite, the ratio is kept."""
        fresh = self.init(xp, fractions, stress, temperature)
        some = fractions.martensite > 0.0
        return fresh._replace(ratio=xp.where(some, fresh.ratio, memory.ratio))

    @override
    def fractions(self, memory: LagoudasMemory) -> Fractions:
        return Fractions(memory.fraction, memory.ratio * memory.fraction)

    @override
    def select(self, xp: Namespace, memory: LagoudasMemory, stress: Scalar, temperature: Scalar) -> LagoudasProcess:
        scale = self.scale(xp)
        move = LagoudasProcess(*memory, grows_from=0.0, grows_to=1.0)
        way = move.way(stress, temperature)
        here = self.forward_hardening(xp, memory.fraction)
        start, end = (self.forward_meeting(xp, scale, way, share) for share in (here, 1.0))
        return move._replace(grows_from=start, grows_to=end)

    @override
    def follow(
        self, xp: Namespace, move: LagoudasProcess, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Fractions:
        scale, way = self.scale(xp), move.way(stress, temperature)
        strain = move.ratio * self.H_sat
        share = self.smooth(xp, self.reverse_share(xp, scale, strain, stress, temperature), self.waist_r)
        falls = share < compute_hardening(xp, move.fraction, self.n_3, self.n_4)
        share = xp.where(falls, share, 1.0)  # the inversion of 0 or 1 needs no iterations
        left = xp.minimum(invert_hardening(xp, share, self.n_3, self.n_4), move.fraction)
        share = self.smooth(xp, self.forward_share(xp, scale, stress, temperature), self.waist_f)
        grows = xp.either(falls, share > compute_hardening(xp, move.fraction, self.n_1, self.n_2))
        fraction = xp.maximum(invert_hardening(xp, xp.where(grows, share, 0.0), self.n_1, self.n_2), left)
        if self.reorients:  # martensite that reverts from the other orientation and forms again is new
            move = move._replace(fraction=xp.where(move.ratio < 0.0, left, move.fraction))
        gained = self._integrate_strain(xp, scale, move, way, xp.maximum(fraction, move.fraction))
        remainder = move.ratio * xp.minimum(fraction, move.fraction)
        return Fractions(fraction, remainder + gained / self.H_sat)

    def _integrate_strain(
        self, xp: Namespace, scale: WorkScale, move: LagoudasProcess, way: StraightPath, fraction: Scalar
    ) -> Scalar:
        """Return ∫H dξ [-] up to a fraction.

        H = H₀ + c (h - h₀) + a parabola that is 0 at both ends and exact near the middle of h.
        """
        exponents = self.n_1, self.n_2
        first, last = (compute_hardening(xp, x, *exponents) for x in (move.fraction, fraction))
        grown, climb = fraction - move.fraction, last - first
        climbs = climb > 0.0
        safe = xp.where(climbs, climb, 1.0)

        def reached(part: Scalar) -> tuple[Scalar, Scalar]:

            stress, kelvin = way.at(move.grows_from + part * (move.grows_to - move.grows_from))
            return stress, self.forward_share(xp, scale, stress, kelvin)

        part = self._halfway(xp, reached(0.5)[1], first, safe)
        middle, at = reached(part)
        at = (self.smooth(xp, at, self.waist_f) - first) / safe
        at = xp.clip(at, 1.0 / 3.0, 2.0 / 3.0)
        slow = self.current(xp, way.at(move.grows_from)[0])
        more = self.current(xp, way.at(move.grows_to)[0]) - slow
        areas = [hardening_integral(xp, x, *exponents) for x in (move.fraction, fraction)]
        area = xp.where(climbs, (areas[1] - areas[0] - first * grown) / safe, 0.0)
        bulge = (self.current(xp, middle) - slow - at * more) / (6.0 * at * (1.0 - at))
        return grown * (slow + bulge) + area * more

    def _halfway(self, xp: Namespace, middle: Scalar, first: Scalar, climb: Scalar) -> Scalar:
        """Return the approximate fraction of a growth at which h has risen by half.

        h_f is a parabola through both ends and its value in the `middle`.
        """
        goal = 0.5
        if self.hardening == "waisted":
            ends = (apply_waist(first + part * climb, self.waist_f) for part in (0.0, 0.5, 1.0))
            first, half, last = ends
            climbs = last > first
            climb = xp.where(climbs, last - first, 1.0)
            goal = xp.where(climbs, xp.clip((half - first) / climb, 0.125, 0.875), 0.5)
        bend = 4.0 * xp.clip((middle - first) / climb, 0.0, 1.0) - 1.0
        return 2.0 * goal / (bend + xp.sqrt(bend * bend + 4.0 * goal - 4.0 * goal * bend))

    @override
    def commit(
        self,
        xp: Namespace,
        memory: LagoudasMemory,
        move: LagoudasProcess,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> LagoudasMemory:
        grown = fractions.martensite > memory.fraction
        if self.reorients:
            grown = xp.either(grown, xp.both(memory.ratio < 0.0, fractions.martensite > 0.0))
        ratio = fractions.oriented / xp.where(grown, fractions.martensite, 1.0)
        ratio = xp.where(grown, xp.clip(ratio, -1.0, 1.0), memory.ratio)
        return LagoudasMemory(fractions.martensite, ratio, stress, temperature)

    def kinetics(
        self, xp: Namespace, memory: LagoudasMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[LagoudasMemory, Fractions]:
        """Advance along a straight leg, in pieces that end wherever a process may turn inside it.

        A leg without transformation has no pieces. Otherwise a piece ends at the start, if the state lies outside its
        surfaces; at a maximum of the forward surface; at the end of the leg; and at a minimum of the reverse surface
        before either of the last two.
        """
        scale, advance = self.scale(xp), super().kinetics
        start, end = (memory.stress, memory.temperature), (stress, temperature)

        def run_piece(place: Scalar, cut: Scalar, *numbers: Scalar) -> tuple[Scalar, ...]:
            now = LagoudasMemory(*numbers)
            goal = choose_tuple(xp, place > 2.0, start, choose_tuple(xp, place > 1.0, peak, end))
            way = StraightPath.between((now.stress, now.temperature), goal)
            part = self.reverse_peak(xp, scale, way, now.ratio * self.H_sat)
            turn = way.at(part)
            turns = xp.both(self._falls(xp, scale, now, *turn), xp.both(part * (1.0 - part) > 0.0, cut < 1.0))
            after, _ = advance(xp, now, *choose_tuple(xp, turns, turn, goal), dt)
            return (xp.where(turns, place, place - 1.0), xp.where(turns, 1.0, 0.0), *after)

        move = LagoudasProcess(*memory, grows_from=0.0, grows_to=1.0)
        way = move.way(stress, temperature)
        part = self.forward_peak(xp, scale, way)
        peak, turn = way.at(part), way.at(self.reverse_peak(xp, scale, way, memory.ratio * self.H_sat))
        outside = self.crossing(xp, memory, move, *start) > ROUNDING
        acts = find_largest(xp, [self.crossing(xp, memory, move, *at) for at in (peak, turn, end)]) > ROUNDING
        # a piece of no length changes nothing, unless martensite reorients
        peaks = True if self.reorients else part * (1.0 - part) > 0.0
        pieces = xp.where(acts, xp.where(peaks, 2.0, 1.0), 0.0)
        begin = xp.where(outside, 3.0, pieces), xp.where(outside, 1.0, 0.0)
        _, _, *numbers = xp.iterate(MOST_PIECES, run_piece, *begin, *memory)
        memory = LagoudasMemory(*numbers)._replace(stress=stress, temperature=temperature)
        return memory, self.fractions(memory)

    def _falls(
        self, xp: Namespace, scale: WorkScale, memory: LagoudasMemory, stress: Scalar, temperature: Scalar
    ) -> Flag:
        """Return whether the fraction is smaller at a point, by more than rounding."""
        share = self.reverse_share(xp, scale, memory.ratio * self.H_sat, stress, temperature)
        falls = xp.maximum(share, 0.0) < self.reverse_hardening(xp, memory.fraction) - ROUNDING
        share = self.forward_share(xp, scale, stress, temperature)
        return xp.both(falls, share < self.forward_hardening(xp, memory.fraction) - ROUNDING)

    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """Return H_sat·oriented + [α_A + ξ (α_M - α_A)] (T - T_ref) [-]."""
        alpha = self.alpha_A + fractions.martensite * (self.alpha_M - self.alpha_A)
        return find_side_strain(xp, self, "H_sat", fractions) + alpha * (temperature - self.T_ref)

    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return 1/E_A + ξ (1/E_M - 1/E_A) [1/Pa]."""
        return 1.0 / self.E_A + fractions.martensite * self.softening()

    def crossing(
        self, xp: Namespace, memory: LagoudasMemory, move: LagoudasProcess, stress: Scalar, temperature: Scalar
    ) -> Scalar:
        """Return the largest overshoot of a surface by the move, as a fraction of its range [-].

        The values have no waist, because these measure the change of the fraction.
        """
        scale = self.scale(xp)
        ahead = xp.clip(self.forward_share(xp, scale, stress, temperature), 0.0, 1.0)
        ahead = self.smooth(xp, ahead, self.waist_f)
        strain = memory.ratio * self.H_sat
        behind = xp.clip(self.reverse_share(xp, scale, strain, stress, temperature), 0.0, 1.0)
        behind = self.smooth(xp, behind, self.waist_r)
        ahead = ahead - compute_hardening(xp, memory.fraction, self.n_1, self.n_2)
        behind = compute_hardening(xp, memory.fraction, self.n_3, self.n_4) - behind
        return xp.maximum(xp.maximum(ahead, behind), 0.0)
