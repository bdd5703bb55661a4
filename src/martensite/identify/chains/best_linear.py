"""The numbers of a linear block that are linear once its poles are given, by least squares.

The best linear approximation: linear models from records, their start without iteration.

A regularised impulse response gives poles (Ho–Kalman); with the poles given, a linear block is
linear in its other numbers, and these follow from least squares. Slow systems are seen at lower
sample times as well: poles are kept in seconds, so the one that explains the records best wins.

Of a nonlinear system under a Gaussian input the best linear approximation has the poles of its
linear blocks, whatever the static ones are (Bussgang's theorem): a start for them all.
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
    Matched,
    Pair,
    Realised,
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
    """1 for a block whose gain is free."""
    offset: float
    """Offset of the output; 0 for a block with free offsets, or with several outputs."""
    error: float
    """Sum of squared errors over the outputs' variances."""


def fit_weights(block: TransferFunction | StateSpace, known: Numbers, pairs: Sequence[Pair], dt: float) -> LinearStart:
    """Return the start with given first numbers; all others are linear and follow from least squares."""
    theta = np.zeros(len(block.numbers()))
    theta[: len(known)] = known
    own = _find_weights(block, len(known))
    found, error = _solve_squares(ChainEngine([block], dt), theta, own, pairs)
    if not np.isfinite(error):
        return LinearStart(theta, 1.0, 0.0, np.inf)
    if isinstance(block, TransferFunction):
        gain = float(found[0, 0])
        least = 1e-3 * float(np.abs(found[:-1, 0]).max())
        gain = gain if abs(gain) > least else max(least, 1e-300)
        theta[own] = found[1:-1, 0] / gain
        return LinearStart(theta, gain, float(found[-1, 0]), error)
    # C and D row by row, then the offsets
    n, d = int(block.order), block.inputs * (block.nk < 1.0)
    parts = [found[:n].T.ravel(), found[n : n + d].T.ravel()]
    if block.offset == "yes":
        parts.append(found[-1])
    theta[len(known) :] = np.concatenate(parts)
    single = block.offset == "no" and block.outputs == 1
    return LinearStart(theta, 1.0, float(found[-1, 0]) if single else 0.0, error)


def _find_weights(block: TransferFunction | StateSpace, known: int) -> NDArray[np.intp]:
    """Return the places of the linear numbers; those of the first output, as all sum the same signals."""
    first = ("weight", "c1_", "d1_")
    names = block.numbers()
    return np.array([i for i in range(known, len(names)) if names[i].startswith(first)], np.intp)


def _solve_squares(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> tuple[Numbers, float]:
    """Return the weights of the signals and a constant (the last), and the error over the variances."""
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
    found = np.linalg.lstsq(top / scale, right, rcond=1e-12)[0] / scale[:, None]
    left = np.sum((right - top @ found) ** 2, axis=0) + np.sum(total[count:, count:] ** 2, axis=0)
    spread = np.nanvar(outputs, axis=0)
    return found, float(np.sum(left / np.where(spread > 0.0, spread, 1.0)))


def _collect_signals(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> Iterator[Pair]:
    """Yield the regressors of the linear parameters, with a constant, and the outputs; only fully known rows."""
    single = isinstance(engine.blocks[0], TransferFunction)
    for u, y in pairs:
        for chunk in engine.sensitivities(theta, u):
            known = np.all(np.isfinite(y[chunk.rows]), axis=1)
            first = chunk.outputs[:, :1] if single else chunk.outputs[:, :0]
            ones = np.ones((len(chunk.outputs), 1))
            x = np.hstack([first, chunk.slopes[:, 0, own], ones])
            yield x[known], y[chunk.rows][known]


LAGS = 256
"""Most lags of an impulse response, over the number of inputs."""
SCORED = 20_000
"""Samples over which poles found at several sample times are compared."""
LEAST_SAMPLES = 200
"""Samples that a record must keep to be seen at a longer sample time."""
Linear: TypeAlias = TransferFunction | StateSpace
"""Blocks that these starts are for."""


def linear_start(
    block: AbstractBlock, w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers], dt: float
) -> LinearStart:
    """Numbers of an `oe` or `ss` block that reproduce y from w as well as its orders allow, sampled every dt [s].

    Signals are of shape (samples,) or (samples, columns), several records as a list; y is NaN where it is missing.

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
    best = min(firsts, key=lambda known: fit_weights(block, known, short, dt).error)
    return fit_weights(block, best, pairs, dt)


def best_linear(
    records: Sampled | Sequence[Sampled], order: int, nk: int = 1, skip: int = 0, iterations: int = 60
) -> Chain:
    """Return the linear model of an order that reproduces records best in free run from rest.

    One input and one output give `oe(order, order, nk) | poly1`, with nk = 0 one coefficient
    more; several give one `ss` block with offsets.

    Args:
        records: one or several, of one sample time.
        order: number of poles.
        nk: delay in samples.
        skip: samples at the start of every record that do not count.
        iterations: most steps of the search that refines the start; 0 leaves it.
    """
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    first = max(records, key=len)
    ins, outs = first.inputs.shape[1], first.outputs.shape[1]
    block: Linear = StateSpace(order=order, ins=ins, outs=outs, nk=nk, offset="yes")
    if (ins, outs) == (1, 1):
        block = TransferFunction(nb=order + (nk == 0), nf=order, nk=nk)
    known = [r.with_outputs(_skip_start(r.outputs, skip)) for r in records]
    return polish_linear(block, known, "rest", skip, iterations)


def polish_linear(
    block: Linear, records: Sequence[Sampled], start: str = "rest", skip: int = 0, iterations: int = 60
) -> Chain:
    """Return an `oe` or `ss`, with the line that its gain and offset need, refined from its start.

    `start` is the state at the first sample, `rest`, `zero` or `estimate`; samples before `skip` do not count; with 0
    iterations the start is left.

    Raises:
        DataError: too few samples are known.
    """
    first = max(records, key=len)
    lined = block.outputs == 1 and (isinstance(block, TransferFunction) or block.offset == "no")
    chain = build_untrained([block, Polynomial(degree=1)] if lined else [block], first)
    found = linear_start(block, [r.inputs for r in records], [r.outputs for r in records], first.interval)
    theta = found.theta
    if isinstance(line := chain.blocks[-1], Polynomial):
        theta = np.concatenate([theta, line.line(found.gain, found.offset)])
    squares = ResidualSquares(chain.engine, [RecordResidual(record, skip, None, start) for record in records])
    if iterations:
        theta = minimise_cost(squares, squares.extend_parameters(theta), iterations).theta[: len(theta)]
    return chain.with_theta(theta)


def _skip_start(y: Numbers, skip: int) -> Numbers:
    kept = y.copy()
    kept[:skip] = np.nan
    return kept


def _pair_records(w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers]) -> list[Pair]:
    inputs = [w] if isinstance(w, np.ndarray) else list(w)
    outputs = [y] if isinstance(y, np.ndarray) else list(y)

    def columns(signal: Numbers) -> Numbers:
        signal = np.asarray(signal, dtype=float)
        return signal[:, None] if signal.ndim == 1 else signal

    return [(columns(a), columns(b)) for a, b in zip(inputs, outputs, strict=True)]


def _shorten_records(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the first samples of every record: enough to compare poles."""
    most = max(SCORED // len(pairs), LEAST_SAMPLES)
    return [(u[:most], y[:most]) for u, y in pairs]


def _find_order(block: TransferFunction | StateSpace) -> int:
    return int(block.nf if isinstance(block, TransferFunction) else block.order)


def _list_factors(pairs: Sequence[Pair]) -> list[int]:
    """Return the multiples of the sample time at which records are looked at."""
    longest = max(len(u) for u, _ in pairs)
    return [f for f in (1, 8, 64, 512) if f == 1 or longest // f >= LEAST_SAMPLES]


def _find_poles(block: TransferFunction | StateSpace, pairs: Sequence[Pair], dt: float, factor: int) -> Numbers:
    """Return the poles, and the B of several inputs, from records at `factor` times the sample time."""
    order = _find_order(block)
    if not order:
        return np.zeros(0)
    nk = int(block.nk)
    nb = int(block.nb) if isinstance(block, TransferFunction) else order + (nk == 0)
    lags = min(max(LAGS // block.inputs, 32), max(2 * order + 4, max(len(u) for u, _ in pairs) // 4))
    g = impulse_response(pairs, lags, nk // factor)
    model = realise_responses(g[max(nb - order, 0) if factor == 1 else 1 :], order)
    z = np.linalg.eigvals(model.a)
    found = match_poles(z, dt * factor)
    if block.inputs == 1:
        return found.numbers
    return np.concatenate([found.numbers, _find_mixing(block, model, z, found, dt * factor)])


def _find_mixing(block: AbstractBlock, model: Realised, z: Numbers, found: Matched, dt: float) -> Numbers:
    """Return the free numbers of B."""
    numbers = list(map(float, found.numbers))
    n, m = len(numbers), block.inputs

    def after(state: Numbers, fed: Numbers) -> list[float]:
        one, *more = map(float, fed)
        held = list(map(float, state))
        return sections.step_cascade(floats, n, numbers, held, one, dt, more or [0.0]).state

    zero = np.zeros(n)
    a = np.column_stack([after(unit, zero) for unit in np.eye(n)])
    fed = np.column_stack([after(zero, unit) for unit in np.eye(n)])
    summed = model.b @ (1.0 / np.arange(1, m + 1))
    joined = Realised(model.a, np.column_stack([model.b, summed]), model.c)
    own = sections.find_poles(n, found.numbers, dt)
    b = find_entering(joined, z[found.places], Realised(a, fed[:, :1], model.c), own)
    return np.linalg.solve(fed, b)[:, :-1].ravel()
