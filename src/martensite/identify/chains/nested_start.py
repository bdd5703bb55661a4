"""A chain that begins where another ended: an earlier estimate, or one of simpler blocks.

Blocks of the same structure are taken over with their numbers. Any other block is fitted to what
the block in its place made of the records: a static one to its curve, a dynamic one to its output.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import InputError
from martensite.identify.blocks.base import AbstractBlock, AbstractStatic, Numbers
from martensite.identify.chains.best_linear import polish_linear
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.linear_start import linear_twin
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.chains.wiener_hammerstein import fit_through
from martensite.search.levenberg_marquardt import minimise_cost
from martensite.signals.sampling.sampled import Sampled

STEPS = 40
"""Of the search by which a block follows another."""


def begin_from_chain(chain: Chain, given: Chain, records: Sequence[Sampled]) -> Chain:
    """The chain with numbers with which it does about what a given one does.

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
    """Records of one block."""
    ins = tuple(f"x{i + 1}" for i in range(x[0].shape[1]))
    outs = tuple(f"y{i + 1}" for i in range(y[0].shape[1]))
    return [Sampled("block", dt, a, b, ins, outs) for a, b in zip(x, y, strict=True)]


def _follow_block(block: AbstractBlock, records: Sequence[Sampled]) -> tuple[AbstractBlock, Numbers]:
    """The block, adapted, with numbers with which it reproduces the records of another."""
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
    return block, minimise_cost(squares, theta, STEPS).theta
