"""Impulse responses from records: regularised least squares, in bounded memory.

    y_t = c + Σ_k g_k u_{t-nk-k} + e,   g ~ N(0, κ σ² P),   P_ij = λ^max(i, j)

(the TC kernel: smooth and decaying). With s_k = λ^k, P = T Tᵀ, T_ik = √(s_k - s_{k+1}) for
k ≥ i, so that no ill-conditioned matrix is factored; κ and λ are those of largest marginal
likelihood, with σ² at its best.

Source: Chen, Ohlsson, Ljung 2012 (TC kernel, empirical Bayes). Inputs and outputs count in units
of their standard deviations; before a record its first input is taken to have lasted for ever.
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
    """What the normal equations need."""

    count: int
    square: Numbers
    cross: Numbers
    outputs: Numbers


def impulse_response(pairs: Sequence[Pair], length: int, nk: int = 0) -> Numbers:
    """Responses g at lags nk … nk + length - 1, shape (length, outputs, inputs).

    Args:
        pairs: inputs and outputs of records; samples with a missing output do not count.
        length: number of lags.
        nk: first lag.

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
    """Sums of products around the means, over rows whose outputs are all known."""
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
    """Responses of shape (inputs, lags, outputs) with the likeliest κ and λ."""
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
