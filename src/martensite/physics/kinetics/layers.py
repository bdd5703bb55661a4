"""Base of laws of layers in energy wells: parameters, strain, heat, free energy.

Austenite and the martensite variants M+ and M- are parabolic wells of the free energy, joined by concave parabolas with
continuous slope:

    σ_A(T) = σ_L + s (T - T_L),   σ_M = σ_A - Δσ,   ε_A = σ_A/E_A,   ε_M = ε_T + σ_M/E_M
    ψ'(ε) = E_A ε  up to ε_A,   σ_A - K (ε - ε_A)  up to ε_M,   E_M (ε - ε_T)  beyond;  ψ even

The threshold σ_A never falls below zero: cold martensite switches between its variants at |σ| = Δσ.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.dual import value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import choose_tuple
from martensite.physics.kinetics.barriers import BarrierConstants
from martensite.physics.laws.base import AbstractLaw, Fractions


class VariantFractions(NamedTuple):
    """Fractions of the two martensite variants."""

    plus: Scalar
    minus: Scalar


def split_variants(fractions: Fractions) -> VariantFractions:
    """Return x₊ and x₋ of a phase state."""
    martensite, oriented = fractions
    return VariantFractions(0.5 * (martensite + oriented), 0.5 * (martensite - oriented))


def join_variants(state: VariantFractions) -> Fractions:
    """Return the phase state of x₊ and x₋."""
    return Fractions(state.plus + state.minus, state.plus - state.minus)


class Pull(NamedTuple):
    """drive = by_stress σ + by_threshold σ_A(T) + offset, of one process [Pa]."""

    by_stress: Scalar
    by_threshold: Scalar
    offset: Scalar

    def drive(self, stress: Scalar, threshold: Scalar) -> Scalar:
        """Return the stress beyond the threshold of the process [Pa]."""
        return self.by_stress * stress + self.by_threshold * threshold + self.offset


PRESENT = 1e-6
"""Fraction above which a phase counts as present."""
NEVER = -1e15
"""Drive [Pa] of a process without layers."""


class AbstractLayers(AbstractLaw):
    """Law of layers in wells; subclasses define the groups of layers."""

    has_twins = True
    one_way = False
    has_drive = True

    E_A: Number = param("Pa", "Young's modulus of austenite", low=1e8, high=3e11, typical="50 GPa")
    E_M: Number = param("Pa", "Young's modulus of martensite", low=1e8, high=3e11, typical="30 GPa")
    eps_T: Number = param("1", "transformation strain of one variant", above=0.0, high=0.2, typical=0.04)
    sigma_L: Number = param(
        "Pa", "stress of the austenite to martensite transition at T_L", low=-2e9, high=2e9, typical="100 MPa"
    )
    T_L: Number = param("K", "temperature at which sigma_L holds", low=100.0, high=1000.0, typical="70 degC")
    dsigma_dT: Number = param(
        "Pa/K", "slope of the transition stresses with temperature", low=1e5, high=1e9, typical="4 MPa/K"
    )
    Delta_sigma: Number = param("Pa", "width of the stress hysteresis", low=1e4, high=2e9, typical="50 MPa")
    layer_volume: Number = param("m^3", "volume of a transforming layer", above=0.0, high=1e-15, typical="5e-23 m^3")
    layer_time: Number = param("s", "time constant of a transforming layer", above=0.0, high=1e3, typical="10 ms")
    heat_model: str = option(
        "heat of transformation: the element's latent heat, plus work, or from the free energy",
        "constant",
        "stress",
        "free-energy",
        default="constant",
    )

    @override
    def check(self) -> None:
        if self.Delta_sigma >= 0.5 * self.E_M * self.eps_T:
            raise ParameterError(
                f"Parameter `Delta_sigma` of `{self.registered_name}` must be below half of E_M eps_T = "
                f"{self.E_M * self.eps_T / 1e6:.4g} MPa, but is {self.Delta_sigma / 1e6:.4g} MPa."
            )

    @property
    def form(self) -> str:
        """Return the form of the barriers, see `kinetics.barriers`."""
        return "barrier"

    @property
    def constant_heat(self) -> bool:
        """Return True for the heat model `constant`."""
        return self.heat_model == "constant"

    def material(self) -> BarrierConstants:
        """Return the constants of free energy and layers."""
        return BarrierConstants(self.E_A, self.E_M, self.eps_T, self.Delta_sigma, self.layer_volume, self.layer_time)

    def linear_transition_stress(self, temperature: Scalar) -> Scalar:
        """Return σ_L + s (T - T_L) [Pa], before the limit at zero."""
        return self.sigma_L + self.dsigma_dT * (temperature - self.T_L)

    def transition_stress(self, xp: Namespace, temperature: Scalar) -> Scalar:
        """Return σ_A(T) [Pa], never below zero."""
        return xp.maximum(self.linear_transition_stress(temperature), 0.0)

    def free_strain(self, xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
        """Return ε_T (x₊ - x₋) [-]."""
        return self.eps_T * fractions.oriented

    def compliance(self, xp: Namespace, fractions: Fractions) -> Scalar:
        """Return (x₊ + x₋)/E_M + A/E_A [1/Pa]."""
        return 1.0 / self.E_A + fractions.martensite * (1.0 / self.E_M - 1.0 / self.E_A)

    def heat(self, xp: Namespace, latent: Scalar, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the heat of the whole transformation [J/m³] by the chosen model."""
        if self.heat_model == "stress":
            elastic = 0.5 * stress * stress * (1.0 / self.E_A - 1.0 / self.E_M)
            return latent + elastic + stress * self.eps_T
        if self.heat_model == "free-energy":
            _, slope = value_and_slope(xp, self.depth, temperature)
            return -temperature * slope
        return latent

    def depth(self, xp: Namespace, temperature: Scalar) -> Scalar:
        """Return β(T) = ψ_A(0) - ψ_M(ε_T) [J/m³], the difference of the unloaded wells."""
        rise = self.linear_transition_stress(temperature)
        eps_A, eps_M = rise / self.E_A, self.eps_T + (rise - self.Delta_sigma) / self.E_M
        martensite = self.E_M * (self.eps_T - eps_A) * (self.eps_T - eps_M)
        return 0.5 * (martensite - self.E_A * eps_A * eps_M)

    def strongest(self, xp: Namespace, present: VariantFractions, stress: Scalar, temperature: Scalar) -> Pull:
        """Return the process with the largest drive under an elastic trial, among present phases."""
        austenite = 1.0 - present.plus - present.minus
        candidates = (
            (Pull(1.0, -1.0, 0.0), austenite),
            (Pull(-1.0, 1.0, -self.Delta_sigma), present.plus),
            (Pull(-1.0, -1.0, 0.0), austenite),
            (Pull(1.0, 1.0, -self.Delta_sigma), present.minus),
        )
        threshold = self.transition_stress(xp, temperature)
        best, chosen = NEVER, candidates[0][0]
        for pull, share in candidates:
            drive = xp.where(share > PRESENT, pull.drive(stress, threshold), NEVER)
            ahead = drive > best
            best = xp.where(ahead, drive, best)
            chosen = choose_tuple(xp, ahead, pull, chosen)
        return chosen

    def overshoot(self, xp: Namespace, pull: Pull, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the stress beyond the threshold of a process [Pa]."""
        return pull.drive(stress, self.transition_stress(xp, temperature))

    def crossing(self, xp: Namespace, memory: Any, move: Any, stress: Scalar, temperature: Scalar) -> Scalar:
        """Return the overshoot of the trial in widths of the hysteresis [-]."""
        over = self.overshoot(xp, move.pull, stress, temperature)
        return xp.maximum(over, 0.0) / self.Delta_sigma

    def free_energy(self, xp: Namespace, strain: Scalar, temperature: Scalar) -> Scalar:
        """Return ψ(ε, T) [J/m³], zero at the bottom of the austenite well."""
        rise = self.transition_stress(xp, temperature)
        eps_A = rise / self.E_A
        eps_M = self.eps_T + (rise - self.Delta_sigma) / self.E_M
        bridge = self.Delta_sigma / (eps_M - eps_A)
        size = xp.abs(strain)
        a, b = xp.minimum(size, eps_A), xp.clip(size - eps_A, 0.0, eps_M - eps_A)
        c = xp.maximum(size - eps_M, 0.0)
        stress_M = rise - self.Delta_sigma
        rising = 0.5 * self.E_A * a * a + rise * b - 0.5 * bridge * b * b
        return rising + stress_M * c + 0.5 * self.E_M * c * c


class CrystalMemory(NamedTuple):
    """Memory of a single crystal."""

    present: VariantFractions
    stress: Scalar
    temperature: Scalar


class AbstractCrystal(AbstractLayers):
    """Identical layers; subclasses define their motion."""

    @override
    def init(self, xp: Namespace, fractions: Fractions, stress: Scalar, temperature: Scalar) -> CrystalMemory:
        return CrystalMemory(split_variants(fractions), stress, temperature)

    def fractions(self, memory: CrystalMemory) -> Fractions:
        """Return ξ = x₊ + x₋ and oriented x₊ - x₋."""
        return join_variants(memory.present)

    def populations(self, memory: CrystalMemory) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        """Return x₊ and x₋."""
        return (memory.present.plus,), (memory.present.minus,)

    def remember(
        self, xp: Namespace, plus: Sequence[Scalar], minus: Sequence[Scalar], stress: Scalar, temperature: Scalar
    ) -> CrystalMemory:
        """Return the memory with these populations."""
        return CrystalMemory(VariantFractions(plus[0], minus[0]), stress, temperature)

    @override
    def commit(
        self,
        xp: Namespace,
        memory: CrystalMemory,
        move: Any,
        fractions: Fractions,
        stress: Scalar,
        temperature: Scalar,
        dt: Scalar,
    ) -> CrystalMemory:
        present = split_variants(fractions)
        return self.remember(xp, (present.plus,), (present.minus,), stress, temperature)
