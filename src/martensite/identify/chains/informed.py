"""Where searches for a chain begin if there are linear blocks: at the best linear approximation.

The poles of a linear block between static ones are those of the best linear approximation of the
whole (see `best_linear`), so these begin some of the searches, with static blocks as lines or as
drawn. Ranges of static blocks are those of what reaches them then. The other searches begin at
random, and one with the plainest numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.errors import DataError
from martensite.identify.blocks.base import AbstractStatic, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import linear_start, thinned
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import Engine
from martensite.identify.chains.starts import aligned, drawn
from martensite.identify.chains.wiener_hammerstein import (
    is_wiener_hammerstein,
    wiener_hammerstein_starts,
)
from martensite.signals.sampling.sampled import Sampled

LOST = 0.002
"""Most of the variance of an output that thinning may average away."""
WORTH = 5
"""Least factor of thinning that is worth what it blurs."""
PART = 12_000
"""Samples of a record that cannot be thinned with which first searches begin."""


def begins(
    chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int
) -> list[Chain]:
    """Chains to start from: one the plainest, some from linear models, others at random."""
    if count <= 1:
        return [aligned(chain, records)]
    if is_wiener_hammerstein(chain.blocks) and records[0].outputs.shape[1] == 1:
        shared = wiener_hammerstein_starts(chain, max(records, key=len), count - 1)
        base = shared[0] if shared else chain
        more = range(max(count - 1 - len(shared), 0))
        others = [chain, *(base.with_theta(drawn(base, rng, records[0])) for _ in more)]
        return [*shared, *(aligned(one, records) for one in others)]
    linear = from_linear(chain, records)
    known = linear or chain
    plain = [b.start() for b in known.blocks]
    made = [known.with_theta(np.concatenate([np.zeros(0), *plain]))]
    if linear is not None:
        made.append(linear)
        made += [_bent(linear, rng, records[0]) for _ in range(count // 4)]
    more = range(count - len(made))
    made = made[:count] + [known.with_theta(drawn(known, rng, records[0])) for _ in more]
    return [aligned(one, records) for one in made]


def from_linear(chain: Chain, records: Sequence[Sampled]) -> Chain | None:
    """The chain with its one linear block as the best linear model; None if it has not one."""
    places = [i for i, b in enumerate(chain.blocks) if isinstance(b, TransferFunction | StateSpace)]
    if len(places) != 1 or chain.taps is not None:
        return None
    place = places[0]
    block = chain.blocks[place]
    single = block.outputs == 1 and records[0].outputs.shape[1] == 1
    if not single and place != len(chain.blocks) - 1:
        return None
    reaching = [chain.before(place, record) for record in records]
    try:
        start = linear_start(block, reaching, [r.outputs for r in records], chain.interval)
    except DataError:
        return None
    if not np.isfinite(start.error) or not np.all(np.isfinite(start.theta)):
        return None
    parts = [start.theta if i == place else b.start() for i, b in enumerate(chain.blocks)]
    return _readapted(chain, parts, max(records, key=len))


def _readapted(chain: Chain, parts: Sequence[Numbers], record: Sampled) -> Chain:
    """The chain with its blocks adapted to what reaches them, static ones as lines again."""
    blocks, theta, x = list(chain.blocks), list(parts), record.inputs
    for i, block in enumerate(blocks):
        blocks[i] = block.adapted(x, chain.interval)
        if not block.linear:
            theta[i] = blocks[i].start()
        x = Engine([blocks[i]], chain.interval).simulate(theta[i], x)
    return replace(chain, blocks=tuple(blocks), theta=np.concatenate([np.zeros(0), *theta]))


def _bent(chain: Chain, rng: np.random.Generator, record: Sampled) -> Chain:
    """The same dynamics between static blocks as drawn."""
    parts = [
        b.drawn(rng, record.duration, record.interval) if isinstance(b, AbstractStatic) else own
        for b, own in zip(chain.blocks, chain.split(), strict=True)
    ]
    return chain.with_theta(np.concatenate([np.zeros(0), *parts]))


def thinnest(records: Sequence[Sampled], factor: int) -> int:
    """The largest factor, up to a given one, whose averages keep the outputs' variance.

    White noise, which averages away as well, is told by what averages of two samples lose.
    """
    if factor <= 1:
        return factor
    most, pair = factor, _lost(records, 2)
    while factor > 1 and np.any(_lost(records, factor) - 2.0 * (1.0 - 1.0 / factor) * pair > LOST):
        factor //= 2
    return factor if factor >= min(WORTH, most) else 1


def _lost(records: Sequence[Sampled], factor: int) -> Numbers:
    """Share of the variance of every output that averages over some samples lose."""
    pairs = [(r.inputs, r.outputs) for r in records]
    means = np.concatenate([y for _, y in thinned(pairs, factor)])
    outputs = np.concatenate([y for _, y in pairs])
    if np.any(np.isfinite(means).sum(axis=0) < 2):
        return np.ones(outputs.shape[1])
    whole = np.nanvar(outputs, axis=0)
    return 1.0 - np.nanvar(means, axis=0) / np.where(whole > 0.0, whole, 1.0)
