"""Fences: nonlinear terms of dynamic blocks go no further than they went in the records.

Polynomials in states that no record has reached stand for nothing: a resonance that is driven for longer than
in the records takes them there, although its input stays within the range of theirs. Beyond what the states
were in the records such terms keep the value that they had there. See decision 034.
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
    """A block that gives its states, those for the next sample, instead of its outputs."""

    watched: AbstractBlock = part("the block")

    @property
    def inputs(self) -> int:
        """Return the number of inputs of the block."""
        return self.watched.inputs

    @property
    def outputs(self) -> int:
        """Return the states."""
        return self.watched.states()

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the names of the fixed parameters of the block."""
        return self.watched.fixed

    def given(self) -> tuple[float, ...]:
        """Return the fixed parameters of the block."""
        return self.watched.given()

    def with_given(self, values: Sequence[Any]) -> Self:
        """Return a watch on a twin of the block."""
        return self.rebuilt({"watched": self.watched.with_given(values)})

    def structure(self) -> tuple[Any, ...]:
        """Return the structure of the block."""
        return type(self), self.watched.structure()

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the parameters of the block."""
        return self.watched.numbers()

    def states(self) -> int:
        """Return the number of states of the block."""
        return self.watched.states()

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the rest state of the block."""
        return self.watched.rest(xp, theta, x, dt)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the step of the block."""
        after = self.watched.step(xp, theta, state, x, dt)[1]
        return after, after


def fence_chain(chain: Chain, records: Sequence[Sampled], states: Sequence[Numbers]) -> Chain:
    """Return the chain whose nonlinear terms go no further than along its records, which begin in these states."""
    blocks, parts = list(chain.blocks), chain.split()
    last = max((k for k, block in enumerate(blocks) if block.fenced), default=-1)
    reaching = [record.inputs for record in records]
    places = np.cumsum([0, *(block.states() for block in blocks)])
    for k in range(last + 1):
        begin = [np.array(state[places[k] : places[k + 1]]) for state in states]
        if blocks[k].fenced:
            watch = ChainEngine([StateWatch(watched=blocks[k])], chain.interval)
            seen = [watch.simulate(parts[k], x, state.copy()) for x, state in zip(reaching, begin, strict=True)]
            blocks[k] = blocks[k].fence_in(parts[k], np.concatenate([np.array(begin), *seen]), chain.interval)
        if k < last:
            engine = ChainEngine([blocks[k]], chain.interval)
            reaching = [engine.simulate(parts[k], x, state) for x, state in zip(reaching, begin, strict=True)]
    return replace(chain, blocks=tuple(blocks)) if last >= 0 else chain
