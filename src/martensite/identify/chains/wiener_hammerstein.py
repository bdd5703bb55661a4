"""Starts of linear | static | linear chains: one linear model divided between two blocks.

Under a Gaussian input the best linear approximation has the poles and zeros of both blocks, without their assignment.
All partitions of its real and paired poles and zeros are tried: with given blocks, a polynomial between them is linear
in its coefficients. The best partitions are refined.

Source: Sjöberg, Schoukens 2012 (initialising Wiener–Hammerstein models by exhaustive partition).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import AbstractBlock, AbstractStatic, Numbers
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import fit_weights, linear_start
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.impulse_response import match_poles
from martensite.identify.chains.linear_system import Orders, find_orders, find_poles, find_zeros
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.search.levenberg_marquardt import minimise_cost
from martensite.signals.sampling.sampled import Sampled

DEGREE = 5
"""Degree of the polynomial in the test of a partition."""
MOST_PARTITIONS = 400
"""Largest number of tested partitions; more are sampled evenly."""
SCORED = 12_000
"""Samples for the test of partitions."""
POLISHED = 30_000
"""Samples for the refinement of linear models."""
PROBE = 2_000
"""Samples of noise by which a filter is converted to a block."""


class PoleZeroPartition(NamedTuple):
    """A partition of poles and zeros: filters of both blocks, and its error."""

    filters: tuple[tuple[Numbers, Numbers], tuple[Numbers, Numbers]]
    curve: Numbers
    """Coefficients of the polynomial between them, lowest first."""
    error: float


def is_wiener_hammerstein(blocks: Sequence[AbstractBlock]) -> bool:
    """Return whether a chain is `linear | static | linear` of one signal, with linear blocks `oe` or `ss`."""
    return (
        len(blocks) == 3
        and isinstance(blocks[1], AbstractStatic)
        and all(find_orders(block) is not None for block in (blocks[0], blocks[2]))
    )


def wiener_hammerstein_starts(chain: Chain, record: Sampled, most: int = 24) -> list[Chain]:
    """Return start chains, best first, for a `linear | static | linear` of one input and output."""
    first, last = find_orders(chain.blocks[0]), find_orders(chain.blocks[2])
    if first is None or last is None or not is_wiener_hammerstein(chain.blocks):
        return []
    short = record.rows(0, SCORED)
    both = Orders(first.nb + last.nb - 1, first.nf + last.nf, first.nk + last.nk)
    shared: list[PoleZeroPartition] = []
    for z_poles, z_zeros in _linear_models(both, record):
        shared += shared_out(z_poles, z_zeros, first, last, short)
    shared.sort(key=lambda one: one.error)
    refined = [_with_polynomial(chain, one, short) for one in shared[: 2 * most]]
    refined.sort(key=lambda one: one[0])
    return [_begin_chain(chain, one, short) for _, one in refined[:most]]


def _linear_models(both: Orders, record: Sampled) -> list[tuple[Numbers, Numbers]]:
    """Return poles and zeros of linear models of both blocks together, before and after refinement.

    A model with one more sample of delay omits a zero that records hardly show.
    """
    models: list[tuple[Numbers, Numbers]] = []
    for late in (0, 1) if both.nb > 1 else (0,):
        block = TransferFunction(nb=both.nb - late, nf=both.nf, nk=both.nk + late)
        chain = build_untrained([block, Polynomial(degree=1)], record)
        start = linear_start(block, record.inputs, record.outputs, record.interval)
        line = chain.blocks[1]
        made_line = line.line(start.gain, start.offset) if isinstance(line, Polynomial) else ()
        theta = np.concatenate([start.theta, made_line])
        squares = ResidualSquares(chain.engine, [RecordResidual(record.rows(0, POLISHED))])
        for one in (theta, minimise_cost(squares, theta, 40).theta):
            numbers = one[: len(start.theta)]
            models.append((find_poles(block, numbers, record.interval), find_zeros(block, numbers, record.interval)))
    return models


def shared_out(
    z_poles: Numbers, z_zeros: Numbers, first: Orders, last: Orders, record: Sampled
) -> list[PoleZeroPartition]:
    """Return all partitions of poles and zeros, best first."""
    ways = [
        (p, z)
        for p in _list_choices(z_poles, first.nf, last.nf)
        for z in _list_choices(z_zeros, first.nb - 1, last.nb - 1)
    ]
    every = max(len(ways) // MOST_PARTITIONS, 1)
    delay = first.nk + last.nk
    u = record.inputs[:, 0]
    u = np.concatenate([np.full(delay, u[0]), u])[: len(u)]
    scored = [_score_sharing(p, z, u, record.outputs[:, 0]) for p, z in ways[::every]]
    return sorted(scored, key=lambda one: one.error)


def _list_choices(z: Numbers, first: int, last: int) -> list[tuple[Numbers, Numbers]]:
    """Return all partitions of roots into at most `first` and `last`."""
    pairs = [np.array([one, one.conj()]) for one in z if one.imag > 0.0]
    groups = pairs + [np.array([one]) for one in z if one.imag == 0.0]
    choices: list[tuple[Numbers, Numbers]] = []
    for count in range(len(groups) + 1):
        for chosen in combinations(range(len(groups)), count):
            parts = ([groups[i] for i in chosen], [g for i, g in enumerate(groups) if i not in chosen])
            a, b = (np.concatenate([np.zeros(0, complex), *part]) for part in parts)
            if len(a) <= first and len(b) <= last:
                choices.append((a, b))
    return choices


def _score_sharing(p: tuple[Numbers, Numbers], z: tuple[Numbers, Numbers], u: Numbers, y: Numbers) -> PoleZeroPartition:
    """Return filters of unit static gain (or unit size), and the best polynomial between them."""
    filters = tuple(_build_filter(zeros_, poles_) for zeros_, poles_ in zip(z, p, strict=True))
    x = _filter_signal(filters[0], u)
    size = max(float(np.abs(x).max()), 1e-300)
    basis = [np.ones(len(u)), *(_filter_signal(filters[1], (x / size) ** k) for k in range(1, DEGREE + 1))]
    finite = np.isfinite(y)
    columns = np.column_stack(basis)[finite]
    with np.errstate(all="ignore"):
        if not np.all(np.isfinite(columns)):
            return PoleZeroPartition((filters[0], filters[1]), np.zeros(DEGREE + 1), np.inf)
    weights = np.linalg.lstsq(columns, y[finite], rcond=None)[0]
    error = float(np.mean((y[finite] - columns @ weights) ** 2))
    return PoleZeroPartition((filters[0], filters[1]), weights / size ** np.arange(DEGREE + 1), error)


def _build_filter(zeros_: Numbers, poles_: Numbers) -> tuple[Numbers, Numbers]:
    b, a = np.real(np.atleast_1d(np.poly(zeros_))), np.real(np.atleast_1d(np.poly(poles_)))
    gain = float(b.sum() / a.sum())
    return b / (gain if abs(gain) > 1e-3 * np.abs(b).max() else 1.0), a


def _filter_signal(one: tuple[Numbers, Numbers], x: Numbers) -> Numbers:
    """Return a filtered signal from the steady state under the first sample."""
    from scipy.signal import lfilter  # its import takes a second

    b, a = one
    gain = float(b.sum() / a.sum())
    return gain * x[0] + np.asarray(lfilter(b, a, x - x[0]))


def _place_poles(chain: Chain, way: PoleZeroPartition, static: AbstractBlock, record: Sampled) -> Chain:
    """Return the chain with the numbers of a partition, and a static block between."""
    from scipy.signal import lfilter

    probe = np.random.default_rng(0).normal(size=PROBE)
    probe[0] = 0.0
    dt, u = chain.interval, record.inputs
    parts: list[Numbers] = []
    gains: list[float] = []
    for block, (b, a) in zip((chain.blocks[0], chain.blocks[2]), way.filters, strict=True):
        shape = find_orders(block)
        if shape is None or not isinstance(block, TransferFunction | StateSpace):
            return chain
        wanted = np.asarray(lfilter(b, a, np.concatenate([np.zeros(shape.nk), probe])[:PROBE]))
        poles = match_poles(_pad_poles(a, shape.nf), dt).numbers
        start = fit_weights(block, poles, [(probe[:, None], wanted[:, None])], dt)
        parts.append(start.theta)
        gains.append(start.gain)
    x = ChainEngine(chain.blocks[:1], dt).simulate(parts[0], u)
    static = static.adapt_to(x, dt)
    curve = gains[1] * np.polyval(way.curve[::-1], gains[0] * x[:, 0])
    return replace(
        chain,
        blocks=(chain.blocks[0], static, chain.blocks[2]),
        theta=np.concatenate([parts[0], fit_through(static, x[:, 0], curve), parts[1]]),
    )


def _with_polynomial(chain: Chain, way: PoleZeroPartition, record: Sampled) -> tuple[float, Chain]:
    """Return cost and chain of a partition, refined with a polynomial between the blocks."""
    placed = _place_poles(chain, way, Polynomial(degree=DEGREE), record)
    squares = ResidualSquares(placed.engine, [RecordResidual(record)])
    end = minimise_cost(squares, placed.theta, 25)
    return end.value, placed.with_theta(end.theta)


def _begin_chain(chain: Chain, with_polynomial: Chain, record: Sampled) -> Chain:
    """Return the chain with the dynamics of another, and a static block near its polynomial."""
    first, curve, last = with_polynomial.split()
    dt = chain.interval
    x = ChainEngine(chain.blocks[:1], dt).simulate(first, record.inputs)
    y = ChainEngine(with_polynomial.blocks[1:2], dt).simulate(curve, x)
    static = chain.blocks[1].adapt_to(x, dt)
    return replace(
        chain,
        blocks=(chain.blocks[0], static, chain.blocks[2]),
        theta=np.concatenate([first, fit_through(static, x[:, 0], y[:, 0]), last]),
    )


def _pad_poles(a: Numbers, count: int) -> Numbers:
    """Return the poles of a denominator, filled up with fast ones."""
    z = np.roots(a)
    return np.concatenate([z, np.full(count - len(z), 1e-3)])


def fit_through(block: AbstractBlock, x: Numbers, y: Numbers, points: int = 400) -> Numbers:
    """Return the free numbers of a static block near the curve through points (x, y)."""
    order = np.argsort(x)[np.linspace(0, len(x) - 1, min(points, len(x))).astype(int)]
    record = Sampled("curve", 1.0, x[order], y[order], ("x",), ("y",))
    slope, offset = np.polyfit(x[order], y[order], 1)
    theta = block.line(float(slope), float(offset)) if isinstance(block, AbstractStatic) else (block.start())
    squares = ResidualSquares(ChainEngine([block], 1.0), [RecordResidual(record)], ridge=1e-6, reference=theta)
    return minimise_cost(squares, theta, 30).theta
