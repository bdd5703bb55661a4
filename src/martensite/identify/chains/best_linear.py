"""Best linear approximation: linear models from records without iteration, as starts of searches.

A regularised impulse response gives poles (Ho–Kalman); with given poles a linear block is linear in its other numbers,
which follow from least squares. Slow systems are also examined at lower sample rates; the poles that explain the
records best are used. For a nonlinear system under a Gaussian input the best linear approximation has the poles of its
linear blocks for any static blocks (Bussgang's theorem).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.decimation import thin_records
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.impulse_response import (
    MatchedPoles,
    Pair,
    Realisation,
    find_entering,
    impulse_response,
    match_poles,
    realise_responses,
)
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.search.levenberg_marquardt import minimise_cost
from martensite.signals.sampling.sampled import Sampled


class LinearStart(NamedTuple):
    """Numbers with which y ≈ gain · block(w) + offset."""

    theta: Numbers
    gain: float
    """1 for a block with a free gain."""
    offset: float
    """Offset of the output; 0 for a block with free offsets, or with several outputs."""
    error: float
    """Sum of squared errors over the variances of the outputs."""


def fit_weights(block: TransferFunction | StateSpace, given: Numbers, pairs: Sequence[Pair], dt: float) -> LinearStart:
    """Return the start with given first numbers; the others follow from linear least squares."""
    theta = np.zeros(len(block.numbers()))
    theta[: len(given)] = given
    own = _find_weights(block, len(given))
    weights, error = _solve_squares(ChainEngine([block], dt), theta, own, pairs)
    if not np.isfinite(error):
        return LinearStart(theta, 1.0, 0.0, np.inf)
    if isinstance(block, TransferFunction):
        gain = float(weights[0, 0])
        least = 1e-3 * float(np.abs(weights[:-1, 0]).max())
        gain = gain if abs(gain) > least else max(least, 1e-300)
        theta[own] = weights[1:-1, 0] / gain
        return LinearStart(theta, gain, float(weights[-1, 0]), error)
    n, d = int(block.order), block.inputs * (block.nk < 1.0)
    parts = [weights[:n].T.ravel(), weights[n : n + d].T.ravel()]
    if block.offset == "yes":
        parts.append(weights[-1])
    theta[len(given) :] = np.concatenate(parts)
    single = block.offset == "no" and block.outputs == 1
    return LinearStart(theta, 1.0, float(weights[-1, 0]) if single else 0.0, error)


def _find_weights(block: TransferFunction | StateSpace, given_count: int) -> NDArray[np.intp]:
    """Return the places of the linear numbers of the first output; all outputs sum the same signals."""
    first = ("weight", "c1_", "d1_")
    names = block.numbers()
    return np.array([i for i in range(given_count, len(names)) if names[i].startswith(first)], np.intp)


def _solve_squares(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> tuple[Numbers, float]:
    """Return the weights of the signals and the constant, and the error over the variances."""
    outputs = np.concatenate([y for _, y in pairs])
    outs = outputs.shape[1]
    total: Numbers | None = None
    for x, y in _collect_signals(engine, theta, own, pairs):
        rows = np.hstack([x, y])
        rows = rows if total is None else np.vstack([total, rows])
        if not np.all(np.isfinite(rows)):
            return np.zeros((0, 0)), np.inf
        total = np.asarray(np.linalg.qr(rows, mode="r"))
    if total is None or len(total) < total.shape[1]:
        return np.zeros((0, 0)), np.inf
    count = total.shape[1] - outs
    top, right = total[:count, :count], total[:count, count:]
    scale = np.maximum(np.linalg.norm(top, axis=0), 1e-300)
    weights = np.linalg.lstsq(top / scale, right, rcond=1e-12)[0] / scale[:, None]
    errors = np.sum((right - top @ weights) ** 2, axis=0) + np.sum(total[count:, count:] ** 2, axis=0)
    spread = np.nanvar(outputs, axis=0)
    return weights, float(np.sum(errors / np.where(spread > 0.0, spread, 1.0)))


def _collect_signals(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> Iterator[Pair]:
    """Yield the regressors with a constant, and the outputs, for rows without missing outputs."""
    single = isinstance(engine.blocks[0], TransferFunction)
    for u, y in pairs:
        for chunk in engine.sensitivities(theta, u):
            finite_rows = np.all(np.isfinite(y[chunk.rows]), axis=1)
            first = chunk.outputs[:, :1] if single else chunk.outputs[:, :0]
            ones = np.ones((len(chunk.outputs), 1))
            x = np.hstack([first, chunk.slopes[:, 0, own], ones])
            yield x[finite_rows], y[chunk.rows][finite_rows]


LAGS = 256
"""Largest number of lags of an impulse response, over the number of inputs."""
SCORED = 20_000
"""Samples for the comparison of poles."""
LEAST_SAMPLES = 200
"""Least number of samples at a lower sample rate."""
Linear: TypeAlias = TransferFunction | StateSpace


def linear_start(
    block: AbstractBlock, w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers], dt: float
) -> LinearStart:
    """Return numbers of an `oe` or `ss` block that reproduce y from w, sampled every dt [s].

    Args:
        block: the block.
        w: inputs, shape (samples,) or (samples, columns); a list for several records.
        y: outputs, likewise; NaN where missing.
        dt: sample time [s].

    Raises:
        InputError: the block is neither an `oe` nor an `ss`.
        DataError: too few samples are known.
    """
    if not isinstance(block, TransferFunction | StateSpace) or not block.linear:
        raise InputError(f"Block `{block.text()}` is no `oe` or `ss`; there is no start for it.")
    pairs = _pair_records(w, y)
    short = _shorten_records(pairs)
    factors = _list_factors(pairs) if _find_order(block) else [1]
    firsts = [_find_poles(block, thin_records(pairs, factor), dt, factor) for factor in factors]
    best = min(firsts, key=lambda poles: fit_weights(block, poles, short, dt).error)
    return fit_weights(block, best, pairs, dt)


def fit_linear_model(
    records: Sampled | Sequence[Sampled], order: int, nk: int = 1, skip: int = 0, iterations: int = 60
) -> Chain:
    """Return the linear model of an order that reproduces records best in free run from the steady state.

    One input and output give `oe(order, order, nk) | poly1`, with one more coefficient for nk = 0; several give one
    `ss` block with offsets.

    Args:
        records: one or several, of one sample time.
        order: number of poles.
        nk: delay in samples.
        skip: samples at the start of every record that do not count.
        iterations: largest number of steps of the refinement.
    """
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    first = max(records, key=len)
    ins, outs = first.inputs.shape[1], first.outputs.shape[1]
    block: Linear = StateSpace(order=order, ins=ins, outs=outs, nk=nk, offset="yes")
    if (ins, outs) == (1, 1):
        block = TransferFunction(nb=order + (nk == 0), nf=order, nk=nk)
    counted = [r.with_outputs(_skip_start(r.outputs, skip)) for r in records]
    return polish_linear(block, counted, "rest", skip, iterations)


def polish_linear(
    block: Linear, records: Sequence[Sampled], start: str = "rest", skip: int = 0, iterations: int = 60
) -> Chain:
    """Return an `oe` or `ss`, with gain and offset if needed, refined from its start.

    Args:
        block: the block.
        records: one or several, of one sample time.
        start: state at the first sample: `rest`, `zero` or `estimate`.
        skip: samples at the start of every record that do not count.
        iterations: largest number of steps of the refinement.

    Raises:
        DataError: too few samples are known.
    """
    first = max(records, key=len)
    lined = block.outputs == 1 and (isinstance(block, TransferFunction) or block.offset == "no")
    chain = build_untrained([block, Polynomial(degree=1)] if lined else [block], first)
    fitted = linear_start(block, [r.inputs for r in records], [r.outputs for r in records], first.interval)
    theta = fitted.theta
    if isinstance(line := chain.blocks[-1], Polynomial):
        theta = np.concatenate([theta, line.line(fitted.gain, fitted.offset)])
    squares = ResidualSquares(chain.engine, [RecordResidual(record, skip, None, start) for record in records])
    if iterations:
        theta = minimise_cost(squares, squares.extend_parameters(theta), iterations).theta[: len(theta)]
    return chain.with_theta(theta)


def _skip_start(y: Numbers, skip: int) -> Numbers:
    skipped = y.copy()
    skipped[:skip] = np.nan
    return skipped


def _pair_records(w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers]) -> list[Pair]:
    inputs = [w] if isinstance(w, np.ndarray) else list(w)
    outputs = [y] if isinstance(y, np.ndarray) else list(y)

    def columns(signal: Numbers) -> Numbers:
        signal = np.asarray(signal, dtype=float)
        return signal[:, None] if signal.ndim == 1 else signal

    return [(columns(a), columns(b)) for a, b in zip(inputs, outputs, strict=True)]


def _shorten_records(pairs: Sequence[Pair]) -> list[Pair]:
    most = max(SCORED // len(pairs), LEAST_SAMPLES)
    return [(u[:most], y[:most]) for u, y in pairs]


def _find_order(block: TransferFunction | StateSpace) -> int:
    return int(block.nf if isinstance(block, TransferFunction) else block.order)


def _list_factors(pairs: Sequence[Pair]) -> list[int]:
    """Return the divisors of the sample rate."""
    longest = max(len(u) for u, _ in pairs)
    return [f for f in (1, 8, 64, 512) if f == 1 or longest // f >= LEAST_SAMPLES]


def _find_poles(block: TransferFunction | StateSpace, pairs: Sequence[Pair], dt: float, factor: int) -> Numbers:
    """Return the poles, and B of several inputs, from records at `factor` times the sample time."""
    order = _find_order(block)
    if not order:
        return np.zeros(0)
    nk = int(block.nk)
    nb = int(block.nb) if isinstance(block, TransferFunction) else order + (nk == 0)
    lags = min(max(LAGS // block.inputs, 32), max(2 * order + 4, max(len(u) for u, _ in pairs) // 4))
    g = impulse_response(pairs, lags, nk // factor)
    model = realise_responses(g[max(nb - order, 0) if factor == 1 else 1 :], order)
    z = np.linalg.eigvals(model.a)
    matched = match_poles(z, dt * factor)
    if block.inputs == 1:
        return matched.numbers
    return np.concatenate([matched.numbers, _find_mixing(block, model, z, matched, dt * factor)])


def _find_mixing(block: AbstractBlock, model: Realisation, z: Numbers, matched: MatchedPoles, dt: float) -> Numbers:
    numbers = list(map(float, matched.numbers))
    n, m = len(numbers), block.inputs

    def after(state: Numbers, fed: Numbers) -> list[float]:
        one, *more = map(float, fed)
        state_numbers = list(map(float, state))
        return sections.step_cascade(floats, n, numbers, state_numbers, one, dt, more or [0.0]).state

    zero = np.zeros(n)
    a = np.column_stack([after(unit, zero) for unit in np.eye(n)])
    fed = np.column_stack([after(zero, unit) for unit in np.eye(n)])
    summed = model.b @ (1.0 / np.arange(1, m + 1))
    joined = Realisation(model.a, np.column_stack([model.b, summed]), model.c)
    cascade_poles = sections.find_poles(n, matched.numbers, dt)
    b = find_entering(joined, z[matched.places], Realisation(a, fed[:, :1], model.c), cascade_poles)
    return np.linalg.solve(fed, b)[:, :-1].ravel()
