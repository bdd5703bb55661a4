"""A system, a bench, or the loop of a bench as C99, for microcontrollers and for FMUs.

The C is generated from the kernels that every simulation runs, so the physics is the same. A
model is one struct of numbers; what acts on it allocates nothing and needs no library but libm.
A loop is the part to flash: observers, controllers and supervisor of a bench, by the same kernels
as those of `martensite.control.loop.realtime.RealtimeStep`, without the plant.
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
"""Name, unit and words."""


@dataclass(frozen=True)
class CCore:
    """A model in C: its text, and what is in it."""

    name: str
    """Name of the files, and prefix of all names in them."""
    description: str
    """Description in words."""
    precision: str
    """float64 or float32."""
    program: Program
    """With functions `init`, `step` and `observe`."""
    kept: Sequence[int]
    """Places in the program of the parameters."""
    parameters: tuple[CoreVariable, ...]
    inputs: tuple[CoreVariable, ...]
    outputs: tuple[CoreVariable, ...]
    states: int
    reports: bool
    """True if steps end with residual and crossing."""
    sample: str | None
    """Sample time of a system in discrete time, in C; None if a step may have any length."""
    sample_time: float
    """The length of every step [s] of a system in discrete time; else 0."""
    answers: tuple[str, ...] = ()
    """Outputs whose slopes a function `respond` gives, with a step that is tried; none without it."""
    probes: tuple[float, ...] = ()
    """Changes of inputs for differences, where steps may be taken in parts: see `ports.kernel`."""
    continuous: tuple[int, ...] = ()
    """Places in the state of numbers whose rates a function `differentiate` gives; none without it."""

    @cached_property
    def header(self) -> str:
        """Return the text of the header."""
        return header_text(self)

    @cached_property
    def source(self) -> str:
        """Return the text of the source."""
        return source_text(self)

    @property
    def constants(self) -> int:
        """Return the numbers that follow from the parameters."""
        return len(self.program.hoisted_nodes)

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Return the largest costs of `prepare`, `start`, `step`, `observe` and, of a port, one `try`, by kind."""
        graph, known = self.program.graph, self.program.hoisted_nodes
        found = {"prepare": count_operations(graph, known)}
        labels = {"init": "start", "step": "step", "observe": "observe"} | ({"respond": "try"} if self.answers else {})
        for name, label in labels.items():
            found[label] = count_operations(graph, self.program.functions[name].outputs, known)
        return found

    @property
    def size(self) -> int:
        """Size of the model [bytes]."""
        counts = (len(self.parameters), self.constants, self.states)
        return precision_of(self.precision).size * (sum(map(count_elements, counts)) + 2)

    @property
    def files(self) -> dict[str, str]:
        """Texts by the name of their file."""
        return {f"{self.name}.h": self.header, f"{self.name}.c": self.source}

    def write(self, folder: str | Path) -> list[Path]:
        """Write header and source into a folder, over existing files, and return their paths.

        Raises:
            DataError: the folder does not exist or is not writable.
        """
        found: list[Path] = []
        for name, text in self.files.items():
            found.append(Path(folder) / name)
            write_file(found[-1], text)
        return found


def build_c_core(system: AbstractSystem, *, name: str | None = None, precision: str = "float64") -> CCore:
    """Return a system or a bench as C.

    Args:
        system: a `System`, a `Machine`, or a `Bench` with its loops.
        name: of the core, an identifier of C; by default made of the kinds of its parts.
        precision: float64 (`double`), or float32 (`float`) for processors without doubles.

    Raises:
        ParameterError: the name is not an identifier, or the precision is unknown.
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
    continuous: tuple[int, ...] = (),
) -> CCore:
    """Return the core of a program with functions `init`, `step` and `observe`.

    `reports` says whether steps end with residual and crossing, `pruned` whether parameters that
    change nothing are left out, `answers` of which outputs a function `respond` gives slopes, `continuous`
    of which numbers of the state a function `differentiate` gives rates.
    """
    timed, leaves = _sample_path(whole), list(whole.leaves())
    places = {leaf.path: i for i, leaf in enumerate(leaves)}
    used = used_parameters(program) | ({places[timed]} if timed else set[int]())
    kept = sorted(used) if pruned else list(places.values())
    given = list_parameters((leaves[i] for i in kept), (i in used for i in kept))
    sample = f"m->p[{kept.index(places[timed])}]" if timed else None
    return CCore(
        name=choose_identifier(name, whole.description()),
        description=whole.description(),
        precision=precision_of(precision).name,
        program=program,
        kept=kept,
        parameters=given,
        inputs=list_variables("u", inputs, 0.0),
        outputs=list_variables("y", outputs, math.nan),
        states=states,
        reports=reports,
        sample=sample,
        sample_time=whole.sample_time() if sample else 0.0,
        answers=answers,
        probes=probes,
        continuous=continuous,
    )


def _sample_path(whole: AbstractSystem) -> str | None:
    twin = whole.rebuilt({leaf.path: leaf.path for leaf in whole.leaves()})
    found: Any = twin.sample_time()
    return found if isinstance(found, str) else None


# ---------------------------------------------------------------- names, units, words


def describe_drives(system: AbstractSystem) -> Rows:
    """Return the name, unit and words of the inputs of a system."""
    known = system.outputs()
    return [
        (one.name, one.unit, known[one.name].long_name if one.name in known else _describe_drive(one.name))
        for one in system.drives()
    ]


def _describe_drive(drive: str) -> str:
    if drive.startswith((NOISE, JITTER)):
        return "standard normal number, or 0"
    mode = {MANUAL: "signal by hand", AUTOMATIC: "1 while the controller has the signal, 0 while the hand has"}
    return mode.get(drive.partition(".")[0], f"signal of {drive}")


def list_outputs(system: AbstractSystem, names: Sequence[str]) -> Rows:
    """Return the outputs of a system, then what differs along its element."""
    known = system.outputs()
    described = [known[name] if name in known else PROFILES[name.split("[")[0]] for name in names]
    return [(name, o.unit, o.long_name) for name, o in zip(names, described, strict=True)]


# ---------------------------------------------------------------- loops


def build_c_loop(bench: Bench, *, name: str | None = None, precision: str = "float64") -> CCore:
    """Return observers, controllers and supervisor of a bench as C, without its plant.

    Inputs are the readings, their ages, the references and the signals that no controller has.
    `NAME_start` is the first sample, `NAME_step` every other, with the period for dt; outputs are
    the signals of the drives for the period that begins, the alarm, what observers estimate
    and what controllers say of themselves.

    Raises:
        ParameterError: as for `c_core`; or the bench has no controller.
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
        precision=precision,
        reports=False,
        pruned=True,
    )


def _loop_inputs(bench: Bench) -> Rows:
    known, names = list_readings(bench), list_reads(bench)
    rows = [(name, known[name].unit, known[name].long_name) for name in names]
    rows += [(name + AGE, "s", f"age of {name}") for name in names]
    followed = zip(list_references(bench), reference_units(bench), strict=True)
    units = dict(followed)
    rows += [(name, unit, "what the controller shall follow") for name, unit in units.items()]
    ahead = [(one.name, units[one.name.rpartition(".ahead.")[0]], one.time) for one in list_previews(bench)]
    rows += [(name, unit, f"what it shall follow {time:.4g} s later; as now, if unknown") for name, unit, time in ahead]
    taken = bench.controllers.members()
    free = [drive for drive in bench.plant.drives() if drive.name not in taken]
    rows += [(one.name, one.unit, _describe_drive(one.name)) for one in hand_drives(bench)]
    return rows + [(drive.name, drive.unit, f"signal of {drive.name}") for drive in free]


def _loop_program(bench: Bench, traced: TracedLoop) -> tuple[Program, Rows]:
    """Return the traced loop with a function that picks what it says from its state, and its outputs."""
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
