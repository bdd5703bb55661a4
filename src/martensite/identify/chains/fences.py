"""Limits of nonlinear terms to their range in the records.

Polynomials in states beyond the records are meaningless, and a resonance driven for longer than in the records leads
there. Beyond the range of the states in the records such terms are constant. See decision 034.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np

from martensite.base.parameters import part
from martensite.identify.blocks.base import AbstractBlock, Column, Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.sampling.sampled import Sampled


class StateWatch(AbstractBlock):
    """A block whose outputs are its next states."""

    watched: AbstractBlock = part("the block")

    @property
    def inputs(self) -> int:
        return self.watched.inputs

    @property
    def outputs(self) -> int:
        return self.watched.states()

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        return self.watched.fixed

    def fixed_values(self) -> tuple[float, ...]:
        return self.watched.fixed_values()

    def with_fixed_values(self, values: Sequence[Any]) -> Self:
        return self.rebuilt({"watched": self.watched.with_fixed_values(values)})

    def structure(self) -> tuple[Any, ...]:
        return type(self), self.watched.structure()

    def numbers(self) -> tuple[str, ...]:
        return self.watched.numbers()

    def states(self) -> int:
        return self.watched.states()

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return self.watched.rest(xp, theta, x, dt)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        after = self.watched.step(xp, theta, state, x, dt)[1]
        return after, after


def fence_chain(chain: Chain, records: Sequence[Sampled], states: Sequence[Numbers]) -> Chain:
    """Return the chain with nonlinear terms limited to their range along its records, which start in these states."""
    blocks, parts = list(chain.blocks), chain.split()
    last = max((k for k, block in enumerate(blocks) if block.fenced), default=-1)
    reaching = [record.inputs for record in records]
    places = np.cumsum([0, *(block.states() for block in blocks)])
    for k in range(last + 1):
        begin = [np.array(state[places[k] : places[k + 1]]) for state in states]
        if blocks[k].fenced:
            watch = ChainEngine([StateWatch(watched=blocks[k])], chain.interval)
            watched = [watch.simulate(parts[k], x, state.copy()) for x, state in zip(reaching, begin, strict=True)]
            blocks[k] = blocks[k].fence_in(parts[k], np.concatenate([np.array(begin), *watched]), chain.interval)
        if k < last:
            engine = ChainEngine([blocks[k]], chain.interval)
            reaching = [engine.simulate(parts[k], x, state) for x, state in zip(reaching, begin, strict=True)]
    return replace(chain, blocks=tuple(blocks)) if last >= 0 else chain
