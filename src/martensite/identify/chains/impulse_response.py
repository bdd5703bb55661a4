"""Impulse responses from records, and poles from impulse responses.

    y_t = c + Σ_k g_k u_{t-nk-k} + e,   g ~ N(0, κ σ² P),   P_ij = λ^max(i, j)

Regularised least squares with the TC kernel, which is smooth and decaying. With s_k = λ^k, P = T Tᵀ,
T_ik = √(s_k - s_{k+1}) for k ≥ i, so that no ill-conditioned matrix is factored; κ and λ maximise the marginal
likelihood, with the best σ². Inputs and outputs are divided by their standard deviations; the first input of a record
is continued into the past.

Ho–Kalman: the matrix of responses H_ij = g_{i+j} is observability times controllability, so its largest singular
directions give C, A, B with g_k = C A^k B.

Sources: Chen, Ohlsson, Ljung 2012 (TC kernel, empirical Bayes); Ho and Kalman 1966; Kung 1978 (singular values).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers

ROWS = 4096
"""Samples per block of regressors."""
WORK = 6e9
"""Largest number of multiplications for the normal equations; longer records are sampled."""
DECAYS = (3.0, 6.0, 12.0, 24.0)
"""Candidates for -log λ over the whole length."""
SIZES = 10.0 ** np.arange(-2.0, 7.0)
"""Candidates for κ, in units of the decay per sample."""

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

    Raises:
        DataError: too few samples are known.
    """
    count = int(sum(np.all(np.isfinite(y), axis=1).sum() for _, y in pairs))
    if count < 4:
        raise DataError(f"An impulse response needs at least 4 samples known in all outputs, not {count}.")
    u_scale = _find_spread(np.concatenate([u for u, _ in pairs]))
    y_scale = _find_spread(np.concatenate([y for _, y in pairs]))
    sums = _sum_products([(u / u_scale, y / y_scale) for u, y in pairs], length, nk)
    g = _find_likeliest(sums, length)
    return g.transpose(1, 2, 0) * y_scale[:, None] / u_scale


def _find_spread(signals: Numbers) -> Numbers:
    spread = np.nanstd(signals, axis=0)
    return np.where(spread > 0.0, spread, 1.0)


def _sum_products(pairs: Sequence[Pair], length: int, nk: int) -> _Sums:
    """Return the sums of products around the means, over rows without missing outputs."""
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
    """Yield regressors (lags of input after input) and outputs in blocks."""
    samples = sum(len(u) for u, _ in pairs)
    every = int(np.ceil(samples * (length * pairs[0][0].shape[1]) ** 2 / WORK))
    for u, y in pairs:
        past = np.vstack([np.repeat(u[:1], length + nk - 1, axis=0), u])
        lagged = np.lib.stride_tricks.sliding_window_view(past, length, axis=0)[:, :, ::-1]
        # only short records use lags that reach before their start
        begin = length if len(u) >= 10 * length else 0
        for first in range(begin, len(u), ROWS * max(every, 1)):
            rows = slice(first, min(first + ROWS, len(u)))
            finite_rows = np.all(np.isfinite(y[rows]), axis=1)
            x = lagged[rows].reshape(rows.stop - rows.start, -1)
            yield x[finite_rows], y[rows][finite_rows]


def _find_likeliest(sums: _Sums, length: int) -> Numbers:
    """Return the responses, shape (inputs, lags, outputs), with the most likely κ and λ."""
    inputs = len(sums.square) // length
    best, response = np.inf, np.zeros((inputs, length, sums.cross.shape[1]))
    for decay in DECAYS:
        s = np.exp(-decay / length * np.arange(length + 1))
        s[-1] = 0.0
        factor = np.kron(np.eye(inputs), np.triu(np.ones((length, length))) * np.sqrt(-np.diff(s)))
        values, vectors = np.linalg.eigh(factor.T @ sums.square @ factor)
        values = np.maximum(values, 0.0)
        cross = vectors.T @ (factor.T @ sums.cross)
        for size in SIZES * decay / length:
            shrunk = cross / (values + 1.0 / size)[:, None]
            errors = np.diag(sums.outputs) - np.sum(cross * shrunk, axis=0)
            errors = np.maximum(errors, 1e-14 * np.maximum(np.diag(sums.outputs), 1e-300))
            score = sums.count * np.sum(np.log(errors)) + len(errors) * np.sum(np.log1p(size * values))
            if score < best:
                best = float(score)
                response = (factor @ (vectors @ shrunk)).reshape(inputs, length, -1)
    return response


RADIUS = 1.0 - 1e-7
"""Largest modulus of a pole."""
SMALLEST = 1e-4
"""Least modulus of a pole."""


class Realisation(NamedTuple):
    """A, B, C of g_k = C A^k B."""

    a: Numbers
    b: Numbers
    c: Numbers


def realise_responses(g: Numbers, order: int) -> Realisation:
    """Return the state space of an order from responses of shape (lags, outputs, inputs)."""
    length, outputs, inputs = g.shape
    half = max(length // 2, 1)
    lags = np.arange(half)[:, None] + np.arange(length - half)
    hankel = g[lags].transpose(0, 2, 1, 3).reshape(half * outputs, -1)
    left, sizes, right = np.linalg.svd(hankel, full_matrices=False)
    root = np.sqrt(sizes[:order])
    observed, reached = left[:, :order] * root, root[:, None] * right[:order]
    a = np.linalg.lstsq(observed[:-outputs], observed[outputs:], rcond=None)[0]
    return Realisation(a, reached[:, :inputs], observed[:outputs])


class MatchedPoles(NamedTuple):
    """Poles as free numbers of a cascade."""

    numbers: Numbers
    places: Numbers
    """Index of the given pole for each of `sections.poles`."""


def match_poles(z: Numbers, dt: float) -> MatchedPoles:
    """Return the free numbers of the sections for poles z, moved to the nearest possible ones.

    Poles outside the unit circle are mirrored. Two poles on the negative real axis become a pair on it, a single one a
    fast pole on the positive axis. Real poles are paired with their neighbours; the slowest stays single for an odd
    number.
    """
    z = np.asarray(z, dtype=complex)
    size = np.maximum(np.abs(z), 1e-12)
    inside = np.clip(np.where(size > 1.0, 1.0 / size, size), SMALLEST, RADIUS)
    s = (np.log(inside) + 1j * np.angle(z)) / dt
    first, pairs = _pair_poles(s, z, dt)
    return MatchedPoles(
        np.array([*(-np.log(-s[i].real) for i in first), *(n for p in pairs for n in _describe_pair(s, p))]),
        np.array([*first, *(i for pair in pairs for i in pair)], dtype=int),
    )


def _pair_poles(s: Numbers, z: Numbers, dt: float) -> tuple[list[int], list[tuple[int, int]]]:
    """Return the single real pole, if any, and the pairs; a single pole on the negative axis moves in place."""
    edge = 1e-9 / dt
    upper = [i for i in range(len(s)) if edge < s[i].imag < np.pi / dt - edge]
    lower = [int(np.argmin(np.abs(s - np.conj(s[i])))) for i in upper]
    real = sorted(set(range(len(s))) - {*upper, *lower}, key=lambda i: s[i].real)
    negative = [i for i in real if z[i].real < 0.0]
    if len(negative) % 2:
        s[negative.pop(0)] = np.log(SMALLEST) / dt
    positive = sorted(set(real) - set(negative), key=lambda i: s[i].real)
    first = [positive.pop()] if len(positive) % 2 else []
    rows = (lower, upper), (negative[::2], negative[1::2]), (positive[::2], positive[1::2])
    return first, [pair for a, b in rows for pair in zip(a, b, strict=True)]


def _describe_pair(s: Numbers, pair: tuple[int, int]) -> tuple[float, float]:
    """Return log ω and log ζ of two poles."""
    a, b = s[pair[0]], s[pair[1]]
    if abs(a.imag) > 0.0:
        a = complex(0.5 * (a.real + b.real), a.imag)
        b = a.conjugate()
    omega = float(np.sqrt(abs(a) * abs(b)))
    return float(np.log(omega)), float(np.log(-0.5 * (a + b).real / omega))


def find_entering(realised: Realisation, z: Numbers, cascade: Realisation, cascade_poles: Numbers) -> Numbers:
    """Return B of a realisation with poles z in the state of a cascade with poles `own`, in the same order.

    The modes of both are scaled so that the sum of the inputs, the last input of the realisation, excites them equally.
    """
    excited = _find_modes(realised, z)[1]
    modes, wanted = _find_modes(cascade, cascade_poles)
    whole = excited[:, -1:]
    whole = np.where(np.abs(whole) > 1e-9 * np.abs(excited).max(), whole, 1e-9)
    return np.real(modes @ (wanted / whole * excited[:, :-1]))


def _find_modes(system: Realisation, z: Numbers) -> tuple[Numbers, Numbers]:
    values, modes = np.linalg.eig(system.a)
    left, order = list(range(len(values))), list[int]()
    for one in z:
        order.append(min(left, key=lambda i: abs(values[i] - one)))
        left.remove(order[-1])
    modes = modes[:, order].astype(complex)
    return modes, np.linalg.solve(modes, system.b + 0j)
