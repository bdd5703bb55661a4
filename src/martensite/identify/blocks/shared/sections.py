"""Sections of first and second order, safe for any sample time: the poles of a linear system.

Free numbers are log τ [s] and (log ω [rad/s], log ζ), so every section is stable, whatever a fit
proposes, and means the same at every sample time. Poles are matched, exp(s dt); the recursion is
in delta form, x + p (w - x) and not a x + b w, because with time constants of thousands of
samples a is 1 to the last digits and p is not. Every section has unit gain at rest and answers
within the sample:

    first order    v = v₋ + p (w - v₋),                     p = 1 - exp(-dt/τ)
    second order   Δ = Δ₋ + d₂ (w - v₋₋) - d₁ Δ₋,  v = v₋ + Δ,   v₋₋ = v₋ - Δ₋
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.runtimes.namespace import Namespace, Scalar

LONGEST = 14.0
"""Limit of |log τ| and |log ω|, in seconds."""
STRONGEST = 9.0
"""Limit of |log ζ|."""


class Second(NamedTuple):
    """Coefficients of a section of second order."""

    d1: Scalar
    d2: Scalar


def first_order(xp: Namespace, log_tau: Scalar, dt: Scalar) -> Scalar:
    """p = 1 - exp(-dt/τ), to the last digits for long τ."""
    return minus_expm1(xp, dt * xp.exp(-xp.clip(log_tau, -LONGEST, LONGEST)))


def minus_expm1(xp: Namespace, x: Scalar) -> Scalar:
    """1 - exp(-x) = 2 t/(1 + t), t = tanh(x/2), for x ≥ 0."""
    t = xp.tanh(0.5 * xp.minimum(x, 700.0))
    return 2.0 * t / (1.0 + t)


def second_order(xp: Namespace, log_omega: Scalar, log_zeta: Scalar, dt: Scalar) -> Second:
    """d₂ = (1 - z₁)(1 - z₂) and d₁ = 2 - z₁ - z₂ of the matched poles z = exp(s dt)."""
    w = dt * xp.exp(xp.clip(log_omega, -LONGEST, LONGEST))
    zeta = xp.exp(xp.clip(log_zeta, -STRONGEST, STRONGEST))
    complex_ = zeta < 1.0
    # complex poles, with 1 - e^-c (cos φ) written as m + 2 e^-c sin²(φ/2)
    root = xp.sqrt(xp.maximum(1.0 - zeta * zeta, 0.0))
    decay = minus_expm1(xp, zeta * w)
    half = xp.sin(0.5 * w * root)
    swing = 4.0 * (1.0 - decay) * half * half
    # real poles, s₁ s₂ = ω², without a difference of large numbers
    spread = zeta + xp.sqrt(xp.maximum(zeta * zeta - 1.0, 0.0))
    slow, fast = minus_expm1(xp, w / spread), minus_expm1(xp, w * spread)
    return Second(
        d1=xp.where(complex_, 2.0 * decay + swing, slow + fast),
        d2=xp.where(complex_, decay * decay + swing, slow * fast),
    )


class Cascade(NamedTuple):
    """What a cascade gives in one sample."""

    signals: list[Scalar]
    """From the last section back: its output, its scaled change if it is of second order, …"""
    unit_gain: list[bool]
    """Which of them follow the input at rest; the others rest at 0."""
    state: list[Scalar]


def names(order: int) -> tuple[str, ...]:
    """Free numbers of the sections that make up an order."""
    first = ("log_tau",) if order % 2 else ()
    pairs = (f"log_{symbol}{k + 1}" for k in range(order // 2) for symbol in ("omega", "zeta"))
    return (*first, *pairs)


def cascade(
    xp: Namespace, order: int, poles: list[Scalar], state: list[Scalar], w: Scalar, dt: Scalar
) -> Cascade:
    """Sections in series, fed with w; the state holds v₋ (and Δ₋) of every section.

    The first `nb` signals span all numerators of `nb` coefficients, nb ≤ order.
    """
    signals: list[Scalar] = []
    gains: list[bool] = []
    after: list[Scalar] = []
    numbers, held = iter(poles), iter(state)
    if order % 2:
        before = next(held)
        w = before + first_order(xp, next(numbers), dt) * (w - before)
        signals, gains, after = [w], [True], [w]
    for _ in range(order // 2):
        d = second_order(xp, next(numbers), next(numbers), dt)
        before, change = next(held), next(held)
        change = change + d.d2 * (w - (before - change)) - d.d1 * change
        w = before + change
        signals = [w, change / xp.sqrt(d.d2), *signals]
        gains = [True, False, *gains]
        after += [w, change]
    return Cascade(signals, gains, after)


def resting(order: int, w: Scalar) -> list[Scalar]:
    """State of a cascade at rest under a constant input."""
    return [w] * (order % 2) + [w, 0.0] * (order // 2)
