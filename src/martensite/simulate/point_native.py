"""The march of a material point in C: a loop around the traced steps of a law."""

from __future__ import annotations

import numpy as np

from martensite.kernels.compiled_program import CompiledProgram
from martensite.kernels.compiler import call_compiled
from martensite.physics.laws.base import AbstractLaw
from martensite.simulate.compiled_law import ROW, CompiledLaw
from martensite.simulate.marching import Row
from martensite.simulate.point_march import PathSection, Ridden

_RIDE = """
void ride(long samples, long finer, const double *restrict c, const double *restrict ramp,
          double *restrict memory, double *restrict rows, double *restrict worst,
          long *restrict where) {{
    double x[{inputs}], y[{results}];
    const long n = samples * finer;
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


class NativeRider:
    """Traced functions in C."""

    def __init__(self, compiled: CompiledLaw, law: AbstractLaw) -> None:
        self._compiled = compiled
        self._table = np.array([*compiled.values(law), 0.0], float)[:, None]
        self._programs: dict[str, CompiledProgram] = {}

    def _load(self, step: str) -> CompiledProgram:
        """One library per kind of step: compiling what is not used takes seconds."""
        if step in self._programs:
            return self._programs[step]
        size = self._compiled.size
        added = _RIDE.format(inputs=max(size + 3, 4), results=size + len(ROW), size=size, row=len(ROW), step=step)
        made = CompiledProgram(self._compiled.program, ("init", step), self._table, added)
        return self._programs.setdefault(step, made)

    def start(self, *numbers: float) -> tuple[float, ...]:
        """Memory and row at ξ [-], ξ_S [-], stress [Pa], temperature [K]."""
        found, given = np.empty(self._compiled.size + len(ROW)), np.array(numbers, float)
        self._load("stress_step").bind("init", given, found)()
        return tuple(found.tolist())

    def ride(self, memory: Row, section: PathSection, finer: int) -> Ridden:
        """Along one section, in so many steps between samples."""
        state, worst = np.array(memory, float), np.empty(1)
        rows, where = np.empty((section.samples, len(ROW))), np.empty(1, np.int_)
        dt = section.duration / (section.samples * finer)
        line = np.array([section.begin, section.end, section.first, section.last, dt], float)
        program = self._load(f"{section.control}_step")
        arrays = (program.constants, line, state, rows, worst, where)
        call_compiled(program.library.ride, section.samples, finer, *arrays)
        found = [tuple(row) for row in rows.tolist()]
        return Ridden((*state.tolist(), *found[-1]), found, float(worst[0]), int(where[0]))
