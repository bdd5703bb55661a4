"""Chains in C: simulation and derivatives of all columns in one pass, compiled and called."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.native_columns import TILE, count_room
from martensite.identify.chains.native_source import Taps, chain_source
from martensite.identify.chains.plan import ChainPlan
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.compute_once import cache_answers

FLAGS = ("-O2",)
"""Kernels of hundreds of numbers compile sooner than with more, and run as fast."""


class CompiledChain:
    """The compiled functions of a plan. Arrays are C-ordered; states are changed in place."""

    def __init__(self, plan: ChainPlan, taps: Taps) -> None:
        self._plan, self._taps, self._width = plan, taps, plan.width
        self._library = _load_library(plan, taps, False)
        self._with_slopes: dict[int, tuple[Any, int]] = {}

    def rest(self, p: Numbers, x: Numbers, s: Numbers, ds: Numbers) -> None:
        """State at rest under constant inputs x, with its derivatives (states, columns)."""
        scratch = _allocate_aligned(scratch_size(self._plan, self._plan.columns))
        call_compiled(self._library.rest, p, x, s, ds, scratch)

    def run(self, p: Numbers, u: Numbers, s: Numbers, y: Numbers) -> None:
        """Simulate inputs u (samples, inputs) from a state, into y (samples, outputs)."""
        call_compiled(self._library.run, len(u), p, u, s, y)

    def slopes(self, p: Numbers, u: Numbers, s: Numbers, ds: Numbers, y: Numbers, dy: Numbers) -> None:
        """The same with derivatives: dy is (samples, outputs, extra + columns).

        The first columns are those of the initial state; there are as many as ds has beyond
        those of the free numbers. Samples of dy must be next to each other, and behind them
        there must be room up to a whole tile.
        """
        columns = ds.shape[1]
        if columns not in self._with_slopes:
            library = _load_library(self._plan, self._taps, columns > self._plan.columns)
            self._with_slopes[columns] = library.slopes, scratch_size(self._plan, columns)
        slopes, size = self._with_slopes[columns]
        scratch = _allocate_aligned(size)
        call_compiled(slopes, len(u), p, u, s, ds, scratch, y, dy, dy.strides[2] // 8)


def _allocate_aligned(count: int) -> Numbers:
    """Zeros from the start of a cache line."""
    room = np.zeros(count + 8)
    first = -room.ctypes.data % 64 // 8
    return room[first : first + count]


def scratch_size(plan: ChainPlan, columns: int) -> int:
    """Numbers that `slopes` needs room for: one tile of signals, and what blocks need beside."""
    beside = sum(count_room(piece, columns - plan.columns) for piece in plan.pieces)
    return plan.width * TILE * columns + beside


@cache_answers(64)
def _load_library(plan: ChainPlan, taps: Taps, extra: bool) -> Any:
    return load_library(chain_source(plan, taps, extra), FLAGS)
