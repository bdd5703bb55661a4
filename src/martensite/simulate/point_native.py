"""The march of a material point in C: a loop around the traced steps of a law."""

from __future__ import annotations

from typing import Any

import numpy as np

from martensite.kernels.c99 import c_source
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.compute_once import cache_answers
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.compiled_law import ROW, CompiledLaw
from martensite.simulate.point_march import RampSection, Ridden

_RIDE = """
void start(const double *restrict p, const double *restrict x, double *restrict y) {{
    double c[{constants}];
    k_prepare(1, p, c);
    k_init(1, c, x, y);
}}
void ride(long samples, long finer, const double *restrict p, const double *restrict ramp,
          double *restrict memory, double *restrict rows, double *restrict worst,
          long *restrict where) {{
    double c[{constants}], x[{inputs}], y[{results}];
    const long n = samples * finer;
    k_prepare(1, p, c);
    memcpy(x, memory, sizeof(double) * {size});
    worst[0] = 0.0;
    where[0] = 0;
    for (long k = 1; k <= n; k++) {{
        const double share = (double)k / (double)n;
        x[{size}] = k == n ? ramp[1] : ramp[0] + share * (ramp[1] - ramp[0]);
        x[{size} + 1] = k == n ? ramp[3] : ramp[2] + share * (ramp[3] - ramp[2]);
        x[{size} + 2] = ramp[4];
        k_{step}(1, c, x, y);
        memcpy(x, y, sizeof(double) * {size});
        if (!(y[{results} - 1] <= worst[0])) {{ worst[0] = y[{results} - 1]; where[0] = k - 1; }}
        if (k % finer == 0) {{
            memcpy(rows, y + {size}, sizeof(double) * {row});
            rows += {row};
        }}
    }}
    memcpy(memory, x, sizeof(double) * {size});
}}
"""


@cache_answers(16)
def _load_library(compiled: CompiledLaw, step: str) -> Any:
    """One library per kind of step: compiling what is not used takes seconds."""
    program = compiled.program
    loop = _RIDE.format(
        constants=program.constants,
        inputs=max(compiled.size + 3, 4),
        results=compiled.size + len(ROW),
        size=compiled.size,
        row=len(ROW),
        step=step,
    )
    return load_library(c_source(program, [program.functions[n] for n in ("init", step)]) + loop)


class NativeRider:
    """Traced functions in C."""

    def __init__(self, compiled: CompiledLaw, law: AbstractLaw) -> None:
        self._compiled = compiled
        self._parameters = np.array([*compiled.values(law), 0.0], float)

    def start(self, *numbers: float) -> tuple[float, ...]:
        """Memory and row at ξ [-], ξ_S [-], stress [Pa], temperature [K]."""
        found = np.empty(self._compiled.size + len(ROW))
        given = np.array(numbers, float)
        library = _load_library(self._compiled, "stress_step")
        call_compiled(library.start, self._parameters, given, found)
        return tuple(found.tolist())

    def ride(self, memory: tuple[float, ...], ramp: RampSection) -> Ridden:
        """Along one section."""
        state, worst = np.array(memory, float), np.empty(1)
        rows, where = np.empty((ramp.samples, len(ROW))), np.empty(1, np.int_)
        line = np.array([ramp.begin, ramp.end, ramp.first, ramp.last, ramp.dt], float)
        arrays = (self._parameters, line, state, rows, worst, where)
        ride = _load_library(self._compiled, f"{ramp.control}_step").ride
        call_compiled(ride, ramp.samples, ramp.finer, *arrays)
        found = [tuple(row) for row in rows.tolist()]
        return Ridden((*state.tolist(), *found[-1]), found, float(worst[0]), int(where[0]))
