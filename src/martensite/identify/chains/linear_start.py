"""Where searches for a chain begin if there are linear blocks: at the best linear approximation.

The poles of a linear block between static ones are those of the best linear approximation of the
whole (see `best_linear`), so these begin some of the searches, with static blocks as lines or as
drawn; blocks with linear dynamics of their own, such as nonlinear feedback, begin as the linear
system that they are without their nonlinear terms, or with some of these. Ranges of the blocks are
those of what reaches them then. Where there is hysteresis, a linear model takes it for lag and
these ranges are too narrow: half of the searches that begin at random keep those of the plainest
numbers, with which one search begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import AbstractBlock, AbstractStatic, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import Linear, linear_start, polish_linear
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.starts import align_chain, draw_numbers
from martensite.identify.chains.wiener_hammerstein import is_wiener_hammerstein, wiener_hammerstein_starts
from martensite.signals.sampling.sampled import Sampled

POLISH = 40
"""Steps by which a linear model is refined before nonlinear terms are added to it."""


def list_informed_starts(
    chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int, state: str = "rest"
) -> list[Chain]:
    """Chains to start from: one the plainest, some from linear models, others at random.

    Args:
        chain: the structure, adapted to a record.
        records: one or several, of its sample time.
        rng: what draws.
        count: how many.
        state: at the first sample of the records: `rest`, `zero`, `estimate`.
    """
    if count < 1:
        return []
    if count == 1:
        return [align_chain(chain, records)]
    if is_wiener_hammerstein(chain.blocks) and records[0].outputs.shape[1] == 1:
        return _shared_out(chain, records, rng, count)
    linear = from_linear(chain, records, state)
    made = [chain]
    if linear is not None:
        made.append(linear)
        made += [_bend_start(linear, rng, records[0]) for _ in range(max(count // 4, 1))]
    for k in range(count - len(made)):
        base = linear if linear is not None and k % 2 else chain
        made.append(base.with_theta(draw_numbers(base, rng, records[0])))
    return [align_chain(one, records) for one in made[:count]]


def _shared_out(chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int) -> list[Chain]:
    """Of linear | static | linear: one linear model shared out, then at random."""
    shared = wiener_hammerstein_starts(chain, max(records, key=len), count - 1)
    base = shared[0] if shared else chain
    more = range(max(count - 1 - len(shared), 0))
    others = [chain, *(base.with_theta(draw_numbers(base, rng, records[0])) for _ in more)]
    return [*shared, *(align_chain(one, records) for one in others)]


def linear_twin(block: AbstractBlock) -> Linear | None:
    """The `oe` or `ss` that a block is without its nonlinear terms; None if there is none."""
    twin = block.twin()
    return twin if isinstance(twin, TransferFunction | StateSpace) else None


def from_linear(chain: Chain, records: Sequence[Sampled], state: str = "rest") -> Chain | None:
    """The chain with its one dynamic block as the best linear model; None if it has not one."""
    twins = [(i, twin) for i, b in enumerate(chain.blocks) if (twin := linear_twin(b)) is not None]
    if len(twins) != 1 or chain.taps is not None:
        return None
    place, twin = twins[0]
    single = twin.outputs == 1 and records[0].outputs.shape[1] == 1
    if not single and place != len(chain.blocks) - 1:
        return None
    reaching = [chain.before(place, record) for record in records]
    try:
        own = _fit_linear_start(twin, twin is chain.blocks[place], reaching, records, state)
    except DataError:
        return None
    return None if own is None else _adapt_again(chain, place, own, max(records, key=len))


def _fit_linear_start(
    twin: Linear, linear: bool, reaching: Sequence[Numbers], records: Sequence[Sampled], state: str
) -> Numbers | None:
    """Numbers of the best linear model; refined where nonlinear terms are to follow."""
    if linear:
        start = linear_start(twin, reaching, [r.outputs for r in records], records[0].interval)
        theta = start.theta if np.isfinite(start.error) else np.full(1, np.nan)
    else:
        names = tuple(f"x{i + 1}" for i in range(twin.inputs))
        pairs = zip(records, reaching, strict=True)
        between = [replace(r, inputs=x, input_names=names, units={}) for r, x in pairs]
        theta = polish_linear(twin, between, state, iterations=POLISH).split()[0]
    return theta if np.all(np.isfinite(theta)) else None


def _adapt_again(chain: Chain, place: int, own: Numbers, record: Sampled) -> Chain:
    """The chain, one block as a linear one, all adapted to what reaches them then."""
    blocks, theta, x = list(chain.blocks), list[Numbers](), record.inputs
    for i, block in enumerate(blocks):
        blocks[i] = block.adapt_to(x, chain.interval)
        numbers = blocks[i].start()
        if i == place and (twin := linear_twin(block)) is not None:
            blocks[i], numbers = blocks[i].as_linear(twin, own, x, chain.interval)
        theta.append(numbers)
        x = ChainEngine([blocks[i]], chain.interval).simulate(numbers, x)
    return replace(chain, blocks=tuple(blocks), theta=np.concatenate([np.zeros(0), *theta]))


def _bend_start(chain: Chain, rng: np.random.Generator, record: Sampled) -> Chain:
    """The same linear dynamics, between static blocks and with nonlinear terms as drawn."""
    parts: list[Numbers] = []
    for block, own in zip(chain.blocks, chain.split(), strict=True):
        some = block.sample_parameters(rng, record.duration, record.interval)
        if isinstance(block, AbstractStatic):
            own = some
        elif not block.linear and block.twin() is not None:
            own = np.where(own == 0.0, some, own)  # nonlinear terms are those that are 0
        parts.append(own)
    return chain.with_theta(np.concatenate([np.zeros(0), *parts]))
