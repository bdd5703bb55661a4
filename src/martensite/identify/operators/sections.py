"""Sections of first and second order for any sample time: the poles of a linear system.

Free numbers are log τ [s] and (log ω [rad/s], log ζ), so every section is stable for any values, with the same meaning
at every sample time. Poles are matched, exp(s dt); the recursion is in delta form, x + p (w - x), which keeps its
precision for time constants of thousands of samples. Every section has unit static gain and responds within the sample:

    first order    v = v₋ + p (w - v₋),                     p = 1 - exp(-dt/τ)
    second order   Δ = Δ₋ + d₂ (w - v₋₋) - d₁ Δ₋,  v = v₋ + Δ,   v₋₋ = v₋ - Δ₋
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.kernels.namespace import Namespace, Scalar

LONGEST = 14.0
"""Limit of |log τ| and |log ω|, in seconds."""
STRONGEST = 9.0
"""Limit of |log ζ|."""


class Second(NamedTuple):
    """Coefficients of a section of second order."""

    d1: Scalar
    d2: Scalar


def first_order(xp: Namespace, log_tau: Scalar, dt: Scalar) -> Scalar:
    """Return p = 1 - exp(-dt/τ), precise for long τ."""
    return minus_expm1(xp, dt * xp.exp(-xp.clip(log_tau, -LONGEST, LONGEST)))


def minus_expm1(xp: Namespace, x: Scalar) -> Scalar:
    """Return 1 - exp(-x) = 2 t/(1 + t), t = tanh(x/2), for x ≥ 0."""
    t = xp.tanh(0.5 * xp.minimum(x, 700.0))
    return 2.0 * t / (1.0 + t)


def second_order(xp: Namespace, log_omega: Scalar, log_zeta: Scalar, dt: Scalar) -> Second:
    """Return d₂ = (1 - z₁)(1 - z₂) and d₁ = 2 - z₁ - z₂ of the matched poles z = exp(s dt)."""
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


class SectionOutput(NamedTuple):
    """Signals of a cascade in one sample."""

    signals: list[Scalar]
    """Signals from the last section back: output, then scaled change of a section of second order."""
    unit_gain: list[bool]
    """True for signals with a static gain of 1; the others have 0."""
    state: list[Scalar]


def name_sections(order: int) -> tuple[str, ...]:
    """Return the free numbers of the sections of an order."""
    first = ("log_tau",) if order % 2 else ()
    pairs = (f"log_{symbol}{k + 1}" for k in range(order // 2) for symbol in ("omega", "zeta"))
    return (*first, *pairs)


def step_cascade(
    xp: Namespace,
    order: int,
    poles: list[Scalar],
    state: list[Scalar],
    w: Scalar,
    dt: Scalar,
    more: Sequence[Scalar] = (),
) -> SectionOutput:
    """Return the sections in series with input w; the state holds v₋ (and Δ₋) of every section.

    The first `nb` ≤ order signals span all numerators of `nb` coefficients. With `more`, order - 1 further inputs enter
    the other states: a section of second order adds one to its input and √d₂ times one to its output.
    """
    signals: list[Scalar] = []
    gains: list[bool] = []
    after: list[Scalar] = []
    numbers, states, fed = iter(poles), iter(state), iter(more)
    if order % 2:
        before = next(states)
        w = before + first_order(xp, next(numbers), dt) * (w - before)
        signals, gains, after = [w], [True], [w]
    for k in range(order // 2):
        d = second_order(xp, next(numbers), next(numbers), dt)
        before, change = next(states), next(states)
        w = w + next(fed) if more and (k or order % 2) else w
        change = change + d.d2 * (w - (before - change)) - d.d1 * change
        w = before + change
        w = w + xp.sqrt(d.d2) * next(fed) if more else w
        signals = [w, change / xp.sqrt(d.d2), *signals]
        gains = [True, False, *gains]
        after += [w, change]
    return SectionOutput(signals, gains, after)


def rest_cascade(order: int, w: Scalar) -> list[Scalar]:
    """Return the steady state of a cascade under a constant input."""
    return [w] * (order % 2) + [w, 0.0] * (order // 2)


def fed_resting(xp: Namespace, order: int, poles: list[Scalar], fed: list[Scalar], dt: Scalar) -> list[Scalar]:
    """Return the steady state of a cascade under constant inputs of all its states."""
    w, states = fed[0], [fed[0]] * (order % 2)
    for k in range(order % 2, order, 2):
        d = second_order(xp, poles[k], poles[k + 1], dt)
        change = -xp.sqrt(d.d2) * fed[k + 1]
        w = (w + fed[k] if k else w) + change * (1.0 - d.d1 / d.d2)
        states += [w, change]
    return states


def find_poles(order: int, numbers: Numbers, dt: float) -> Numbers:
    """Return the poles z = exp(s dt) of a cascade, all inside the unit circle."""
    first = order % 2
    s: list[complex] = [complex(-np.exp(-np.clip(log_tau, -LONGEST, LONGEST))) for log_tau in numbers[:first]]
    for k in range(first, order, 2):
        omega = float(np.exp(np.clip(numbers[k], -LONGEST, LONGEST)))
        zeta = float(np.exp(np.clip(numbers[k + 1], -STRONGEST, STRONGEST)))
        large = zeta + np.sqrt(complex(zeta * zeta - 1.0))
        # their product is ω²: no difference of large numbers
        s += [-omega * large, -omega / large]
    return np.array([np.exp(complex(max(one.real * dt, -700.0), one.imag * dt)) for one in s])


def find_time_range(duration: float, dt: float) -> tuple[float, float]:
    """Return the logarithms of the shortest and longest time constants that a record determines [s]."""
    return float(np.log(max(5.0 * dt, 1e-3 * duration))), float(np.log(0.25 * duration))


def compute_weights(order: int, numbers: Numbers, leads: Numbers) -> Numbers:
    """Return the weights of the signals after the first, from the last section back, for zeros at s = -1/lead.

    There is one more signal than zeros. In the limit of dense samples the signals have numerators in s of ascending
    degree; their weighted sum has the given zeros.
    """
    count = len(leads) + 1
    matrix = np.zeros((count, count))
    for k, signal in enumerate(_compute_numerators(order, numbers)[:count]):
        matrix[: len(signal), k] = signal
    wanted = np.poly1d([1.0])
    for lead in leads:
        wanted = wanted * np.poly1d([lead, 1.0])
    full = np.zeros(count)
    full[: len(wanted.c)] = wanted.c[::-1]
    return np.linalg.solve(matrix, full)[1:]


def _compute_numerators(order: int, numbers: Numbers) -> list[Numbers]:
    """Return the numerators of the signals, coefficients of s^0, s^1, …, from the last section back."""
    numerators: list[Numbers] = []
    behind = np.ones(1)
    for k in range(order - 2, -1, -2):
        tau, zeta = np.exp(-numbers[k]), np.exp(numbers[k + 1])
        numerators += [behind, np.convolve(behind, [0.0, tau])]
        behind = np.convolve(behind, [1.0, 2.0 * zeta * tau, tau * tau])
    if order % 2:
        numerators.append(behind)
        behind = np.convolve(behind, [1.0, np.exp(numbers[0])])
    return [*numerators, behind]


def draw_numbers(order: int, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
    """Return random time constants from a thousandth to a quarter of a record, with damping near 1."""
    short, long = find_time_range(duration, dt)
    theta, first = np.zeros(order), order % 2
    theta[:first] = rng.uniform(short, long, first)
    theta[first::2] = -rng.uniform(short, long, order // 2)
    theta[first + 1 :: 2] = rng.uniform(np.log(0.5), np.log(2.0), order // 2)
    return theta


def show_numbers(named: Sequence[str], theta: Numbers) -> list[tuple[str, float, str]]:
    """Return names without `log_`, values and units."""
    units = {"tau": "s", "omega": "rad/s", "zeta": "1"}
    rows: list[tuple[str, float, str]] = []
    for name, value in zip(named, theta, strict=True):
        plain = name.removeprefix("log_")
        log = plain != name
        unit = units[plain.rstrip("0123456789")] if log else "1"
        rows.append((plain, float(np.exp(value) if log else value), unit))
    return rows
