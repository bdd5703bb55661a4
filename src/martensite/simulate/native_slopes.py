"""One run in C with output derivatives in all directions.

Values equal those of a run without derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.kernels.c99 import choose_width, slopes_source
from martensite.kernels.compiler import call_compiled, load_library, read_source
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.slopes import differentiate_program
from martensite.physics.laws.coupling import StepReport
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.grid import TimeGrid


class OutputSlopes(NamedTuple):
    """Outputs of one run and their derivatives."""

    rows: Any
    """(samples, outputs)"""
    slopes: Any
    """(samples, outputs, directions)"""
    residual: float
    crossing: float


def march_slopes(
    compiled: CompiledMarch, values: Sequence[float], seeds: Any, grid: TimeGrid, outputs: Sequence[int]
) -> OutputSlopes:
    """Simulate one run with derivatives of outputs, selected by index.

    Seeds, (parameters, directions), are the parameter derivatives in each direction. Rows of zeros cost no time.
    """
    given = np.asarray(seeds, float)
    count = given.shape[1]
    moving = tuple(int(i) for i in np.flatnonzero(np.any(given != 0.0, axis=1)))
    width = choose_width(count)
    library = _load_library(compiled, moving, tuple(outputs), width)
    pieces = [
        _march_library(library, values, _pad_seeds(given[list(moving), k : k + width], width), grid, len(outputs))
        for k in range(0, max(count, 1), width)
    ]
    slopes = np.concatenate([piece.slopes for piece in pieces], axis=2)[:, :, :count]
    return pieces[0]._replace(slopes=slopes)


def _pad_seeds(seeds: Any, width: int) -> Any:
    """Return the seeds padded with zeros to the computed directions and at least one row."""
    rows, columns = seeds.shape
    return np.pad(seeds, ((0, not rows), (0, width - columns)))


def _march_library(library: Any, values: Sequence[float], seeds: Any, grid: TimeGrid, outputs: int) -> OutputSlopes:
    shape = len(grid.times), outputs
    rows, drows, worst = (np.empty(shape), np.empty((*shape, seeds.shape[1])), np.empty(len(StepReport._fields)))
    arrays = (np.array([*values, 0.0]), seeds, *grid.arrays, rows, drows, worst)
    call_compiled(library.march, len(grid.counts), *arrays)
    return OutputSlopes(rows, drows, float(worst[0]), float(worst[1]))


@cache_answers(64)
def _load_library(compiled: CompiledMarch, moving: tuple[int, ...], outputs: tuple[int, ...], width: int) -> Any:
    size = compiled.size
    states = {"init": 0, "step": size, "observe": size}
    program = differentiate_program(compiled.program, moving, states, outputs)
    constants = {
        "CONSTANTS": program.constants,
        "CONSTANT_SLOPES": program.constant_slopes,
        "SIZE": size,
        "INPUTS": compiled.inputs,
        "RESULTS": size + len(compiled.report),
        "DRIVES": compiled.drives,
        "OUTPUTS": len(outputs),
        "REPORTS": len(compiled.report),
    }
    functions = list(program.functions.values())
    loop = read_source("simulate", "given_slopes.c", constants)
    return load_library(slopes_source(program, functions, moving, width) + loop)
