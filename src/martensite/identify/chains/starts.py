"""Starts of searches for a chain: random dynamics, linear models, and earlier chains.

For random numbers, a line of the last static block is fitted to the outputs by least squares.

The poles of a linear block between static blocks are the poles of the best linear approximation of the whole (see
`best_linear`), which starts some of the searches, with static blocks as lines or random. Blocks with linear dynamics
and nonlinear terms start as a linear system, with or without some of these terms. The ranges of the blocks are then
the ranges of their inputs. A linear model describes hysteresis as lag, which makes the ranges too narrow, so half of
the random searches keep the ranges of the simplest start.

From an earlier chain, or a chain of simpler blocks, blocks of the same structure are copied. Any other block is fitted
to the signals of the block in its place: a static one to its curve, a dynamic one to its output.
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

    Linear blocks after it have unit gain, so the same line serves. A number of the last block that is proportional to
    an output is fitted by least squares.
    """
    with np.errstate(all="ignore"):  # a random chain may be unbounded
        return _align_last(_fit_gains(chain, records), records)


def _align_last(chain: Chain, records: Sequence[Sampled]) -> Chain:
    static = [(i, b) for i, b in enumerate(chain.blocks) if isinstance(b, AbstractStatic)]
    if not static or len(chain.output_names) != 1:
        return chain
    place, block = static[-1]
    pairs = [(_find_reaching(chain, place, record), record.outputs[:, 0]) for record in records]
    x, y = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    finite = np.isfinite(x) & np.isfinite(y)
    slope, offset = _fit_line(x[finite], y[finite])
    parts = chain.split()
    parts[place] = _curve_around(parts[place], block, slope, offset)
    return chain.with_theta(np.concatenate(parts))


def _fit_gains(chain: Chain, records: Sequence[Sampled]) -> Chain:
    block = chain.blocks[-1]
    if not any(block.gains()) or chain.taps is not None:
        return chain
    computed = np.concatenate([chain.simulate(record) for record in records])
    measured = np.concatenate([record.outputs for record in records])
    theta = chain.theta.copy()
    first = len(theta) - len(block.numbers())
    for name, y, computed_column in zip(block.gains(), measured.T, computed.T, strict=True):
        finite = np.isfinite(y)
        square = float(computed_column[finite] @ computed_column[finite])
        if name and 0.0 < square < np.inf:
            theta[first + block.numbers().index(name)] *= float(computed_column[finite] @ y[finite]) / square
    return chain.with_theta(theta)


def _find_reaching(chain: Chain, place: int, record: Sampled) -> Numbers:
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
    """Return the departure from the identity, scaled with the slope, around the line."""
    departure = theta - block.line(1.0, 0.0)
    scaled = block.scale_departure(departure, slope)
    return block.line(slope, offset if block.offset == "yes" else 0.0) + scaled


POLISH = 40
"""Steps of the refinement of a linear model before nonlinear terms are added."""


def list_informed_starts(
    chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int, state: str = "rest"
) -> list[Chain]:
    """Return `count` starts: the simplest chain, some from linear models, others random.

    Args:
        chain: chain adapted to a record.
        records: records of one sample time.
        rng: generator of random starts.
        count: number of starts.
        state: state at the first sample: `rest`, `zero` or `estimate`.
    """
    if count < 1:
        return []
    if count == 1:
        return [align_chain(chain, records)]
    if is_wiener_hammerstein(chain.blocks) and records[0].outputs.shape[1] == 1:
        return _shared_out(chain, records, rng, count)
    linear = from_linear(chain, records, state)
    starts = [chain]
    if linear is not None:
        starts.append(linear)
        starts += [_bend_start(linear, rng, records[0]) for _ in range(max(count // 4, 1))]
    for k in range(count - len(starts)):
        base = linear if linear is not None and k % 2 else chain
        starts.append(base.with_theta(draw_numbers(base, rng, records[0])))
    return [align_chain(one, records) for one in starts[:count]]


def _shared_out(chain: Chain, records: Sequence[Sampled], rng: np.random.Generator, count: int) -> list[Chain]:
    """Return starts of linear | static | linear: linear models divided between both blocks, then random ones."""
    shared = wiener_hammerstein_starts(chain, max(records, key=len), count - 1)
    base = shared[0] if shared else chain
    more = range(max(count - 1 - len(shared), 0))
    others = [chain, *(base.with_theta(draw_numbers(base, rng, records[0])) for _ in more)]
    return [*shared, *(align_chain(one, records) for one in others)]


def linear_twin(block: AbstractBlock) -> Linear | None:
    """Return the linear `oe` or `ss` of a block without its nonlinear terms, or None."""
    twin = block.twin()
    return twin if isinstance(twin, TransferFunction | StateSpace) else None


def from_linear(chain: Chain, records: Sequence[Sampled], state: str = "rest") -> Chain | None:
    """Return the chain with its single dynamic block as the best linear model, or None."""
    twins = [(i, twin) for i, b in enumerate(chain.blocks) if (twin := linear_twin(b)) is not None]
    if len(twins) != 1 or chain.taps is not None:
        return None
    place, twin = twins[0]
    single = twin.outputs == 1 and records[0].outputs.shape[1] == 1
    if not single and place != len(chain.blocks) - 1:
        return None
    reaching = [chain.before(place, record) for record in records]
    try:
        numbers = _fit_linear_start(twin, twin is chain.blocks[place], reaching, records, state)
    except DataError:
        return None
    return None if numbers is None else _adapt_again(chain, place, numbers, max(records, key=len))


def _fit_linear_start(
    twin: Linear, linear: bool, reaching: Sequence[Numbers], records: Sequence[Sampled], state: str
) -> Numbers | None:
    """Return the numbers of the best linear model, refined if nonlinear terms follow."""
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
    """Return the chain with one linear block, all adapted to their inputs."""
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
    """Return the chain with the same linear dynamics, random static blocks and nonlinear terms."""
    parts: list[Numbers] = []
    for block, numbers in zip(chain.blocks, chain.split(), strict=True):
        some = block.sample_parameters(rng, record.duration, record.interval)
        if isinstance(block, AbstractStatic):
            numbers = some
        elif not block.linear and block.twin() is not None:
            numbers = np.where(numbers == 0.0, some, numbers)  # nonlinear terms are 0
        parts.append(numbers)
    return chain.with_theta(np.concatenate([np.zeros(0), *parts]))


FOLLOW_STEPS = 40
"""Steps of the search by which a block imitates another."""


def begin_from_chain(chain: Chain, given: Chain, records: Sequence[Sampled]) -> Chain:
    """Return the chain with numbers that imitate a given one.

    Raises:
        InputError: the given chain has another number of blocks, or of signals between them.
    """
    _check_blocks(chain, given)
    dt = chain.interval
    given = replace(given, interval=dt)
    blocks: list[AbstractBlock] = []
    parts: list[Numbers] = []
    reaching = [record.inputs for record in records]
    for block, given_block, given_numbers in zip(chain.blocks, given.blocks, given.split(), strict=True):
        engine = ChainEngine([given_block], dt)
        leaving = [engine.simulate(given_numbers, x) for x in reaching]
        if block.structure() == given_block.structure():
            copy, numbers = given_block, given_numbers
        else:
            copy, numbers = _follow_block(block, _cut_record(reaching, leaving, dt))
        blocks.append(copy)
        parts.append(numbers)
        reaching = leaving
    return replace(chain, blocks=tuple(blocks), theta=np.concatenate([np.zeros(0), *parts]))


def _check_blocks(chain: Chain, given: Chain) -> None:
    shapes = [[(b.inputs, b.outputs) for b in one.blocks] for one in (chain, given)]
    if shapes[0] != shapes[1]:
        raise InputError(
            f"A search for `{chain.text()}` cannot begin with `{given.text()}`; it takes a chain "
            f"of {len(chain.blocks)} blocks with the same signals between them."
        )


def _cut_record(x: Sequence[Numbers], y: Sequence[Numbers], dt: float) -> list[Sampled]:
    ins = tuple(f"x{i + 1}" for i in range(x[0].shape[1]))
    outs = tuple(f"y{i + 1}" for i in range(y[0].shape[1]))
    return [Sampled("block", dt, a, b, ins, outs) for a, b in zip(x, y, strict=True)]


def _follow_block(block: AbstractBlock, records: Sequence[Sampled]) -> tuple[AbstractBlock, Numbers]:
    """Return the adapted block with numbers that reproduce records of another block."""
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
