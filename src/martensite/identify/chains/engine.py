"""Simulation of a chain of blocks with exact derivatives, in bounded memory.

In C all columns of derivatives are computed in one pass with the simulation. Without a compiler the same plan runs on
floats with NumPy columns, several hundred times slower.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.native_columns import TILE, count_room, pad_count
from martensite.identify.chains.native_source import Taps, chain_source
from martensite.identify.chains.plan import ChainPiece, ChainPlan, plan_blocks
from martensite.kernels.compiler import call_compiled, find_compiler, load_library
from martensite.kernels.compute_once import cache_answers

Functions = Mapping[str, Callable[..., tuple[float, ...]]]


class FloatChain:
    """Functions of a plan on floats. Arrays are C-ordered; states change in place."""

    def __init__(self, plan: ChainPlan, taps: Taps) -> None:
        self._plan, self._taps = plan, taps

    def rest(self, p: Numbers, x: Numbers, s: Numbers, ds: Numbers) -> None:
        """Compute the steady state under constant inputs x, with derivatives of shape (states, columns)."""
        functions, m = self._bound(p), self._plan.columns
        w, dw, state = np.array(x), np.zeros((len(x), m)), 0
        ds[:] = 0.0
        for piece in self._plan.pieces:
            block, inputs = piece.block, piece.block.inputs
            rows = slice(state, state + block.states())
            columns = range(piece.first, piece.first + piece.count)
            if block.states():
                values = functions[piece.rest.name](*w[:inputs])
                s[rows] = values[: piece.rest.rows]
                for e in piece.rest.entries:
                    if e.column < inputs:
                        ds[state + e.row] += values[e.place] * dw[e.column]
                    else:
                        ds[state + e.row, columns[e.column - inputs]] += values[e.place]
            y, dy, _, _ = step_block(piece, functions, w, dw, s[rows], ds[rows], 0)
            w, dw, state = y, dy, state + block.states()

    def run(self, p: Numbers, u: Numbers, s: Numbers, y: Numbers) -> None:
        """Simulate inputs u (samples, inputs) from a state into y (samples, outputs)."""
        functions = self._bound(p)
        for t, row in enumerate(u):
            x, state = tuple(row), 0
            for k, piece in enumerate(self._plan.pieces):
                inputs, outputs = piece.block.inputs, piece.block.outputs
                rows = slice(state, state + piece.block.states())
                values = functions[f"v{piece.step.name}"](*x[:inputs], *s[rows])
                x, s[rows], state = values[:outputs], values[outputs:], rows.stop
                for place, (number, channel) in enumerate(self._taps):
                    if number == k:
                        y[t, place] = x[channel]

    def slopes(self, p: Numbers, u: Numbers, s: Numbers, ds: Numbers, y: Numbers, dy: Numbers, total: int) -> None:
        """Simulate with derivatives dy of shape (samples, outputs, extra + columns); `total` has no effect."""
        functions, m = self._bound(p), ds.shape[1]
        extra = m - self._plan.columns
        for t, row in enumerate(u):
            x, dx, state = row, np.zeros((len(row), m)), 0
            for k, piece in enumerate(self._plan.pieces):
                rows = slice(state, state + piece.block.states())
                x, dx, s[rows], ds[rows] = step_block(piece, functions, x, dx, s[rows], ds[rows], extra)
                state = rows.stop
                for place, (number, channel) in enumerate(self._taps):
                    if number == k:
                        y[t, place], dy[t, place] = x[channel], dx[channel]

    def _bound(self, p: Numbers) -> Functions:
        return self._plan.program.bind_floats(*map(float, p))


def step_block(
    piece: ChainPiece, functions: Functions, x: Numbers, dx: Numbers, s: Numbers, ds: Numbers, extra: int
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Return outputs, their columns, next state and its columns of one block in one sample."""
    block, step = piece.block, piece.step
    inputs, outputs = block.inputs, block.outputs
    results = functions[step.name](*map(float, x[:inputs]), *map(float, s))
    before = np.concatenate([dx[:inputs], ds])
    slopes = np.zeros((step.rows, dx.shape[1]))
    for e in step.entries:
        if e.column < len(before):
            slopes[e.row] += results[e.place] * before[e.column]
        else:
            slopes[e.row, extra + piece.first + e.column - len(before)] += results[e.place]
    values = np.array(results[: step.rows])
    return values[:outputs], slopes[:outputs], values[outputs:], slopes[outputs:]


FLAGS = ("-O2",)
"""Optimisation that compiles large kernels quickly at the same speed."""
SHORT = 10_000
"""Largest number of samples for which the quick compiler suffices: an optimiser would take longer than it saves."""


class CompiledChain:
    """Compiled functions of a plan. Arrays are C-ordered; states change in place."""

    def __init__(self, plan: ChainPlan, taps: Taps) -> None:
        self._plan, self._taps, self._width = plan, taps, plan.width
        self._sizes: dict[int, int] = {}
        self._libraries: dict[tuple[bool, bool], Any] = {}

    def rest(self, p: Numbers, x: Numbers, s: Numbers, ds: Numbers) -> None:
        """Compute the steady state as `FloatChain.rest`."""
        scratch = _allocate_aligned(scratch_size(self._plan, self._plan.columns))
        call_compiled(self._load(0, False).rest, p, x, s, ds, scratch)

    def run(self, p: Numbers, u: Numbers, s: Numbers, y: Numbers) -> None:
        """Simulate as `FloatChain.run`."""
        call_compiled(self._load(len(u), False).run, len(u), p, u, s, y)

    def slopes(self, p: Numbers, u: Numbers, s: Numbers, ds: Numbers, y: Numbers, dy: Numbers, total: int) -> None:
        """Simulate with derivatives dy of shape (samples, outputs, extra + columns); `total` samples follow in chunks.

        The first columns belong to the initial state: as many as ds has in addition to the free numbers. Samples of dy
        must be contiguous, followed by space up to a whole tile.
        """
        columns = ds.shape[1]
        if columns not in self._sizes:
            self._sizes[columns] = scratch_size(self._plan, columns)
        scratch = _allocate_aligned(self._sizes[columns])
        slopes = self._load(total, columns > self._plan.columns).slopes
        call_compiled(slopes, len(u), p, u, s, ds, scratch, y, dy, dy.strides[2] // 8)

    def _load(self, samples: int, extra: bool) -> Any:
        """Return the library of the quick compiler for few samples, else the optimised one."""
        key = extra, samples <= SHORT
        if key not in self._libraries:
            self._libraries[key] = _load_library(self._plan, self._taps, *key)
        return self._libraries[key]


def _allocate_aligned(count: int) -> Numbers:
    """Return zeros that start at a cache line."""
    room = np.zeros(count + 8)
    first = -room.ctypes.data % 64 // 8
    return room[first : first + count]


def scratch_size(plan: ChainPlan, columns: int) -> int:
    """Return the size of the work space of `slopes`: one tile of signals, and the memory of the blocks."""
    beside = sum(count_room(piece, columns - plan.columns) for piece in plan.pieces)
    return plan.width * TILE * columns + beside


@cache_answers(64)
def _load_library(plan: ChainPlan, taps: Taps, extra: bool, short: bool) -> Any:
    return load_library(chain_source(plan, taps, extra), FLAGS, soon=short, later=False)


CHUNK = 4032
"""Samples per chunk of derivatives; a power of 2 would make columns share cache lines."""


class ChainStart(NamedTuple):
    """State at the first sample, shape (states,)."""

    state: Numbers
    slopes: Numbers
    """Derivatives of the state, shape (states, extra + columns)."""


class Chunk(NamedTuple):
    """Outputs of some samples with derivatives."""

    rows: slice
    outputs: Numbers
    """Shape (samples, outputs)."""
    slopes: Numbers
    """Shape (samples, outputs, extra + columns)."""


class ChainEngine:
    """Blocks in series at one sample time.

    Args:
        blocks: blocks with their fixed numbers.
        interval: sample time [s].
        taps: outputs as (number of the block, number of its output); default: all outputs of the last block.
        compiled: whether to run in C; default: if there is a compiler.
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
        """Return the traced blocks."""
        return plan_blocks(self.blocks)

    def _numbers(self, theta: Numbers) -> Numbers:
        given = [value for block in self.blocks for value in block.fixed_values()]
        return np.array([*theta, *given, self.interval], dtype=float)

    def rest(self, theta: Numbers, x: Numbers, deviation: Numbers | None = None) -> ChainStart:
        """Return the steady state under a constant input.

        With a `deviation` of the state, the first columns are derivatives with respect to it.
        """
        count, columns = self.plan.states, self.plan.columns
        state, slopes = np.zeros(count), np.zeros((count, columns))
        self._runner.rest(self._numbers(theta), np.ascontiguousarray(x, dtype=float), state, slopes)
        if deviation is None:
            return ChainStart(state, slopes)
        return ChainStart(state + deviation, np.hstack([np.eye(count), slopes]))

    def simulate(self, theta: Numbers, u: Numbers, state: Numbers | None = None) -> Numbers:
        """Return the outputs (samples, outputs) for inputs (samples, inputs), by default from the steady state.

        A given state is changed to the state after the last sample.
        """
        u = np.ascontiguousarray(u, dtype=float)
        state = self.rest(theta, u[0]).state if state is None else state
        y = np.empty((len(u), len(self.taps)))
        self._runner.run(self._numbers(theta), u, state, y)
        return y

    def sensitivities(
        self, theta: Numbers, u: Numbers, start: ChainStart | None = None, chunk: int = CHUNK, reuse: bool = False
    ) -> Iterator[Chunk]:
        """Yield outputs and derivatives in chunks; with `reuse` derivatives are overwritten by the next chunk."""
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
            self._runner.slopes(numbers, part, state, slopes, y, dy, len(u))
            yield Chunk(slice(first, first + len(part)), y, dy)

    def jacobian(self, theta: Numbers, u: Numbers, start: ChainStart | None = None) -> tuple[Numbers, Numbers]:
        """Return outputs and derivatives of a whole record."""
        chunks = list(self.sensitivities(theta, u, start, max(len(u), 1)))
        return chunks[0].outputs, chunks[0].slopes
