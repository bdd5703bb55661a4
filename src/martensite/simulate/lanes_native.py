"""Lanes in C: one library per system, for any number of them."""

from __future__ import annotations

import ctypes
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.runtimes.c99 import c_source, load_library
from martensite.runtimes.once import once
from martensite.simulate.compiled import Compiled

Numbers: TypeAlias = NDArray[np.float64]

_ADVANCE = """
void prepare(long n, const double *restrict p, double *restrict c) {{ k_prepare(n, p, c); }}
void begin(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_init(n, c, x, y);
}}
void seen(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_observe(n, c, x, y);
}}
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

_COUNT, _ARRAY = ctypes.c_long, ctypes.c_void_p
_ARGUMENTS = {
    "prepare": (_COUNT, _ARRAY, _ARRAY),
    "begin": (_COUNT, _ARRAY, _ARRAY, _ARRAY),
    "seen": (_COUNT, _ARRAY, _ARRAY, _ARRAY),
    "advance": (_COUNT, _COUNT, *(_ARRAY,) * 6),
}


class NativeLanes:
    """Lanes in C.

    What a call needs lies where it lay before, so that a step of one lane takes microseconds:
    arguments `x` (states, signals, dt) and results `y` of a step, signals and outputs of one
    step.
    """

    def __init__(self, compiled: Compiled, table: Numbers) -> None:
        self.compiled = compiled
        size, n, outputs = compiled.size, table.shape[1], len(compiled.outputs)
        self.n, self.library, self.table = n, _library(compiled), np.array(table, order="C")
        self.constants = self._prepared(compiled, self.library)
        self.x = np.empty((size + compiled.drives + 1, n))
        self.y, self.worst = np.empty((size + len(compiled.report), n)), np.zeros((2, n))
        self._state, self._signals, self._dt = self.x[:size], self.x[size:-1], self.x[-1]
        self._drives, self._rows = np.empty((compiled.drives, n)), np.empty((1, outputs, n))
        self._at_drives, self._at_rows = _at(self._drives), _at(self._rows)
        self._held = tuple(map(_at, (self.constants, self.x, self.y, self.worst)))

    def set_table(self, table: Numbers) -> None:
        """Other parameters, shape (parameters, lanes); what was compiled stays."""
        self.table[...] = table
        self.library.prepare(self.n, _at(self.table), _at(self.constants))

    def _prepared(self, compiled: Compiled, library: Any) -> Numbers:
        """What depends on parameters alone."""
        found = np.empty((max(1, len(compiled.program.hoisted)), self.n))
        library.prepare(self.n, _at(self.table), _at(found))
        return found

    def begin(self, signals: Numbers) -> Numbers:
        """The state at rest."""
        found, given = np.empty((self.compiled.size, self.n)), np.ascontiguousarray(signals)
        self.library.begin(self.n, _at(self.constants), _at(given), _at(found))
        return found

    def advance(
        self, state: Numbers, signals: Numbers, dt: float, shown: bool
    ) -> tuple[Numbers, Numbers]:
        """State after some steps, and outputs; signals may spread over drives and lanes."""
        self._state[...], self._dt[...] = state, dt
        steps, drives, rows = len(signals), self._at_drives, self._at_rows
        if steps == 1:
            self._drives[...] = signals[0]
            self._go(1, drives, rows if shown else None)
            return self._state.copy(), self._rows.copy() if shown else self._rows[:0]
        spread = np.empty((steps, *self._drives.shape))
        spread[...] = signals
        found = np.empty((steps if shown else 0, *self._rows.shape[1:]))
        self._go(steps, _at(spread), _at(found) if shown else None)
        return self._state.copy(), found

    def _go(self, steps: int, drives: int, rows: int | None) -> None:
        """Steps from `x` to `x`."""
        self.library.advance(self.n, steps, *self._held, drives, rows)

    def seen(self, state: Numbers, signals: Numbers) -> Numbers:
        """Outputs in a state."""
        self._state[...], self._signals[...] = state, signals
        self.library.seen(self.n, *self._held[:2], self._at_rows)
        return self._rows[0].copy()


def _at(array: Numbers) -> int:
    """Address of a contiguous array."""
    return array.ctypes.data


@once(64)
def _library(compiled: Compiled) -> Any:
    loop = _ADVANCE.format(
        size=compiled.size, drives=compiled.drives, outputs=len(compiled.outputs)
    )
    functions = list(compiled.program.functions.values())
    library = load_library(c_source(compiled.program, functions) + loop)
    for name, arguments in _ARGUMENTS.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, None
    return library
