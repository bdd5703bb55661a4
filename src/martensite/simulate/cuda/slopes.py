"""Derivatives of batches on given steps on a GPU.

States and outputs are followed by their derivatives in the traced graph. Integration and memory management are
therefore unchanged (`martensite.simulate.cuda.march`). Common terms are computed once for all directions, and terms
of parameters alone before the run.
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
"""Directions per run: a wire needs 252 of 255 registers with four, and spills with eight."""


def march_slopes(
    compiled: CompiledMarch, table: Any, wrt: Sequence[int], grid: TimeGrid, place: int
) -> tuple[Any, Any, Any]:
    """Return an output (runs, samples), its derivatives (runs, samples, wrt), and the worst residuals, (runs,).

    Args:
        compiled: the system.
        table: its parameters, (parameters, runs).
        wrt: indices of the differentiation parameters.
        grid: the steps of all runs.
        place: index of the output.

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
    """Return the source for derivatives."""
    twin = add_slopes(compiled, wrt, outputs)
    return MarchSource(twin, tuple(range(len(twin.outputs))), varied)


@cache_answers(32)
def add_slopes(compiled: CompiledMarch, wrt: tuple[int, ...], outputs: tuple[int, ...]) -> CompiledMarch:
    """Return a system with states and outputs followed by their parameter derivatives, in order.

    The envelope is not checked, as in C.
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
