"""Running a chain of blocks: simulation, and exact derivatives beside it, in bounded memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.compiled_chain import CompiledChain
from martensite.identify.chains.float_chain import FloatChain
from martensite.identify.chains.native_columns import TILE, pad_count
from martensite.identify.chains.native_source import Taps
from martensite.identify.chains.plan import ChainPlan, plan_blocks
from martensite.kernels.compiler import find_compiler

CHUNK = 4032
"""Samples whose derivatives are held at a time; no power of 2, whose columns share cache lines."""


class ChainStart(NamedTuple):
    """State of a chain at the first sample."""

    state: Numbers
    """Shape (states,)."""
    slopes: Numbers
    """Its derivatives, shape (states, extra + columns)."""


class Chunk(NamedTuple):
    """Some samples of a run: where they are, outputs, and derivatives of these."""

    rows: slice
    outputs: Numbers
    """Shape (samples, outputs)."""
    slopes: Numbers
    """Shape (samples, outputs, extra + columns)."""


class ChainEngine:
    """Blocks in series at one sample time.

    Args:
        blocks: the blocks, with their fixed numbers.
        interval: sample time [s].
        taps: outputs as (number of the block, number of its output); by default all outputs of
            the last block.
        compiled: whether to run in C; by default if there is a compiler.
    """

    def __init__(
        self, blocks: Sequence[AbstractBlock], interval: float, taps: Taps | None = None, compiled: bool | None = None
    ) -> None:
        self.blocks, self.interval = tuple(blocks), interval
        last = len(self.blocks) - 1
        self.taps: Taps = taps or tuple((last, i) for i in range(self.blocks[last].outputs))
        native = find_compiler() is not None if compiled is None else compiled
        self._runner = (CompiledChain if native else FloatChain)(self.plan, self.taps)

    @cached_property
    def plan(self) -> ChainPlan:
        """The traced blocks."""
        return plan_blocks(self.blocks)

    def _numbers(self, theta: Numbers) -> Numbers:
        given = [value for block in self.blocks for value in block.given()]
        return np.array([*theta, *given, self.interval], dtype=float)

    def rest(self, theta: Numbers, x: Numbers, deviation: Numbers | None = None) -> ChainStart:
        """The state at rest under a constant input.

        With a `deviation` of the state from rest, the first columns are derivatives with
        respect to it.
        """
        count, columns = self.plan.states, self.plan.columns
        state, slopes = np.zeros(count), np.zeros((count, columns))
        self._runner.rest(self._numbers(theta), np.ascontiguousarray(x, dtype=float), state, slopes)
        if deviation is None:
            return ChainStart(state, slopes)
        return ChainStart(state + deviation, np.hstack([np.eye(count), slopes]))

    def simulate(self, theta: Numbers, u: Numbers, state: Numbers | None = None) -> Numbers:
        """Outputs (samples, outputs) for inputs (samples, inputs); from rest if no state is given.

        The given state becomes that after the last sample.
        """
        u = np.ascontiguousarray(u, dtype=float)
        state = self.rest(theta, u[0]).state if state is None else state
        y = np.empty((len(u), len(self.taps)))
        self._runner.run(self._numbers(theta), u, state, y)
        return y

    def sensitivities(
        self, theta: Numbers, u: Numbers, start: ChainStart | None = None, chunk: int = CHUNK, reuse: bool = False
    ) -> Iterator[Chunk]:
        """Outputs and their derivatives, some thousand samples at a time.

        With `reuse`, the derivatives are overwritten by those of the next samples.
        """
        u, numbers = np.ascontiguousarray(u, dtype=float), self._numbers(theta)
        start = self.rest(theta, u[0]) if start is None else start
        state, slopes = start.state.copy(), np.array(start.slopes)
        shape = len(self.taps), slopes.shape[1], pad_count(min(chunk, len(u)), TILE)
        room = np.empty(shape)
        for first in range(0, len(u), chunk):
            part = u[first : first + chunk]
            y = np.empty((len(part), len(self.taps)))
            room = room if reuse or not first else np.empty(shape)
            dy = np.moveaxis(room[:, :, : len(part)], 2, 0)
            self._runner.slopes(numbers, part, state, slopes, y, dy)
            yield Chunk(slice(first, first + len(part)), y, dy)

    def jacobian(self, theta: Numbers, u: Numbers, start: ChainStart | None = None) -> tuple[Numbers, Numbers]:
        """Outputs and derivatives of a whole record at once."""
        chunks = list(self.sensitivities(theta, u, start, max(len(u), 1)))
        return chunks[0].outputs, chunks[0].slopes
