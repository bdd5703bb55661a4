"""A system, a bench, or the loop of a bench as C99, for microcontrollers and FMUs.

The C is generated from the kernels of simulations. A model is one struct of floats; its functions allocate no memory
and need only libm. A loop holds observers, controllers and supervisor of a bench without the plant; its kernels are
those of `martensite.control.loop.realtime.RealtimeStep`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

from martensite.actuators.assembly import PROFILES, AbstractSystem
from martensite.base.errors import ParameterError
from martensite.base.files import write_file
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import (
    AGE,
    ALARM,
    AUTOMATIC,
    JITTER,
    MANUAL,
    NOISE,
    hand_drives,
    list_controller_outputs,
    list_previews,
    list_readings,
    list_references,
    reference_units,
)
from martensite.control.loop.names import list_estimates as estimate_outputs
from martensite.control.loop.period import collect_controller_outputs, collect_estimates
from martensite.control.loop.realtime import LoopState, TracedLoop, list_reads, trace_loop
from martensite.export.c_kernels import count_operations, precision_of, used_parameters
from martensite.export.c_names import CoreVariable, choose_identifier, list_parameters, list_variables
from martensite.export.c_source import source_text
from martensite.export.c_text import count_elements, header_text
from martensite.kernels.program import Function, Program
from martensite.simulate.compiled import compile_system

Rows = list[tuple[str, str, str]]
"""Name, unit and description."""


@dataclass(frozen=True)
class CCore:
    """A model in C."""

    name: str
    """Name of the files, and prefix of all their names."""
    description: str
    precision: str
    """`float64` or `float32`."""
    program: Program
    """With functions `init`, `step` and `observe`."""
    parameter_indices: Sequence[int]
    """Indices of the parameters in the program."""
    parameters: tuple[CoreVariable, ...]
    inputs: tuple[CoreVariable, ...]
    outputs: tuple[CoreVariable, ...]
    states: int
    has_report: bool
    """True if steps end with residual and crossing."""
    sample: str | None
    """C expression of the sample time in discrete time; None if steps may have any length."""
    sample_time: float
    """Sample time [s] in discrete time; else 0."""
    answers: tuple[str, ...] = ()
    """Outputs whose derivatives a function `respond` gives; empty without it."""
    probes: tuple[float, ...] = ()
    """Input changes for central differences, where steps can be split: see `ports.kernel`."""

    @cached_property
    def header(self) -> str:
        """Return NAME.h."""
        return header_text(self)

    @cached_property
    def source(self) -> str:
        """Return NAME.c."""
        return source_text(self)

    @property
    def constants(self) -> int:
        """Return the number of constants that depend on parameters."""
        return len(self.program.hoisted_nodes)

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Return worst-case operation counts of `prepare`, `start`, `step`, `observe` and, for a port, one `try`."""
        graph, hoisted = self.program.graph, self.program.hoisted_nodes
        costs = {"prepare": count_operations(graph, hoisted)}
        labels = {"init": "start", "step": "step", "observe": "observe"} | ({"respond": "try"} if self.answers else {})
        for name, label in labels.items():
            costs[label] = count_operations(graph, self.program.functions[name].outputs, hoisted)
        return costs

    @property
    def size(self) -> int:
        """Return the size of the model [bytes]."""
        counts = (len(self.parameters), self.constants, self.states)
        return precision_of(self.precision).size * (sum(map(count_elements, counts)) + 2)

    @property
    def files(self) -> dict[str, str]:
        """Return the texts by file name."""
        return {f"{self.name}.h": self.header, f"{self.name}.c": self.source}

    def write(self, folder: str | Path) -> list[Path]:
        """Write header and source into a folder, and return their paths. Existing files are replaced.

        Raises:
            DataError: the folder does not exist or is not writable.
        """
        for name, text in self.files.items():
            write_file(Path(folder) / name, text)
        return [Path(folder) / name for name in self.files]


def build_c_core(system: AbstractSystem, *, name: str | None = None, precision: str = "float64") -> CCore:
    """Return a system or a bench as C.

    Args:
        system: a `System`, a `Machine`, or a `Bench` with its loops.
        name: C identifier of the core; by default made of the kinds of its parts.
        precision: `float64` (`double`), or `float32` (`float`) for processors without doubles.

    Raises:
        ParameterError: the name is not an identifier.
        UnknownNameError: the precision is unknown.
    """
    compiled = compile_system(system)
    return core_of(
        system,
        compiled.program,
        compiled.size,
        describe_drives(system),
        list_outputs(system, compiled.outputs),
        name=name,
        precision=precision,
        reports=True,
    )


def core_of(
    whole: AbstractSystem,
    program: Program,
    states: int,
    inputs: Rows,
    outputs: Rows,
    *,
    name: str | None,
    precision: str,
    reports: bool,
    pruned: bool = False,
    answers: tuple[str, ...] = (),
    probes: tuple[float, ...] = (),
) -> CCore:
    """Return the core of a program with functions `init`, `step` and `observe`.

    Args:
        whole: the system.
        program: its traced functions.
        states: size of the state.
        inputs: name, unit and description of each input.
        outputs: name, unit and description of each output.
        name: C identifier; by default made of the description.
        precision: `float64` or `float32`.
        reports: whether steps end with residual and crossing.
        pruned: whether to leave out parameters without effect.
        answers: outputs whose derivatives `respond` gives.
        probes: input changes for central differences.
    """
    timed, leaves = _sample_path(whole), list(whole.leaves())
    places = {leaf.path: i for i, leaf in enumerate(leaves)}
    used = used_parameters(program) | ({places[timed]} if timed else set[int]())
    indices = sorted(used) if pruned else list(places.values())
    given = list_parameters((leaves[i] for i in indices), (i in used for i in indices))
    sample = f"m->p[{indices.index(places[timed])}]" if timed else None
    return CCore(
        name=choose_identifier(name, whole.description()),
        description=whole.description(),
        precision=precision_of(precision).name,
        program=program,
        parameter_indices=indices,
        parameters=given,
        inputs=list_variables("u", inputs, 0.0),
        outputs=list_variables("y", outputs, math.nan),
        states=states,
        has_report=reports,
        sample=sample,
        sample_time=whole.sample_time() if sample else 0.0,
        answers=answers,
        probes=probes,
    )


def _sample_path(whole: AbstractSystem) -> str | None:
    twin = whole.rebuilt({leaf.path: leaf.path for leaf in whole.leaves()})
    time: Any = twin.sample_time()
    return time if isinstance(time, str) else None


def describe_drives(system: AbstractSystem) -> Rows:
    """Return name, unit and description of the inputs of a system."""
    outputs = system.outputs()
    return [
        (one.name, one.unit, outputs[one.name].long_name if one.name in outputs else _describe_drive(one.name))
        for one in system.drives()
    ]


def _describe_drive(drive: str) -> str:
    if drive.startswith((NOISE, JITTER)):
        return "standard normal number, or 0"
    mode = {MANUAL: "signal by hand", AUTOMATIC: "1 while the controller has the signal, 0 while the hand has"}
    return mode.get(drive.partition(".")[0], f"signal of {drive}")


def list_outputs(system: AbstractSystem, names: Sequence[str]) -> Rows:
    """Return name, unit and description of the outputs, then of the profiles along the element."""
    outputs = system.outputs()
    described = [outputs[name] if name in outputs else PROFILES[name.split("[")[0]] for name in names]
    return [(name, o.unit, o.long_name) for name, o in zip(names, described, strict=True)]


def build_c_loop(bench: Bench, *, name: str | None = None, precision: str = "float64") -> CCore:
    """Return observers, controllers and supervisor of a bench as C, without its plant.

    Inputs are the readings, their ages, the references, and the signals without a controller. `NAME_start` is the first
    sample, `NAME_step` each other one, with the period as dt. Outputs are the drive signals of the next period, the
    alarm, estimates, and outputs of controllers.

    Raises:
        ParameterError: see `build_c_core`; or the bench has no controller.
    """
    if not bench.controllers.members():
        raise ParameterError("The loop of a bench without controllers gives no signals.")
    traced = trace_loop(bench)
    program, outputs = _loop_program(bench, traced)
    return core_of(
        bench,
        program,
        traced.size,
        _loop_inputs(bench),
        outputs,
        name=name,
        precision=precision,
        reports=False,
        pruned=True,
    )


def _loop_inputs(bench: Bench) -> Rows:
    readings, names = list_readings(bench), list_reads(bench)
    rows = [(name, readings[name].unit, readings[name].long_name) for name in names]
    rows += [(name + AGE, "s", f"age of {name}") for name in names]
    followed = zip(list_references(bench), reference_units(bench), strict=True)
    units = dict(followed)
    rows += [(name, unit, "what the controller shall follow") for name, unit in units.items()]
    ahead = [(one.name, units[one.name.rpartition(".ahead.")[0]], one.time) for one in list_previews(bench)]
    rows += [(name, unit, f"what it shall follow {time:.4g} s later; as now, if unknown") for name, unit, time in ahead]
    controlled = bench.controllers.members()
    free = [drive for drive in bench.plant.drives() if drive.name not in controlled]
    rows += [(one.name, one.unit, _describe_drive(one.name)) for one in hand_drives(bench)]
    return rows + [(drive.name, drive.unit, f"signal of {drive.name}") for drive in free]


def _loop_program(bench: Bench, traced: TracedLoop) -> tuple[Program, Rows]:
    """Return the traced loop with a function that reads its outputs from the state, and these outputs."""
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
    own, xp = list_controller_outputs(bench), cast("Any", program.xp)
    for name, node in collect_controller_outputs(bench, xp, loop.controllers).items():
        rows.append((name, own[name].unit, own[name].long_name))
        nodes.append(node)
    functions = {
        "init": replace(program.functions["begin"], name="init"),
        "step": step,
        "observe": Function("observe", names, tuple(nodes)),
    }
    return Program(program.graph, program.parameters, functions), rows
