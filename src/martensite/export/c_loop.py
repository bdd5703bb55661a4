"""`c_loop`: what one would flash: observers, controllers and supervisor of a bench as C99.

The same kernels as those of `martensite.control.loop.realtime.RealtimeStep`, without the plant.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from martensite.base.errors import ParameterError
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE, ALARM, list_readings, list_references, reference_units
from martensite.control.loop.names import list_estimates as estimate_outputs
from martensite.control.loop.period import collect_estimates
from martensite.control.loop.realtime import LoopState, TracedLoop, list_reads, trace_loop
from martensite.export.c_core import CCore, Rows, core_of
from martensite.export.c_kernels import precision_of
from martensite.kernels.program import Function, Program


def build_c_loop(bench: Bench, *, name: str | None = None, precision: str = "float64") -> CCore:
    """Observers, controllers and supervisor of a bench as C, without its plant.

    Inputs are the readings, their ages, the references and the signals that no controller has.
    `NAME_start` is the first sample, `NAME_step` every other, with the period for dt; outputs are
    the signals of the drives for the period that begins, the alarm, and what observers estimate.

    Raises:
        ParameterError: as for `c_core`; or there is no controller.
    """
    if not bench.controllers.members():
        raise ParameterError("The loop of a bench without controllers gives no signals.")
    traced = trace_loop(bench)
    program, seen = _loop_program(bench, traced)
    return core_of(
        bench,
        program,
        traced.size,
        _loop_inputs(bench),
        seen,
        name=name,
        precision=precision_of(precision),
        reports=False,
        pruned=True,
    )


def _loop_inputs(bench: Bench) -> Rows:
    """Readings, their ages, references, signals that no controller has."""
    known, names = list_readings(bench), list_reads(bench)
    rows = [(name, known[name].unit, known[name].long_name) for name in names]
    rows += [(name + AGE, "s", f"age of {name}") for name in names]
    followed = zip(list_references(bench), reference_units(bench), strict=True)
    rows += [(name, unit, "what the controller shall follow") for name, unit in followed]
    taken = bench.controllers.members()
    free = [drive for drive in bench.plant.drives() if drive.name not in taken]
    return rows + [(drive.name, drive.unit, f"signal of {drive.name}") for drive in free]


def _loop_program(bench: Bench, traced: TracedLoop) -> tuple[Program, Rows]:
    """The traced loop with a function that picks what it says from its state, and its outputs."""
    program, step = traced.program, traced.program.functions["step"]
    names = step.inputs[: traced.size]
    loop: LoopState = traced.shape.rebuild([program.graph.input(name, 0) for name in names])
    drives = bench.plant.drives()
    rows = [(one.name, one.unit, f"signal of {one.name}") for one in drives]
    nodes: list[Any] = list(loop.signals)
    if bench.supervisor is not None:
        rows.append((ALARM, "1", "alarm of the supervisor"))
        nodes.append(loop.alarm)
    words = estimate_outputs(bench)
    for name, node in collect_estimates(bench, loop.observers).items():
        rows.append((name, words[name].unit, words[name].long_name))
        nodes.append(node)
    functions = {
        "init": replace(program.functions["begin"], name="init"),
        "step": step,
        "observe": Function("observe", names, tuple(nodes)),
    }
    return Program(program.graph, program.parameters, functions), rows
