"""Müller–Achenbach–Seelecke law in its rate-independent limit: modes instead of rates.

While a transformation runs, stress stays at its threshold; otherwise fractions are frozen. The modes A, M+, M-, A↔M+
and A↔M- need no switching events, because the state defines them:

    R± = ½ + (±σ - σ̂_M)/w  on [0, 1]     x± cannot stay above R±
    F± = ½ + (±σ - σ̂_A)/w  on [0, 1]     x± rises to F± as long as there is austenite

a play operator with a ramp of width w (0.1 MPa), which closes every minor loop. Thermal activation moves the stress
inside the thresholds by the barrier that layers pass in the `transit_time` t_c,

    σ̂_A = max(0, σ_A - √ln(t_c/τ)/k_A),   σ̂_M = σ_M + √ln(t_c/τ)/k_M,
    k² = ½ λ (1/E + 1/K),   λ = V/(k_B T_L),

so that plateaus agree with the rate law at a rate of about 1/t_c; a decade of rate is 0.2 to 0.3 MPa. For t_c ≤ τ
plateaus lie at the nominal thresholds.

Source: the hybrid automaton of five modes by Mandolino, Ferrante and Rizzello (2021), arXiv 2103.03586 (abstract seen);
the play form is this package's.
"""

from typing import NamedTuple

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.barriers import build_wells, compute_scales
from martensite.physics.kinetics.layers import AbstractCrystal, CrystalMemory, Pull, VariantFractions, join_variants
from martensite.physics.laws.base import LAWS, Fractions


class HybridStep(NamedTuple):
    """Step from the remembered point."""

    present: VariantFractions
    pull: Pull


class Rests(NamedTuple):
    """Equilibrium stresses [Pa] of transformations."""

    A: Scalar
    M: Scalar


@LAWS.register("mas-hybrid")
class MullerAchenbachSeeleckeHybrid(AbstractCrystal):
    """Rate-independent single crystal: stress stays at a threshold while layers switch."""

    cites = ("mandolino2021", "seelecke2004")

    transit_time: Number = param("s", "time to pass the barrier that is left", above=0.0, high=1e6, default=1.0)
    ramp: Number = param("Pa", "stress over which a transformation runs", low=1e3, high=1e8, default=1e5)

    def inside(self, xp: Namespace) -> Rests:
        """Return the distances of the equilibrium stresses inside σ_A and σ_M [Pa], from the wells at T_L."""
        constants = self.material()
        at = build_wells(xp, constants, self.sigma_L, self.T_L, self.form)
        scale = compute_scales(xp, constants, at, self.form)
        slow = xp.sqrt(xp.log(xp.maximum(self.transit_time / self.layer_time, 1.0)))
        return Rests(slow / scale.A, slow / scale.M)

    def rests(self, xp: Namespace, temperature: Scalar) -> Rests:
        """Return the thresholds with thermal activation [Pa]."""
        inside, threshold = self.inside(xp), self.linear_transition_stress(temperature)
        return Rests(
            xp.maximum(threshold - inside.A, 0.0), self.transition_stress(xp, temperature) - self.Delta_sigma + inside.M
        )

    @override
    def select(self, xp: Namespace, memory: CrystalMemory, stress: Scalar, temperature: Scalar) -> HybridStep:
        present = self.balance(xp, memory.present, memory.stress, memory.temperature)
        return HybridStep(present, self.strongest(xp, present, stress, temperature))

    @override
    def follow(self, xp: Namespace, move: HybridStep, stress: Scalar, temperature: Scalar, dt: Scalar) -> Fractions:
        return join_variants(self.balance(xp, move.present, stress, temperature))

    def balance(
        self, xp: Namespace, present: VariantFractions, stress: Scalar, temperature: Scalar
    ) -> VariantFractions:
        """Return the remaining and newly formed fractions of the variants at a point."""
        rests = self.rests(xp, temperature)

        def reached(stress: Scalar, rest: Scalar) -> Scalar:
            return xp.clip(0.5 + (stress - rest) / self.ramp, 0.0, 1.0)

        plus = xp.minimum(present.plus, reached(stress, rests.M))
        minus = xp.minimum(present.minus, reached(-stress, rests.M))
        more = xp.maximum(reached(stress, rests.A) - plus, 0.0)
        other = xp.maximum(reached(-stress, rests.A) - minus, 0.0)
        wanted, austenite = more + other, 1.0 - plus - minus
        short = wanted > austenite
        share = xp.where(short, austenite / xp.where(short, wanted, 1.0), 1.0)
        plus = plus + share * more
        return VariantFractions(plus, xp.minimum(minus + share * other, 1.0 - plus))

    def kinetics(
        self, xp: Namespace, memory: CrystalMemory, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> tuple[CrystalMemory, Fractions]:
        """Advance along a straight leg, cut where the forward threshold reaches zero."""
        bend = self.T_L + (self.inside(xp).A - self.sigma_L) / self.dsigma_dT
        way = temperature - memory.temperature
        moves = xp.abs(way) > 0.0
        share = (bend - memory.temperature) / xp.where(moves, way, 1.0)
        share = xp.where(moves, xp.clip(share, 0.0, 1.0), 0.0)
        between = (memory.stress + share * (stress - memory.stress), memory.temperature + share * way)
        halfway, _ = super().kinetics(xp, memory, *between, dt)
        return super().kinetics(xp, halfway, stress, temperature, dt)

    def drive(self, xp: Namespace, move: HybridStep, stress: Scalar, temperature: Scalar, dt: Scalar) -> Scalar:
        """Return the distance beyond the middle of the remaining ramp [Pa]."""
        rests, pull, now = self.rests(xp, temperature), move.pull, move.present
        present = xp.where(pull.by_stress * pull.by_threshold < 0.0, now.plus, now.minus)
        by_A = pull.by_threshold * rests.A - 0.5 * present * self.ramp
        by_M = pull.by_threshold * rests.M - 0.5 * (1.0 - present) * self.ramp
        return pull.by_stress * stress + xp.where(pull.offset < 0.0, by_M, by_A)
