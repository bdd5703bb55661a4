"""From impulse responses to poles, and from poles to the free numbers of sections.

Ho–Kalman: the matrix of responses H_ij = g_{i+j} is observability times controllability, so its
largest singular directions give C, A, B with g_k = C A^k B.

Source: Ho and Kalman 1966; Kung 1978 (with singular values).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import Numbers

RADIUS = 1.0 - 1e-7
"""Largest modulus of a pole that is taken over."""
SMALLEST = 1e-4
"""Least modulus."""


class Realised(NamedTuple):
    """A, B, C of g_k = C A^k B."""

    a: Numbers
    b: Numbers
    c: Numbers


def realise_responses(g: Numbers, order: int) -> Realised:
    """State space of an order from responses of shape (lags, outputs, inputs)."""
    length, outputs, inputs = g.shape
    half = max(length // 2, 1)
    lags = np.arange(half)[:, None] + np.arange(length - half)
    hankel = g[lags].transpose(0, 2, 1, 3).reshape(half * outputs, -1)
    left, sizes, right = np.linalg.svd(hankel, full_matrices=False)
    root = np.sqrt(sizes[:order])
    seen, reached = left[:, :order] * root, root[:, None] * right[:order]
    a = np.linalg.lstsq(seen[:-outputs], seen[outputs:], rcond=None)[0]
    return Realised(a, reached[:, :inputs], seen[:outputs])


class Matched(NamedTuple):
    """Poles as free numbers of a cascade."""

    numbers: Numbers
    places: Numbers
    """Which of the given poles each of `sections.poles` stands for."""


def match_poles(z: Numbers, dt: float) -> Matched:
    """Free numbers of the sections with given poles z, moved to the nearest that they can have.

    Poles outside the unit circle are mirrored into it. Of poles on the negative real axis two
    become one pair on it, a single one a fast pole on the positive axis. Real poles are paired
    with their neighbours, the slowest stays alone if their number is odd.
    """
    z = np.asarray(z, dtype=complex)
    size = np.maximum(np.abs(z), 1e-12)
    inside = np.clip(np.where(size > 1.0, 1.0 / size, size), SMALLEST, RADIUS)
    s = (np.log(inside) + 1j * np.angle(z)) / dt
    edge = 1e-9 / dt
    upper = [i for i in range(len(s)) if edge < s[i].imag < np.pi / dt - edge]
    lower = [int(np.argmin(np.abs(s - np.conj(s[i])))) for i in upper]
    pairs = [(j, i) for i, j in zip(upper, lower, strict=True)]
    real = [i for i in range(len(s)) if i not in upper and i not in lower]
    negative = sorted((i for i in real if z[i].real < 0.0), key=lambda i: s[i].real)
    if len(negative) % 2:
        s[negative.pop(0)] = np.log(SMALLEST) / dt
    pairs += list(zip(negative[::2], negative[1::2], strict=True))
    positive = sorted((i for i in real if i not in negative), key=lambda i: s[i].real)
    first = [positive.pop()] if len(positive) % 2 else []
    pairs += list(zip(positive[::2], positive[1::2], strict=True))
    return Matched(
        np.array([*(-np.log(-s[i].real) for i in first), *(n for p in pairs for n in _describe_pair(s, p))]),
        np.array([*first, *(i for pair in pairs for i in pair)], dtype=int),
    )


def _describe_pair(s: Numbers, pair: tuple[int, int]) -> tuple[float, float]:
    """log ω and log ζ of two poles, the faster or lower one first."""
    a, b = s[pair[0]], s[pair[1]]
    if abs(a.imag) > 0.0:
        a = complex(0.5 * (a.real + b.real), a.imag)
        b = a.conjugate()
    omega = float(np.sqrt(abs(a) * abs(b)))
    return float(np.log(omega)), float(np.log(-0.5 * (a + b).real / omega))


def find_entering(found: Realised, z: Numbers, cascade: Realised, own: Numbers) -> Numbers:
    """B of a realisation in the state of a cascade.

    Mode by mode: the modes of both are scaled so that the sum of the inputs excites them alike.

    Args:
        found: the realisation, its last input the sum of the others that drives the cascade.
        z: its poles, in the order of the cascade's.
        cascade: the cascade with its input.
        own: poles of the cascade.
    """
    excited = _find_modes(found, z)[1]
    modes, wanted = _find_modes(cascade, own)
    whole = excited[:, -1:]
    whole = np.where(np.abs(whole) > 1e-9 * np.abs(excited).max(), whole, 1e-9)
    return np.real(modes @ (wanted / whole * excited[:, :-1]))


def _find_modes(system: Realised, z: Numbers) -> tuple[Numbers, Numbers]:
    """Modes as columns in the order of given poles, and how the inputs excite them."""
    values, modes = np.linalg.eig(system.a)
    left, order = list(range(len(values))), list[int]()
    for one in z:
        order.append(min(left, key=lambda i: abs(values[i] - one)))
        left.remove(order[-1])
    modes = modes[:, order].astype(complex)
    return modes, np.linalg.solve(modes, system.b + 0j)
