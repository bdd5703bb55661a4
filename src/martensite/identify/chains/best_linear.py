"""The best linear approximation: linear models from records, their start without iteration.

A regularised impulse response gives poles (Ho–Kalman); with the poles given, a linear block is
linear in its other numbers, and these follow from least squares. Slow systems are seen at lower
sample times as well: poles are kept in seconds, so the one that explains the records best wins.

Of a nonlinear system under a Gaussian input the best linear approximation has the poles of its
linear blocks, whatever the static ones are (Bussgang's theorem): a start for them all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.errors import InputError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.shared import sections
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.chain import Chain, untrained
from martensite.identify.chains.engine import Engine
from martensite.identify.chains.impulse_response import Pair, impulse_response
from martensite.identify.chains.levenberg import minimise
from martensite.identify.chains.realisation import Matched, Realised, entering, matched, realised
from martensite.identify.chains.residuals import Aim, Squares
from martensite.runtimes import floats
from martensite.signals.sampling.sampled import Sampled

LAGS = 256
"""Most lags of an impulse response, over the number of inputs."""
SCORED = 20_000
"""Samples over which poles found at several sample times are compared."""
FEWEST = 200
"""Samples that a record must keep to be seen at a longer sample time."""


class LinearStart(NamedTuple):
    """Numbers with which y ≈ gain · block(w) + offset."""

    theta: Numbers
    gain: float
    """1 for a block whose gain is free."""
    offset: float
    """0 for a block with offsets of its own, or of several outputs."""
    error: float
    """Sum of squared errors over the outputs' variances."""


def linear_start(
    block: AbstractBlock, w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers], dt: float
) -> LinearStart:
    """Numbers of an `oe` or `ss` block that reproduce y from w as well as its orders allow.

    Args:
        block: the block.
        w: what enters it, shape (samples,) or (samples, inputs); several records as a list.
        y: what leaves it, NaN where it is missing.
        dt: sample time [s].

    Raises:
        InputError: the block is neither an `oe` nor an `ss`.
        DataError: too few samples are known.
    """
    if not isinstance(block, TransferFunction | StateSpace):
        raise InputError(f"Block `{block.text()}` is no `oe` or `ss`; there is no start for it.")
    pairs = _paired(w, y)
    short = _shortened(pairs)
    factors = _factors(pairs) if _order(block) else [1]
    firsts = [_found(block, thinned(pairs, factor), dt, factor) for factor in factors]
    best = min(firsts, key=lambda known: weighted(block, known, short, dt).error)
    return weighted(block, best, pairs, dt)


def best_linear(
    records: Sampled | Sequence[Sampled], order: int, nk: int = 1, skip: int = 0,
    iterations: int = 60,
) -> Chain:  # fmt: skip
    """The linear model of an order that reproduces records best in free run from rest.

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
    block: AbstractBlock = StateSpace(order=order, ins=ins, outs=outs, nk=nk, offset="yes")
    single = (ins, outs) == (1, 1)
    if single:
        block = TransferFunction(nb=order + (nk == 0), nf=order, nk=nk)
    chain = untrained([block, Polynomial(degree=1)] if single else [block], first)
    known = [(r.inputs, _skipped(r.outputs, skip)) for r in records]
    start = linear_start(block, [u for u, _ in known], [y for _, y in known], first.interval)
    theta = start.theta
    if isinstance(line := chain.blocks[-1], Polynomial):
        theta = np.concatenate([theta, line.line(start.gain, start.offset)])
    squares = Squares(chain.engine, [Aim(record, skip) for record in records])
    return chain.with_theta(minimise(squares, theta, iterations).theta if iterations else theta)


def _skipped(y: Numbers, skip: int) -> Numbers:
    kept = y.copy()
    kept[:skip] = np.nan
    return kept


def _paired(
    w: Numbers | Sequence[Numbers], y: Numbers | Sequence[Numbers]
) -> list[Pair]:  # fmt: skip
    inputs = [w] if isinstance(w, np.ndarray) else list(w)
    outputs = [y] if isinstance(y, np.ndarray) else list(y)

    def columns(signal: Numbers) -> Numbers:
        signal = np.asarray(signal, dtype=float)
        return signal[:, None] if signal.ndim == 1 else signal

    return [(columns(a), columns(b)) for a, b in zip(inputs, outputs, strict=True)]


def _shortened(pairs: Sequence[Pair]) -> list[Pair]:
    """The first samples of every record: enough to compare poles."""
    most = max(SCORED // len(pairs), FEWEST)
    return [(u[:most], y[:most]) for u, y in pairs]


def _order(block: TransferFunction | StateSpace) -> int:
    return int(block.nf if isinstance(block, TransferFunction) else block.order)


def _factors(pairs: Sequence[Pair]) -> list[int]:
    """Multiples of the sample time at which records are looked at."""
    longest = max(len(u) for u, _ in pairs)
    return [f for f in (1, 8, 64, 512) if f == 1 or longest // f >= FEWEST]


def thinned(pairs: Sequence[Pair], factor: int) -> list[Pair]:
    """Records averaged over so many samples, inputs and outputs alike."""
    if factor <= 1:
        return list(pairs)
    made: list[Pair] = []
    for u, y in pairs:
        count = len(u) // factor
        if count:
            blocks = y[: count * factor].reshape(count, factor, -1)
            known = np.isfinite(blocks)
            sums, counts = np.where(known, blocks, 0.0).sum(axis=1), known.sum(axis=1)
            mean = np.where(2 * counts >= factor, sums / np.maximum(counts, 1), np.nan)
            made.append((u[: count * factor].reshape(count, factor, -1).mean(axis=1), mean))
    return made


def _found(
    block: TransferFunction | StateSpace, pairs: Sequence[Pair], dt: float, factor: int
) -> Numbers:
    """Poles, and the B of several inputs, from records at `factor` times the sample time."""
    order = _order(block)
    if not order:
        return np.zeros(0)
    nk = int(block.nk)
    nb = int(block.nb) if isinstance(block, TransferFunction) else order + (nk == 0)
    lags = min(
        max(LAGS // block.inputs, 32), max(2 * order + 4, max(len(u) for u, _ in pairs) // 4)
    )
    g = impulse_response(pairs, lags, nk // factor)
    model = realised(g[max(nb - order, 0) if factor == 1 else 1 :], order)
    z = np.linalg.eigvals(model.a)
    found = matched(z, dt * factor)
    if block.inputs == 1:
        return found.numbers
    return np.concatenate([found.numbers, _mixing(block, model, z, found, dt * factor)])


def _mixing(
    block: AbstractBlock, model: Realised, z: Numbers, found: Matched, dt: float
) -> Numbers:  # fmt: skip
    """The free numbers of B."""
    numbers = list(map(float, found.numbers))
    n, m = len(numbers), block.inputs

    def after(state: Numbers, fed: Numbers) -> list[float]:
        one, *more = map(float, fed)
        held = list(map(float, state))
        return sections.cascade(floats, n, numbers, held, one, dt, more or [0.0]).state

    zero = np.zeros(n)
    a = np.column_stack([after(unit, zero) for unit in np.eye(n)])
    fed = np.column_stack([after(zero, unit) for unit in np.eye(n)])
    summed = model.b @ (1.0 / np.arange(1, m + 1))
    joined = Realised(model.a, np.column_stack([model.b, summed]), model.c)
    own = sections.poles(n, found.numbers, dt)
    b = entering(joined, z[found.places], Realised(a, fed[:, :1], model.c), own)
    return np.linalg.solve(fed, b)[:, :-1].ravel()


def weighted(
    block: TransferFunction | StateSpace, known: Numbers, pairs: Sequence[Pair], dt: float
) -> LinearStart:
    """The start with given first numbers; all others are linear and follow from least squares."""
    theta = np.zeros(len(block.numbers()))
    theta[: len(known)] = known
    own = _weighing(block, len(known))
    found, error = _squares(Engine([block], dt), theta, own, pairs)
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


def _weighing(block: TransferFunction | StateSpace, known: int) -> NDArray[np.intp]:
    """Places of the linear numbers; those of the first output, as all sum the same signals."""
    first = ("weight", "c1_", "d1_")
    names = block.numbers()
    return np.array([i for i in range(known, len(names)) if names[i].startswith(first)], np.intp)


def _squares(
    engine: Engine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> tuple[Numbers, float]:
    """Weights of the signals and a constant (the last), and the error over the variances."""
    outputs = np.concatenate([y for _, y in pairs])
    outs = outputs.shape[1]
    total: Numbers | None = None
    for x, y in _signals(engine, theta, own, pairs):
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


def _signals(
    engine: Engine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> Iterator[Pair]:
    """What the linear numbers weigh, with a constant, and the outputs: rows known in all."""
    single = isinstance(engine.blocks[0], TransferFunction)
    for u, y in pairs:
        for chunk in engine.sensitivities(theta, u):
            known = np.all(np.isfinite(y[chunk.rows]), axis=1)
            first = chunk.outputs[:, :1] if single else chunk.outputs[:, :0]
            ones = np.ones((len(chunk.outputs), 1))
            x = np.hstack([first, chunk.slopes[:, 0, own], ones])
            yield x[known], y[chunk.rows][known]
