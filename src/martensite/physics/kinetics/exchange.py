"""Exact exchange of three phases at constant rates over a step.

With P the rates times the step (dimensionless), the variants x± and A = 1 - x₊ - x₋,

    dx₊ = P_A₊ A - P_₊A x₊,      dx₋ = P_A₋ A - P_₋A x₋,

a linear system whose matrix M has two real eigenvalues λ₂ ≤ λ₁ ≤ 0. The state after the step is x + ψ(M) f, with the
present net flow f and ψ(λ) = (exp λ - 1)/λ. This needs no division by the determinant and no growing exponential, and
leaves the state unchanged at zero rates.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.kinetics.barriers import Process, RateStart, mean_rate
from martensite.physics.kinetics.layers import AbstractLayers, VariantFractions

SMALL = 1e-2
CLOSE = 1e-4
"""Difference below which eigenvalues are equal in the divided difference of ψ."""


class AbstractExchange(AbstractLayers):
    """Layers with rates that depend on stress and temperature, in one or more groups."""

    rate_dependent = True

    def quantiles(self) -> tuple[float, ...]:
        """Return the quantiles of the groups."""
        return (0.0,)

    @abstractmethod
    def populations(self, memory: Any) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        """Return x₊ and x₋ of each group."""

    @abstractmethod
    def remember(
        self, xp: Namespace, plus: Sequence[Scalar], minus: Sequence[Scalar], stress: Scalar, temperature: Scalar
    ) -> Any:
        """Return the memory with these populations of each group."""

    @abstractmethod
    def jumps(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Callable[[Scalar], Flows]:
        """Return the rates [1/s] of the four processes, as a function of the quantile of a group."""


class Flows(NamedTuple):
    """Flows A → M+, M+ → A, A → M-, M- → A: rates, or rates times the step."""

    to_plus: Scalar
    from_plus: Scalar
    to_minus: Scalar
    from_minus: Scalar


def mean_flows(xp: Namespace, starts: Sequence[RateStart], ends: Sequence[Process], share: Scalar) -> Flows:
    """Return the flows of a step between the processes at its ends; `share` is the step over τ."""
    return Flows(*(share * mean_rate(xp, a, b) for a, b in zip(starts, ends, strict=True)))


def exchange_fractions(xp: Namespace, before: VariantFractions, flows: Flows) -> VariantFractions:
    """Return the fractions after a step at constant rates."""
    up, down, over, back = flows
    out_plus, out_minus = up + down, over + back
    half = 0.5 * (out_plus - out_minus)
    spread = xp.sqrt(half * half + up * over)
    low = -0.5 * (out_plus + out_minus) - spread
    product = up * back + over * down + down * back
    high = product / xp.where(low < 0.0, low, 1.0)
    austenite = 1.0 - before.plus - before.minus
    flow_plus = up * austenite - down * before.plus
    flow_minus = over * austenite - back * before.minus
    first, second = _compute_psi_pair(xp, low, high, 2.0 * spread)
    turn_plus = -(out_plus + high) * flow_plus - up * flow_minus
    turn_minus = -(out_minus + high) * flow_minus - over * flow_plus
    # removes rounding errors; the exact solution keeps these limits
    plus = xp.clip(before.plus + first * flow_plus + second * turn_plus, 0.0, 1.0)
    minus = before.minus + first * flow_minus + second * turn_minus
    return VariantFractions(plus, xp.clip(minus, 0.0, 1.0 - plus))


def _compute_psi_pair(xp: Namespace, low: Scalar, high: Scalar, apart: Scalar) -> tuple[Scalar, Scalar]:
    """Return ψ(high) and the divided difference of ψ."""
    at_low, at_high = _compute_psi(xp, low), _compute_psi(xp, high)
    close, small = apart < CLOSE, xp.abs(high) < 0.1
    series = 0.5 + high * (1.0 / 3.0 + high * (1.0 / 8.0 + high * (1.0 / 30.0 + high / 144.0)))
    exact = (1.0 + (high - 1.0) * at_high) / xp.where(small, 1.0, high)
    difference = (at_high - at_low) / xp.where(close, 1.0, apart)
    return at_high, xp.where(close, xp.where(small, series, exact), difference)


def _compute_psi(xp: Namespace, x: Scalar) -> Scalar:
    """Return (exp x - 1)/x for x ≤ 0."""
    small = xp.abs(x) < SMALL
    series = 1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0 + x / 720.0))))
    return xp.where(small, series, (xp.exp(x) - 1.0) / xp.where(small, 1.0, x))
