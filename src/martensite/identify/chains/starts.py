"""Starts of searches for a chain: random dynamics, then a straight line through the data.

For any random numbers, two parameters of the static block with the gain follow from least squares: its line is fitted
to the outputs over the input of the block.

Starts of searches for a chain with linear blocks: the best linear approximation.

The poles of a linear block between static ones are those of the best linear approximation of the whole (see
`best_linear`), so these begin some of the searches, with static blocks as lines or as drawn; blocks with both linear
dynamics and nonlinear terms, such as nonlinear feedback, begin as a linear system without these terms, or with some of
them. Ranges of the blocks are the ranges of their inputs then. A linear model describes hysteresis as lag, and these
ranges are then too narrow. So half of the random searches keep the ranges of the plainest start.

Start of a chain from another chain: an earlier estimate, or a chain of simpler blocks.

Blocks of the same structure are taken over with their numbers. Any other block is fitted to what
the block in its place made of the records: a static one to its curve, a dynamic one to its output.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError, InputError
from martensite.identify.blocks.base import AbstractBlock, AbstractStatic, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import Linear, linear_start, polish_linear
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.chains.wiener_hammerstein import fit_through, is_wiener_hammerstein, wiener_hammerstein_starts
from martensite.search.levenberg_marquardt import minimise_cost
from martensite.signals.sampling.sampled import Sampled


def draw_numbers(chain: Chain, rng: np.random.Generator, record: Sampled) -> Numbers:
    """Return random free numbers of all blocks."""
    parts = [b.sample_parameters(rng, record.duration, record.interval) for b in chain.blocks]
    return np.concatenate([np.zeros(0), *parts])


def align_chain(chain: Chain, records: Sequence[Sampled]) -> Chain:
    """Return the chain with the line of its last static block fitted to the outputs.

    If linear blocks follow it, which have unit gain, the outputs are those of a slow system and
    the same line serves. Outputs that are proportional to a number of the last block get that
    number by least squares. A chain with neither stays as it is.
    """
    with np.errstate(all="ignore"):  # a drawn chain may grow without bound
        return _align_last(_fit_gains(chain, records), records)


def _align_last(chain: Chain, records: Sequence[Sampled]) -> Chain:
    static = [(i, b) for i, b in enumerate(chain.blocks) if isinstance(b, AbstractStatic)]
    if not static or len(chain.output_names) != 1:
        return chain
    place, block = static[-1]
    pairs = [(_find_reaching(chain, place, record), record.outputs[:, 0]) for record in records]
    x, y = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    known = np.isfinite(x) & np.isfinite(y)
    slope, offset = _fit_line(x[known], y[known])
    parts = chain.split()
    parts[place] = _curve_around(parts[place], block, slope, offset)
    return chain.with_theta(np.concatenate(parts))


def _fit_gains(chain: Chain, records: Sequence[Sampled]) -> Chain:
    """Return the chain with the gains of the outputs of its last block fitted, one by one."""
    block = chain.blocks[-1]
    if not any(block.gains()) or chain.taps is not None:
        return chain
    computed = np.concatenate([chain.simulate(record) for record in records])
    measured = np.concatenate([record.outputs for record in records])
    theta = chain.theta.copy()
    first = len(theta) - len(block.numbers())
    for name, y, own in zip(block.gains(), measured.T, computed.T, strict=True):
        known = np.isfinite(y)
        square = float(own[known] @ own[known])
        if name and 0.0 < square < np.inf:
            theta[first + block.numbers().index(name)] *= float(own[known] @ y[known]) / square
    return chain.with_theta(theta)


def _find_reaching(chain: Chain, place: int, record: Sampled) -> Numbers:
    """Return the input of a block, delayed by the delay of the linear blocks after it."""
    own = chain.before(place, record)[:, 0]
    after = chain.blocks[place + 1 :]
    if not after:
        return own
    rest = Chain(after, np.concatenate(chain.split()[place + 1 :]), chain.interval)
    return rest.simulate(own)[:, 0]


def _fit_line(x: Numbers, y: Numbers) -> tuple[float, float]:
    spread = float(np.var(x))
    if not spread > 0.0 or not np.isfinite(spread):
        return 0.0, float(np.mean(y)) if len(y) else 0.0
    slope = float(np.mean((x - x.mean()) * (y - y.mean()))) / spread
    return slope, float(y.mean() - slope * x.mean())


def _curve_around(theta: Numbers, block: AbstractStatic, slope: float, offset: float) -> Numbers:
    """Return the drawn departure from the identity, scaled with the slope, around the line."""
    departure = theta - block.line(1.0, 0.0)
    scaled = block.scale_departure(departure, slope)
    return block.line(slope, offset if block.offset == "yes" else 0.0) + scaled


POLISH = 40
"""Steps by which a linear model is refined before nonlinear terms are added to it."""


def list_informed_starts(
    chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int, state: str = "rest"
) -> list[Chain]:
    """So many chains to start from: one the plainest, some from linear models, others at random.

    The chain is adapted to a record; `state` is that at the first sample of the records, `rest`, `zero` or `estimate`.
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
    """Return starts for linear | static | linear: a linear model shared between both blocks, then random ones."""
    shared = wiener_hammerstein_starts(chain, max(records, key=len), count - 1)
    base = shared[0] if shared else chain
    more = range(max(count - 1 - len(shared), 0))
    others = [chain, *(base.with_theta(draw_numbers(base, rng, records[0])) for _ in more)]
    return [*shared, *(align_chain(one, records) for one in others)]


def linear_twin(block: AbstractBlock) -> Linear | None:
    """Return the `oe` or `ss` that a block is without its nonlinear terms; None if there is none."""
    twin = block.twin()
    return twin if isinstance(twin, TransferFunction | StateSpace) else None


def from_linear(chain: Chain, records: Sequence[Sampled], state: str = "rest") -> Chain | None:
    """Return the chain with its one dynamic block as the best linear model; None if it has not one."""
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
    """Return the numbers of the best linear model; refined where nonlinear terms are to follow."""
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
    """Return the chain, one block as a linear one, all adapted to what reaches them then."""
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
    """Return the same linear dynamics with drawn static blocks and nonlinear terms."""
    parts: list[Numbers] = []
    for block, own in zip(chain.blocks, chain.split(), strict=True):
        some = block.sample_parameters(rng, record.duration, record.interval)
        if isinstance(block, AbstractStatic):
            own = some
        elif not block.linear and block.twin() is not None:
            own = np.where(own == 0.0, some, own)  # nonlinear terms are those that are 0
        parts.append(own)
    return chain.with_theta(np.concatenate([np.zeros(0), *parts]))


FOLLOW_STEPS = 40
"""Number of steps of the search by which a block follows another."""


def begin_from_chain(chain: Chain, given: Chain, records: Sequence[Sampled]) -> Chain:
    """Return the chain with numbers with which it does about what a given one does.

    Raises:
        InputError: the given one has another number of blocks, or of signals between them.
    """
    _check_blocks(chain, given)
    dt = chain.interval
    given = replace(given, interval=dt)
    blocks: list[AbstractBlock] = []
    parts: list[Numbers] = []
    reaching = [record.inputs for record in records]
    for block, known, own in zip(chain.blocks, given.blocks, given.split(), strict=True):
        engine = ChainEngine([known], dt)
        leaving = [engine.simulate(own, x) for x in reaching]
        if block.structure() == known.structure():
            made, numbers = known, own
        else:
            made, numbers = _follow_block(block, _cut_record(reaching, leaving, dt))
        blocks.append(made)
        parts.append(numbers)
        reaching = leaving
    return replace(chain, blocks=tuple(blocks), theta=np.concatenate([np.zeros(0), *parts]))


def _check_blocks(chain: Chain, given: Chain) -> None:
    """Raise `InputError` unless blocks stand for each other one by one."""
    shapes = [[(b.inputs, b.outputs) for b in one.blocks] for one in (chain, given)]
    if shapes[0] != shapes[1]:
        raise InputError(
            f"A search for `{chain.text()}` cannot begin with `{given.text()}`; it takes a chain "
            f"of {len(chain.blocks)} blocks with the same signals between them."
        )


def _cut_record(x: Sequence[Numbers], y: Sequence[Numbers], dt: float) -> list[Sampled]:
    """Return the records of one block."""
    ins = tuple(f"x{i + 1}" for i in range(x[0].shape[1]))
    outs = tuple(f"y{i + 1}" for i in range(y[0].shape[1]))
    return [Sampled("block", dt, a, b, ins, outs) for a, b in zip(x, y, strict=True)]


def _follow_block(block: AbstractBlock, records: Sequence[Sampled]) -> tuple[AbstractBlock, Numbers]:
    """Return the block, adapted, with numbers with which it reproduces the records of another."""
    longest = max(records, key=len)
    dt, x = longest.interval, longest.inputs
    block = block.adapt_to(x, dt)
    if isinstance(block, AbstractStatic):
        return block, fit_through(block, x[:, 0], longest.outputs[:, 0])
    theta = block.start()
    if (twin := linear_twin(block)) is not None:
        linear = polish_linear(twin, records).split()[0]
        block, theta = block.as_linear(twin, linear, x, dt)
    squares = ResidualSquares(ChainEngine([block], dt), [RecordResidual(record) for record in records])
    return block, minimise_cost(squares, theta, FOLLOW_STEPS).theta
