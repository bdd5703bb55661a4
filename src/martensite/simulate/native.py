"""Time integration in C around the traced kernels, for one run or a batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.kernels.compiler import call_compiled, load_library, read_source
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.program import Function
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.grid import LaneGrid, TimeGrid
from martensite.simulate.march import judge_table
from martensite.simulate.marching import MarchResult, RunLimits


def march_source(
    compiled: CompiledMarch, lanes: int, outputs: Sequence[int], own: bool = False, bounded: bool = False
) -> str:
    """Return the C source of kernels and time integration for a fixed batch size.

    With `own`, batch elements have individual signals and steps (`LaneGrid`). With `bounded`, the envelope is
    checked after every step.
    """
    traced = compiled.program.functions
    observe = traced["observe"]
    observe = replace(observe, outputs=tuple(observe.outputs[i] for i in outputs))
    constants = {
        "LANES": lanes,
        "CONSTANTS": compiled.program.constants,
        "INPUTS": compiled.inputs,
        "RESULTS": compiled.size + len(compiled.report),
        "SIZE": compiled.size,
        "DRIVES": compiled.drives,
        "OUTPUTS": len(outputs),
        "REPORTS": len(compiled.report),
        "OWN": int(own),
        "BOUNDED": int(bounded),
        "JUDGED": len(compiled.convergence_scales),
        "ENVELOPE": len(compiled.envelope),
        "SEEN": len(traced["judge"].outputs),
        "PLACES": "{" + ", ".join(map(str, [*compiled.signals_in_step(), 0])) + "}",
    }
    functions = [traced["init"], traced["step"], observe]
    kernels = _write_kernels(compiled, functions + [traced["judge"]] * bounded, lanes)
    return kernels + read_source("simulate", "given_steps.c", constants)


def _write_kernels(compiled: CompiledMarch, functions: Sequence[Function], lanes: int) -> str:
    """Return the C source of traced functions, vectorised for full batches."""
    if lanes % BLOCK:
        return c_source(compiled.program, functions, single=lanes == 1)
    return lanes_source(compiled.program, functions)


@cache_answers(64)
def _load_library(compiled: CompiledMarch, lanes: int, outputs: tuple[int, ...], own: bool, bounded: bool) -> Any:
    return load_library(march_source(compiled, lanes, outputs, own, bounded), soon=lanes == 1)


def march_lanes(
    compiled: CompiledMarch, values: Sequence[Any], grid: TimeGrid | LaneGrid, lanes: int, outputs: Sequence[int]
) -> tuple[Any, Any]:
    """Simulate a batch of exactly `lanes` variants; scalars apply to all variants.

    A `LaneGrid` gives individual signals and steps.

    Returns:
        Outputs (samples, outputs, lanes) and the worst reports (3, lanes).
    """
    return march_inside(compiled, values, grid, lanes, outputs, None)[:2]


def march_inside(
    compiled: CompiledMarch,
    values: Sequence[Any],
    grid: TimeGrid | LaneGrid,
    lanes: int,
    outputs: Sequence[int],
    limits: Any,
    states: Any = None,
) -> tuple[Any, Any, Any]:
    """Simulate a batch; the results include the times [s] of leaving the envelope, (batch,).

    The time is the end of a step, and infinite for variants that stay inside. Reports cover the run until then. The
    limits are low and high, (2, envelope) or (2, envelope, lanes), or None. The `states`, (states, lanes), are
    replaced by the final states. If the first value is NaN, variants start in equilibrium.
    """
    bounded = limits is not None and len(compiled.envelope) > 0
    library = _load_library(compiled, lanes, tuple(outputs), isinstance(grid, LaneGrid), bounded)
    parameters = spread_column(values, lanes)
    rows = np.empty((len(grid.times), len(outputs), lanes))
    worst = np.empty((len(compiled.report), lanes))
    left = np.empty(lanes)
    bounds = spread_limits(limits, lanes) if bounded else np.empty(0)
    states = np.full((max(compiled.size, 1), lanes), np.nan) if states is None else states
    arrays = (parameters, *grid.arrays, rows, worst, bounds, left, states)
    call_compiled(library.march, lanes, len(grid.counts), *arrays)
    return rows, worst, left


def spread_limits(limits: Any, runs: int) -> Any:
    """Return the limits of every run, (2, envelope, runs), from individual or common limits."""
    given = np.array(limits, float)
    table = np.empty((*given.shape[:2], runs))
    table[...] = given if given.ndim == 3 else given[:, :, None]
    return table


def spread_column(values: Sequence[Any], runs: int) -> Any:
    """Return the parameters of all runs, (parameters, runs), from scalars or arrays."""
    table = np.empty((len(values), runs))
    fill_column(table, values)
    return table


def fill_column(table: Any, values: Sequence[Any]) -> None:
    """Write the parameters of all runs, scalars or arrays, to a table (parameters, runs)."""
    if set(map(type, values)) == {float}:
        table.T[...] = values
        return
    for row, value in enumerate(values):
        table[row] = value


def march_c(
    compiled: CompiledMarch,
    values: Sequence[float],
    grid: TimeGrid,
    limits: RunLimits | None = None,
    start: Sequence[float] = (),
) -> MarchResult:
    """Simulate one run in C, from a start or from equilibrium."""
    places = range(len(compiled.outputs))
    states = np.array(start or [np.nan] * max(compiled.size, 1), float).reshape(-1, 1)
    rows, worst, left = march_inside(compiled, values, grid, 1, places, limits, states)
    return judge_table(rows[:, :, 0], *worst[:2, 0].tolist(), left=float(left[0]), state=states[:, 0].tolist())
