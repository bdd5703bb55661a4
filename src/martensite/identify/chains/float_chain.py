"""Chains without a compiler: the same plan on plain floats, its columns as NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.plan import ChainPiece, ChainPlan

Functions = Mapping[str, Callable[..., tuple[float, ...]]]
Taps = tuple[tuple[int, int], ...]


class FloatChain:
    """What `compiled_chain.CompiledChain` does, some hundred times slower."""

    def __init__(self, plan: ChainPlan, taps: Taps) -> None:
        self._plan, self._taps = plan, taps

    def rest(self, p: Numbers, x: Numbers, s: Numbers, ds: Numbers) -> None:
        """State at rest under constant inputs x, with its derivatives (states, columns)."""
        functions, m = self._bound(p), self._plan.columns
        w, dw, state = np.array(x), np.zeros((len(x), m)), 0
        ds[:] = 0.0
        for piece in self._plan.pieces:
            block, inputs = piece.block, piece.block.inputs
            rows = slice(state, state + block.states())
            own = range(piece.first, piece.first + piece.count)
            if block.states():
                found = functions[piece.rest.name](*w[:inputs])
                s[rows] = found[: piece.rest.rows]
                for e in piece.rest.entries:
                    if e.column < inputs:
                        ds[state + e.row] += found[e.place] * dw[e.column]
                    else:
                        ds[state + e.row, own[e.column - inputs]] += found[e.place]
            y, dy, _, _ = _step_block(piece, functions, w, dw, s[rows], ds[rows], 0)
            w, dw, state = y, dy, state + block.states()

    def run(self, p: Numbers, u: Numbers, s: Numbers, y: Numbers) -> None:
        """Simulate inputs u (samples, inputs) from a state, into y (samples, outputs)."""
        functions = self._bound(p)
        for t, row in enumerate(u):
            x, state = tuple(row), 0
            for k, piece in enumerate(self._plan.pieces):
                inputs, outputs = piece.block.inputs, piece.block.outputs
                rows = slice(state, state + piece.block.states())
                found = functions[f"v{piece.step.name}"](*x[:inputs], *s[rows])
                x, s[rows], state = found[:outputs], found[outputs:], rows.stop
                for place, (number, channel) in enumerate(self._taps):
                    if number == k:
                        y[t, place] = x[channel]

    def slopes(self, p: Numbers, u: Numbers, s: Numbers, ds: Numbers, y: Numbers, dy: Numbers) -> None:
        """The same with derivatives: dy is (samples, outputs, extra + columns)."""
        functions, m = self._bound(p), ds.shape[1]
        extra = m - self._plan.columns
        for t, row in enumerate(u):
            x, dx, state = row, np.zeros((len(row), m)), 0
            for k, piece in enumerate(self._plan.pieces):
                rows = slice(state, state + piece.block.states())
                x, dx, s[rows], ds[rows] = _step_block(piece, functions, x, dx, s[rows], ds[rows], extra)
                state = rows.stop
                for place, (number, channel) in enumerate(self._taps):
                    if number == k:
                        y[t, place], dy[t, place] = x[channel], dx[channel]

    def _bound(self, p: Numbers) -> Functions:
        return self._plan.program.bind_floats(*map(float, p))


def _step_block(
    piece: ChainPiece, functions: Functions, x: Numbers, dx: Numbers, s: Numbers, ds: Numbers, extra: int
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """One block in one sample: outputs, their columns, the next state, its columns."""
    block, step = piece.block, piece.step
    inputs, outputs = block.inputs, block.outputs
    found = functions[step.name](*map(float, x[:inputs]), *map(float, s))
    before = np.concatenate([dx[:inputs], ds])
    made = np.zeros((step.rows, dx.shape[1]))
    for e in step.entries:
        if e.column < len(before):
            made[e.row] += found[e.place] * before[e.column]
        else:
            made[e.row, extra + piece.first + e.column - len(before)] += found[e.place]
    values = np.array(found[: step.rows])
    return values[:outputs], made[:outputs], values[outputs:], made[outputs:]
