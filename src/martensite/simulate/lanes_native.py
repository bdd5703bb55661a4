"""Lanes in C: one library per system, for any number of them."""

from __future__ import annotations

import ctypes
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.kernels.c99_lanes import BLOCK
from martensite.kernels.compiled_program import CompiledProgram, get_address
from martensite.simulate.compiled import Compiled

Numbers: TypeAlias = NDArray[np.float64]

_ADVANCE = """
void advance(long n, long steps, const double *restrict c, double *restrict x,
             double *restrict y, double *restrict worst,
             const double *restrict drives, double *restrict rows) {{
    for (long i = 0; i < steps; i++) {{
        memcpy(x + {size} * n, drives, sizeof(double) * {drives} * n);
        k_step(n, c, x, y);
        memcpy(x, y, sizeof(double) * {size} * n);
        for (long l = 0; l < n; l++) {{
            const double r = y[{size} * n + l], s = y[({size} + 1) * n + l];
            if (!(r <= worst[l]) && worst[l] == worst[l]) worst[l] = r;
            if (!(s <= worst[n + l]) && worst[n + l] == worst[n + l]) worst[n + l] = s;
        }}
        if (rows) {{
            k_observe(n, c, x, rows);
            rows += {outputs} * n;
        }}
        drives += {drives} * n;
    }}
}}
"""

FUNCTIONS = ("init", "step", "observe")


class NativeLanes:
    """Lanes in C.

    What a call needs lies where it lay before, so that a step of one lane takes microseconds:
    arguments `x` (states, signals, dt) and results `y` of a step, signals and outputs of one
    step.
    """

    def __init__(self, compiled: Compiled, table: Numbers) -> None:
        self.compiled = compiled
        size, outputs, self.n = compiled.size, len(compiled.outputs), table.shape[1]
        self._filled_to = n = self.n if self.n < BLOCK else -(-self.n // BLOCK) * BLOCK
        self._table = self._fill_block(table)
        added = _ADVANCE.format(size=size, drives=compiled.drives, outputs=outputs)
        self.program = CompiledProgram(compiled.program, FUNCTIONS, self._table, added)
        self.x = np.empty((size + compiled.drives + 1, n))
        self.y, self._worst = np.empty((size + len(compiled.report), n)), np.zeros((2, n))
        self._state, self._signals, self._dt = self.x[:size], self.x[size:-1], self.x[-1]
        self._drives, self._rows = np.empty((compiled.drives, n)), np.empty((1, outputs, n))
        self._at_drives, self._at_rows = get_address(self._drives), get_address(self._rows)
        held = (self.program.constants, self.x, self.y, self._worst)
        self._held = tuple(map(get_address, held))
        self._observe = self.program.bind("observe", self.x, self._rows)

    @property
    def table(self) -> Numbers:
        """Parameters, shape (parameters, lanes)."""
        return self._table[:, : self.n]

    @property
    def worst(self) -> Numbers:
        """Worst reports so far, shape (2, lanes)."""
        return self._worst[:, : self.n]

    def _fill_block(self, given: Numbers) -> Numbers:
        """A table of lanes, the last of which fills the block."""
        last = given[..., -1:]
        more = np.broadcast_to(last, (*given.shape[:-1], self._filled_to - given.shape[-1]))
        return np.ascontiguousarray(np.concatenate([given, more], axis=-1))

    def _spread(self, into: Numbers, given: Any) -> None:
        """Write numbers that may be one for all lanes."""
        into[..., : self.n] = given
        into[..., self.n :] = into[..., self.n - 1 : self.n]

    def set_table(self, table: Numbers) -> None:
        """Other parameters, shape (parameters, lanes); what was compiled stays."""
        self._spread(self._table, table)
        self.program.set_table(self._table)

    def begin(self, signals: Numbers) -> Numbers:
        """The state at rest."""
        found, given = np.empty((self.compiled.size, self._filled_to)), self._fill_block(signals)
        self.program.bind("init", given, found)()
        return found[:, : self.n].copy()

    def advance(self, state: Numbers, signals: Numbers, dt: float, shown: bool) -> tuple[Numbers, Numbers]:
        """State after some steps, and outputs; signals may spread over drives and lanes."""
        self._spread(self._state, state)
        self._dt[...] = dt
        steps, drives, rows, n = len(signals), self._at_drives, self._at_rows, self.n
        if steps == 1:
            self._spread(self._drives, signals[0])
            self._go(1, drives, rows if shown else None)
            found = self._rows[..., :n].copy() if shown else self._rows[:0, :, :n]
            return self._state[:, :n].copy(), found
        spread = np.empty((steps, *self._drives.shape))
        self._spread(spread, signals)
        found = np.empty((steps if shown else 0, *self._rows.shape[1:]))
        self._go(steps, get_address(spread), get_address(found) if shown else None)
        return self._state[:, :n].copy(), found[..., :n]

    def _go(self, steps: int, drives: Any, rows: Any) -> None:
        """Steps from `x` to `x`."""
        counts = ctypes.c_long(self._filled_to), ctypes.c_long(steps)
        self.program.library.advance(*counts, *self._held, drives, rows)

    def read_outputs(self, state: Numbers, signals: Numbers) -> Numbers:
        """Outputs in a state."""
        self._spread(self._state, state)
        self._spread(self._signals, signals)
        self._observe()
        return self._rows[0, :, : self.n].copy()
