"""Lanes in C: one library per system, for any number of them."""

from __future__ import annotations

import ctypes
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.runtimes.c99 import c_source, load_library
from martensite.runtimes.once import once
from martensite.simulate.compiled import Compiled, compile_system
from martensite.simulate.march import SOLVED
from martensite.simulate.patient import THOROUGH
from martensite.system import AbstractSystem

Numbers: TypeAlias = NDArray[np.float64]

_ADVANCE = """
void prepare(long n, const double *restrict p, double *restrict c) {{ k_prepare(n, p, c); }}
void begin(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_init(n, c, x, y);
}}
void seen(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_observe(n, c, x, y);
}}
void once_more(long n, const double *restrict c, const double *restrict x, double *restrict y) {{
    k_step(n, c, x, y);
}}
void advance(long n, long steps, const double *restrict c, const double *restrict d,
             double *restrict x, double *restrict y, double *restrict z,
             const double *restrict drives, double *restrict rows, double *restrict worst,
             void (*again)(long, const double *, const double *, double *)) {{
    for (long i = 0; i < steps; i++) {{
        memcpy(x + {size} * n, drives, sizeof(double) * {drives} * n);
        k_step(n, c, x, y);
        long bad = 0;
        for (long l = 0; l < n; l++) bad |= !(y[{size} * n + l] <= {solved});
        if (bad) {{
            again(n, d, x, z);
            for (long l = 0; l < n; l++)
                if (!(y[{size} * n + l] <= {solved}))
                    for (long k = 0; k < {results}; k++) y[k * n + l] = z[k * n + l];
        }}
        memcpy(x, y, sizeof(double) * {size} * n);
        for (long l = 0; l < n; l++) {{
            const double r = y[{size} * n + l], s = y[({size} + 1) * n + l];
            worst[l] = (worst[l] >= r) ? worst[l] : r;
            worst[n + l] = (worst[n + l] >= s) ? worst[n + l] : s;
        }}
        if (rows) {{
            k_observe(n, c, x, rows);
            rows += {outputs} * n;
        }}
        drives += {drives} * n;
    }}
}}
"""

_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class NativeLanes:
    """Lanes in C."""

    def __init__(self, compiled: Compiled, table: Numbers, system: AbstractSystem) -> None:
        self.compiled, self.n, self.system = compiled, table.shape[1], system
        self.library, self.thorough = _library(compiled), None
        self.table = np.ascontiguousarray(table)
        self.constants = self._prepared(compiled, self.library)
        inputs = compiled.size + compiled.drives + 1
        results = compiled.size + len(compiled.report)
        self.x = np.empty((inputs, self.n))
        self.y, self.z = np.empty((results, self.n)), np.empty((results, self.n))
        self._again = _CALLBACK(self._more)

    def _prepared(self, compiled: Compiled, library: Any) -> Numbers:
        """What depends on parameters alone."""
        found = np.empty((max(1, len(compiled.program.hoisted)), self.n))
        library.prepare(ctypes.c_long(self.n), _at(self.table), _at(found))
        return found

    def _more(self, n: int, _: int, x: int, z: int) -> None:
        """One step with more iterations."""
        if self.thorough is None:
            compiled = compile_system(self.system, THOROUGH)
            library = _library(compiled)
            self.thorough = library, self._prepared(compiled, library)
        library, constants = self.thorough
        library.once_more(ctypes.c_long(n), _at(constants), ctypes.c_void_p(x), ctypes.c_void_p(z))

    def begin(self, signals: Numbers) -> Numbers:
        """The state at rest."""
        found = np.empty((self.compiled.size, self.n))
        self.library.begin(ctypes.c_long(self.n), _at(self.constants), _at(signals), _at(found))
        return found

    def advance(
        self, state: Numbers, drives: Numbers, dt: float, shown: bool, worst: Numbers
    ) -> tuple[Numbers, Numbers]:
        """State after some steps, and outputs."""
        size, steps = self.compiled.size, drives.shape[0]
        self.x[:size], self.x[-1] = state, dt
        outputs = len(self.compiled.outputs)
        rows = np.empty((steps if shown else 0, outputs, self.n))
        self.library.advance(
            ctypes.c_long(self.n), ctypes.c_long(steps), _at(self.constants), None, _at(self.x),
            _at(self.y), _at(self.z), _at(drives), _at(rows) if shown else None, _at(worst),
            self._again,
        )  # fmt: skip
        return self.x[:size].copy(), rows

    def seen(self, state: Numbers, signals: Numbers) -> Numbers:
        """Outputs in a state."""
        size = self.compiled.size
        self.x[:size], self.x[size:-1] = state, signals
        rows = np.empty((len(self.compiled.outputs), self.n))
        self.library.seen(ctypes.c_long(self.n), _at(self.constants), _at(self.x), _at(rows))
        return rows


def _at(array: Numbers) -> Any:
    return array.ctypes.data_as(ctypes.c_void_p)


@once(64)
def _library(compiled: Compiled) -> Any:
    loop = _ADVANCE.format(
        size=compiled.size, drives=compiled.drives, solved=SOLVED,
        results=compiled.size + len(compiled.report), outputs=len(compiled.outputs),
    )  # fmt: skip
    functions = list(compiled.program.functions.values())
    return load_library(c_source(compiled.program, functions) + loop)
