"""Impulse responses from records: regularised least squares, in bounded memory.

    y_t = c + Σ_k g_k u_{t-nk-k} + e,   g ~ N(0, κ σ² P),   P_ij = λ^max(i, j)

(the TC kernel: smooth and decaying). With s_k = λ^k, P = T Tᵀ, T_ik = √(s_k - s_{k+1}) for
k ≥ i, so that no ill-conditioned matrix is factored; κ and λ are those of largest marginal
likelihood, with σ² at its best.

Source: Chen, Ohlsson, Ljung 2012 (TC kernel, empirical Bayes). Inputs and outputs count in units
of their standard deviations; before a record its first input is taken to have lasted for ever.

From impulse responses to poles, and from poles to the free numbers of sections.

Ho–Kalman: the matrix of responses H_ij = g_{i+j} is observability times controllability, so its
largest singular directions give C, A, B with g_k = C A^k B.

Source: Ho and Kalman 1966; Kung 1978 (with singular values).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers

ROWS = 4096
"""Samples whose regressors are held at a time."""
WORK = 6e9
"""Most multiplications for the normal equations; beyond it some pieces of a record are left out."""
DECAYS = (3.0, 6.0, 12.0, 24.0)
"""Tried decays -log λ over the whole length."""
SIZES = 10.0 ** np.arange(-2.0, 7.0)
"""Tried κ, each in units of the decay per sample."""

Pair = tuple[Numbers, Numbers]
"""Inputs (samples, inputs) and outputs (samples, outputs) of a record."""


class _Sums(NamedTuple):
    """Sums for the normal equations."""

    count: int
    square: Numbers
    cross: Numbers
    outputs: Numbers


def impulse_response(pairs: Sequence[Pair], length: int, nk: int = 0) -> Numbers:
    """Return the responses g at lags nk … nk + length - 1, shape (length, outputs, inputs).

    Samples with a missing output do not count.

    Raises:
        DataError: too few samples are known.
    """
    known = int(sum(np.all(np.isfinite(y), axis=1).sum() for _, y in pairs))
    if known < 4:
        raise DataError(f"An impulse response needs at least 4 samples known in all outputs, not {known}.")
    u_scale = _find_spread(np.concatenate([u for u, _ in pairs]))
    y_scale = _find_spread(np.concatenate([y for _, y in pairs]))
    sums = _sum_products([(u / u_scale, y / y_scale) for u, y in pairs], length, nk)
    g = _find_likeliest(sums, length)
    return g.transpose(1, 2, 0) * y_scale[:, None] / u_scale


def _find_spread(signals: Numbers) -> Numbers:
    spread = np.nanstd(signals, axis=0)
    return np.where(spread > 0.0, spread, 1.0)


def _sum_products(pairs: Sequence[Pair], length: int, nk: int) -> _Sums:
    """Return the sums of products around the means, over rows whose outputs are all known."""
    columns, outputs = length * pairs[0][0].shape[1], pairs[0][1].shape[1]
    total = np.zeros((columns + outputs + 1,) * 2)
    for x, y in _build_regressors(pairs, length, nk):
        joined = np.hstack([x, y, np.ones((len(x), 1))])
        total += joined.T @ joined
    count, mean = total[-1, -1], total[-1, :-1]
    centred = total[:-1, :-1] - np.outer(mean, mean) / max(count, 1.0)
    cut = columns
    return _Sums(int(count), centred[:cut, :cut], centred[:cut, cut:], centred[cut:, cut:])


def _build_regressors(pairs: Sequence[Pair], length: int, nk: int) -> Iterator[Pair]:
    """Regressors, input after input each over its lags, and outputs, piece by piece."""
    samples = sum(len(u) for u, _ in pairs)
    every = int(np.ceil(samples * (length * pairs[0][0].shape[1]) ** 2 / WORK))
    for u, y in pairs:
        past = np.vstack([np.repeat(u[:1], length + nk - 1, axis=0), u])
        lagged = np.lib.stride_tricks.sliding_window_view(past, length, axis=0)[:, :, ::-1]
        # lags longer than the record so far are trusted only in short records
        begin = length if len(u) >= 10 * length else 0
        for first in range(begin, len(u), ROWS * max(every, 1)):
            rows = slice(first, min(first + ROWS, len(u)))
            known = np.all(np.isfinite(y[rows]), axis=1)
            x = lagged[rows].reshape(rows.stop - rows.start, -1)
            yield x[known], y[rows][known]


def _find_likeliest(sums: _Sums, length: int) -> Numbers:
    """Return the responses of shape (inputs, lags, outputs) with the likeliest κ and λ."""
    inputs = len(sums.square) // length
    best, found = np.inf, np.zeros((inputs, length, sums.cross.shape[1]))
    for decay in DECAYS:
        s = np.exp(-decay / length * np.arange(length + 1))
        s[-1] = 0.0
        factor = np.kron(np.eye(inputs), np.triu(np.ones((length, length))) * np.sqrt(-np.diff(s)))
        values, vectors = np.linalg.eigh(factor.T @ sums.square @ factor)
        values = np.maximum(values, 0.0)
        cross = vectors.T @ (factor.T @ sums.cross)
        for size in SIZES * decay / length:
            shrunk = cross / (values + 1.0 / size)[:, None]
            left = np.diag(sums.outputs) - np.sum(cross * shrunk, axis=0)
            left = np.maximum(left, 1e-14 * np.maximum(np.diag(sums.outputs), 1e-300))
            score = sums.count * np.sum(np.log(left)) + len(left) * np.sum(np.log1p(size * values))
            if score < best:
                best = float(score)
                found = (factor @ (vectors @ shrunk)).reshape(inputs, length, -1)
    return found


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
    """Return the state space of an order from responses of shape (lags, outputs, inputs)."""
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
    """Return the free numbers of the sections with given poles z, moved to the nearest that they can have.

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
    """B of a realisation with poles z in the state of a cascade with poles `own`, in the same order.

    Mode by mode: the modes of both are scaled so that the sum of the inputs excites them alike. The last input of the
    realisation is that sum, which drives the cascade.
    """
    excited = _find_modes(found, z)[1]
    modes, wanted = _find_modes(cascade, own)
    whole = excited[:, -1:]
    whole = np.where(np.abs(whole) > 1e-9 * np.abs(excited).max(), whole, 1e-9)
    return np.real(modes @ (wanted / whole * excited[:, :-1]))


def _find_modes(system: Realised, z: Numbers) -> tuple[Numbers, Numbers]:
    """Return the modes as columns in the order of given poles, and how the inputs excite them."""
    values, modes = np.linalg.eig(system.a)
    left, order = list(range(len(values))), list[int]()
    for one in z:
        order.append(min(left, key=lambda i: abs(values[i] - one)))
        left.remove(order[-1])
    modes = modes[:, order].astype(complex)
    return modes, np.linalg.solve(modes, system.b + 0j)
