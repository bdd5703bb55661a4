"""Müller–Achenbach–Seelecke law of a single crystal: three wells, thermally activated jumps.

    dx₊/dt = p_A₊ A - p_₊A x₊,    dx₋/dt = p_A₋ A - p_₋A x₋,    A = 1 - x₊ - x₋
    ε = ε_T (x₊ - x₋) + σ [(x₊ + x₋)/E_M + A/E_A]

with the wells of `kinetics.layers` and the rates of `kinetics.barriers`. A plateau lies slightly inside its threshold
and moves with the logarithm of the rate (0.3 MPa per decade for V = 5e-23 m³). Layer volume V and time τ have a meaning
only together with the form of the rates.

A published latent heat is rarely consistent with the free energy: `heat_model = "free-energy"` takes the heat -T dβ/dT
from it instead (β the difference of the unloaded wells); `stress` adds the work and the elastic part σ ε_T + ½ σ²
(1/E_A - 1/E_M).

Sources: Seelecke and Müller (2004), Appl. Mech. Rev. 57; the limit σ_A ≥ 0 as in a public implementation of the
Saarland group (Ullrich 2014).
"""

from collections.abc import Callable
from typing import NamedTuple

from martensite.base.interfaces import override
from martensite.base.parameters import option
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.barriers import (
    Process,
    RateStart,
    build_processes,
    build_wells,
    compute_rate,
    compute_scales,
    keep_process,
)
from martensite.physics.kinetics.exchange import AbstractExchange, Flows, exchange_fractions, mean_flows
from martensite.physics.kinetics.layers import AbstractCrystal, CrystalMemory, Pull, VariantFractions, join_variants
from martensite.physics.laws.base import LAWS, Fractions


class MasStep(NamedTuple):
    """Step from the remembered point."""

    present: VariantFractions
    starts: tuple[RateStart, ...]
    pull: Pull


RESTING = 0.03
"""Fraction of its layers that a process near equilibrium moves in one step, for the first guess."""


@LAWS.register("mas")
class MullerAchenbachSeelecke(AbstractCrystal, AbstractExchange):
    """Single crystal with austenite and two martensite variants, rate dependent."""

    cites = ("seelecke2004", "ullrich2014")

    rates: str = option(
        "barrier: saddle height; well: layers at the edge of their well (erfc); edge: saddle with a rigid bridge",
        "barrier",
        "well",
        "edge",
        default="barrier",
    )

    @property
    @override
    def form(self) -> str:
        return self.rates

    def barriers(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> tuple[Process, ...]:
        """Return the four processes at a point."""
        constants = self.material()
        at = build_wells(xp, constants, self.linear_transition_stress(temperature), temperature, self.form)
        plus = build_processes(xp, constants, at, stress, self.form)
        minus = build_processes(xp, constants, at, -stress, self.form)
        return (*plus, *minus)

    @override
    def select(self, xp: Namespace, memory: CrystalMemory, stress: Scalar, temperature: Scalar) -> MasStep:
        barriers = self.barriers(xp, memory.stress, memory.temperature)
        starts = tuple(keep_process(xp, process) for process in barriers)
        return MasStep(memory.present, starts, self.strongest(xp, memory.present, stress, temperature))

    @override
    def follow(self, xp: Namespace, move: MasStep, stress: Scalar, temperature: Scalar, dt: Scalar) -> Fractions:
        ends = self.barriers(xp, stress, temperature)
        flows = mean_flows(xp, move.starts, ends, dt / self.layer_time)
        return join_variants(exchange_fractions(xp, move.present, flows))

    def drive(self, xp: Namespace, move: MasStep, stress: Scalar, temperature: Scalar, dt: Scalar) -> Scalar:
        """Return the stress beyond the equilibrium of the process in a step of dt [Pa]."""
        pull = move.pull
        at = build_wells(xp, self.material(), self.linear_transition_stress(temperature), temperature, self.form)
        scale = compute_scales(xp, self.material(), at, self.form)
        slow = xp.sqrt(xp.log(xp.maximum(dt / (RESTING * self.layer_time), 1.0)))
        inside = slow / xp.where(pull.offset < 0.0, scale.M, scale.A)
        return self.overshoot(xp, pull, stress, temperature) + inside

    def jump_rates(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Flows:
        """Return the rates [1/s] of A → M+, M+ → A, A → M-, M- → A at a point."""
        barriers = self.barriers(xp, stress, temperature)
        return Flows(*(compute_rate(xp, process, self.layer_time) for process in barriers))

    @override
    def jumps(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Callable[[Scalar], Flows]:
        rates = self.jump_rates(xp, stress, temperature)
        return lambda quantile: rates
