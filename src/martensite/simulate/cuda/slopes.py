"""Derivatives of batches on given steps on a GPU: a run with slopes is a run whose state has more numbers.

Beside every number of the state stand its derivatives, and beside an output those of it. They are plain numbers of the
traced graph, so the march, its chunks and its memory are those of runs without them (`martensite.simulate.cuda.march`).
Values and what derivatives have in common are computed once for all directions; a parameter moves nothing but itself,
and what follows from parameters alone is computed before the march.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.kernels.compute_once import cache_answers
from martensite.kernels.graph import VARYING
from martensite.kernels.program import Function, Program
from martensite.kernels.slopes import differentiate_along
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.cuda.march import march_batch
from martensite.simulate.cuda.source import MarchSource
from martensite.simulate.grid import TimeGrid

DIRECTIONS = 4
"""In one march: with four a wire takes 252 of the 255 registers of a thread and nothing spills; with eight it does."""


def march_slopes(
    compiled: CompiledMarch, table: Any, wrt: Sequence[int], grid: TimeGrid, place: int
) -> tuple[Any, Any, Any]:
    """Return an output (runs, samples), its derivatives (runs, samples, wrt), and the worst residuals, (runs,).

    Args:
        compiled: the system.
        table: its parameters, (parameters, runs).
        wrt: places of the parameters by which the output is differentiated.
        grid: the steps of all runs.
        place: that of the output.

    Raises:
        InputError: no device was found, or a run does not fit into its memory.
    """
    varied = tuple(np.flatnonzero((table != table[:, :1]).any(axis=1)).tolist())
    columns: list[Any] = []
    reports: Any = ()
    for first in range(0, max(len(wrt), 1), DIRECTIONS):
        source = print_slopes(compiled, tuple(wrt[first : first + DIRECTIONS]), (place,), varied)
        rows, reports, _ = march_batch(source, table[:, 0], table[list(varied)], grid, np.empty((2, 0)))
        columns += [rows[:, :1], rows[:, 1:]][len(columns) > 0 :]
    found = np.concatenate(columns, axis=1).transpose(2, 0, 1)
    return found[..., 0], found[..., 1:], reports[0]


def print_slopes(
    compiled: CompiledMarch, wrt: tuple[int, ...], outputs: tuple[int, ...], varied: tuple[int, ...]
) -> MarchSource:
    """Return the source to be compiled for derivatives."""
    twin = add_slopes(compiled, wrt, outputs)
    return MarchSource(twin, tuple(range(len(twin.outputs))), varied)


@cache_answers(32)
def add_slopes(compiled: CompiledMarch, wrt: tuple[int, ...], outputs: tuple[int, ...]) -> CompiledMarch:
    """Return a march whose states and wanted outputs are followed by their derivatives by parameters, in order.

    It looks at no envelope: nor do derivatives in C.
    """
    known, size = compiled.program, compiled.size
    program = Program(known.graph, list(known.parameters), dict(known.functions))
    every = tuple(range(size))
    for name, states, places in (
        ("init", 0, every),
        ("step", size, every),
        ("observe", size, outputs),
        ("judge", size, ()),
    ):
        function = known.functions[name]
        taken, rest = function.inputs[:states], function.inputs[states:]
        results = [function.outputs[i] for i in places]
        slopes: list[str] = []
        for k, parameter in enumerate(wrt):
            names = {one: f"d{k}{one}" for one in taken}
            slopes += names.values()
            moving = {one: program.graph.input(twin, VARYING) for one, twin in names.items()}
            results += differentiate_along(known, name, places, {f"p{parameter}": 1.0, **moving})
        reports = function.outputs[size:] if name == "step" else ()
        program.functions[name] = Function(name, (*taken, *slopes, *rest), (*results, *reports))
    names = [compiled.outputs[i] for i in outputs]
    shown = [f"d({one})/d({compiled.paths[parameter]})" for parameter in wrt for one in names]
    return replace(
        compiled,
        program=program,
        size=size * (1 + len(wrt)),
        outputs=(*names, *shown),
        convergence_scales=(),
        envelope=(),
    )
