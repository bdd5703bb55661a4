"""The march in C: a loop around the traced kernels, for one run or a batch of lanes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.kernels.compiler import call_compiled, load_library
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.program import Function
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.grid import LaneGrid, TimeGrid
from martensite.simulate.march import judge_table
from martensite.simulate.marching import Marched, RunLimits

_MARCH = """
void march(long lanes, long intervals, const double *restrict p, const double *restrict first,
           const double *restrict sampled, const long *restrict counts,
           const double *restrict drives, const double *restrict lengths,
           double *restrict rows, double *restrict worst, const double *restrict limits,
           double *restrict left) {{
    double c[{constants} * {lanes}], x[({size} + {inputs} + 1) * {lanes}], y[{results} * {lanes}];
    const long n = {lanes};{notes}
    k_prepare(n, p, c);
    for (long l = 0; l < n; l++) {{
        for (long d = 0; d < {drives}; d++) x[d * n + l] = first[{signal}];
        for (long k = 0; k < {reports}; k++) worst[k * n + l] = 0.0;
        left[l] = HUGE_VAL;
    }}
    k_init(n, c, x, y);
    memcpy(x, y, sizeof(double) * {size} * n);
    for (long d = 0; d < {drives}; d++)
        for (long l = 0; l < n; l++) x[({size} + d) * n + l] = first[{signal}];
    k_observe(n, c, x, rows);
    for (long i = 0; i < intervals; i++) {{
        for (long k = 0; k < counts[i]; k++, drives += {inputs} * {own}, lengths += {own}) {{
            for (long l = 0; l < n; l++) {{
                for (long d = 0; d < {inputs}; d++) x[({size} + d) * n + l] = drives[{signal}];
                x[({size} + {inputs}) * n + l] = lengths[{length}];
            }}
            k_step(n, c, x, y);
            {keep}
            memcpy(x, y, sizeof(double) * {size} * n);
            for (long k = 0; k < {reports}; k++)
                for (long l = 0; l < n; l++) {{
                    const double a = worst[k * n + l], b = y[({size} + k) * n + l];
                    worst[k * n + l] = a >= b || left[l] < HUGE_VAL ? a : b;
                }}
            {look}
        }}
        for (long d = 0; d < {drives}; d++)
            for (long l = 0; l < n; l++) x[({size} + d) * n + l] = sampled[{signal}];
        sampled += {drives} * {own};
        rows += {outputs} * n;
        k_observe(n, c, x, rows);
    }}
}}
"""

_KEEP = """for (long l = 0; l < n; l++) if (!(lengths[l] > 0.0)) {{
                for (long k = 0; k < {size}; k++) y[k * n + l] = x[k * n + l];
                for (long k = 0; k < {reports}; k++) y[({size} + k) * n + l] = 0.0;
            }}"""


_LOOK = """for (long l = 0; l < n; l++) now[l] += lengths[{length}];
            memcpy(z, y, sizeof(double) * {size} * n);
            for (long d = 0; d < {drives}; d++)
                memcpy(z + ({size} + d) * n, x + ({size} + places[d]) * n, sizeof(double) * n);
            k_judge(n, c, z, seen);
            for (long k = 0; k < {envelope}; k++)
                for (long l = 0; l < n; l++) {{
                    const double v = seen[({judged} + k) * n + l];
                    const int out = isfinite(v) && !(limits[k * n + l] <= v &&
                                                     v <= limits[({envelope} + k) * n + l]);
                    if (out && left[l] == HUGE_VAL) left[l] = now[l];
                }}"""
_NOTES = """
    double now[{lanes}] = {{0.0}}, z[({size} + {drives}) * {lanes}], seen[{seen} * {lanes}];
    static const long places[] = {{{places}}};"""


def march_source(
    compiled: CompiledMarch, lanes: int, outputs: Sequence[int], own: bool = False, bounded: bool = False
) -> str:
    """C source of the kernels and the march for a fixed number of lanes.

    With signals and steps of their `own` lanes march through a `LaneGrid`. If it is `bounded`, a
    march looks after every step whether lanes leave an envelope.
    """
    traced = compiled.program.functions
    observe = traced["observe"]
    observe = replace(observe, outputs=tuple(observe.outputs[i] for i in outputs))
    loop = _MARCH.format(
        lanes=lanes,
        constants=compiled.program.constants,
        inputs=compiled.inputs,
        results=compiled.size + len(compiled.report),
        size=compiled.size,
        drives=compiled.drives,
        outputs=len(outputs),
        reports=len(compiled.report),
        own=lanes if own else 1,
        signal=f"d * {lanes} + l" if own else "d",
        length="l" if own else "0",
        keep=_KEEP.format(size=compiled.size, reports=len(compiled.report)) if own else "",
        **_write_watch(compiled, lanes, "l" if own else "0") if bounded else {"look": "", "notes": ""},
    )
    functions = [traced["init"], traced["step"], observe]
    return _write_kernels(compiled, functions + [traced["judge"]] * bounded, lanes) + loop


def _write_watch(compiled: CompiledMarch, lanes: int, length: str) -> dict[str, str]:
    """What looks at the envelope after every step."""
    known = {
        "lanes": lanes,
        "size": compiled.size,
        "drives": compiled.drives,
        "length": length,
        "judged": len(compiled.convergence_scales),
        "envelope": len(compiled.envelope),
        "seen": len(compiled.program.functions["judge"].outputs),
        "places": ", ".join(map(str, [*compiled.signals_in_step(), 0])),
    }
    return {"look": _LOOK.format_map(known), "notes": _NOTES.format_map(known)}


def _write_kernels(compiled: CompiledMarch, functions: Sequence[Function], lanes: int) -> str:
    """C of traced functions: over vectors where the lanes fill them."""
    write = c_source if lanes % BLOCK else lanes_source
    return write(compiled.program, functions)


@cache_answers(64)
def _load_library(compiled: CompiledMarch, lanes: int, outputs: tuple[int, ...], own: bool, bounded: bool) -> Any:
    return load_library(march_source(compiled, lanes, outputs, own, bounded))


def march_lanes(
    compiled: CompiledMarch, values: Sequence[Any], grid: TimeGrid | LaneGrid, lanes: int, outputs: Sequence[int]
) -> tuple[Any, Any]:
    """March a batch of exactly `lanes` variants; scalars are repeated over the lanes.

    A `LaneGrid` gives every lane signals and steps of its own.
    Returns outputs (samples, outputs, lanes) and the worst reports (3, lanes).
    """
    return march_inside(compiled, values, grid, lanes, outputs, None)[:2]


def march_inside(
    compiled: CompiledMarch,
    values: Sequence[Any],
    grid: TimeGrid | LaneGrid,
    lanes: int,
    outputs: Sequence[int],
    limits: Any,
) -> tuple[Any, Any, Any]:
    """The same, with the time [s] at which each lane left the envelope, (lanes,).

    That is the end of a step, and infinite for lanes that stay inside. What is reported is that
    until then. The limits are low and high, (2, envelope) or (2, envelope, lanes), or None where
    nobody looks.
    """
    bounded = limits is not None and len(compiled.envelope) > 0
    library = _load_library(compiled, lanes, tuple(outputs), isinstance(grid, LaneGrid), bounded)
    parameters = np.array([np.broadcast_to(v, lanes) for v in values], float)
    rows = np.empty((len(grid.times), len(outputs), lanes))
    worst = np.empty((len(compiled.report), lanes))
    left = np.empty(lanes)
    bounds = spread_limits(limits, lanes) if bounded else np.empty(0)
    arrays = (parameters, *grid.arrays, rows, worst, bounds, left)
    call_compiled(library.march, lanes, len(grid.counts), *arrays)
    return rows, worst, left


def spread_limits(limits: Any, runs: int) -> Any:
    """Limits of every run, (2, envelope, runs), from these or from those of all, (2, envelope)."""
    given = np.asarray(limits, float)
    given = given if given.ndim == 3 else given[:, :, None]
    return np.ascontiguousarray(np.broadcast_to(given, (*given.shape[:2], runs)))


def march_c(
    compiled: CompiledMarch, values: Sequence[float], grid: TimeGrid, limits: RunLimits | None = None
) -> Marched:
    """One run on the C runtime."""
    places = range(len(compiled.outputs))
    rows, worst, left = march_inside(compiled, values, grid, 1, places, limits)
    return judge_table(rows[:, :, 0], *worst[:2, 0].tolist(), left=float(left[0]))
