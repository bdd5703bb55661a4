"""Kernel of a port: a trial step from a committed state, with derivatives for a host's Newton iteration.

In addition to `init`, `step` and `observe` it has a function

    respond(state, inputs, dt) -> state', residual, crossing, answers, ∂ answers/∂ inputs

with derivatives through the solution of the step (`martensite.kernels.slopes`): the consistent tangent. An unsolved
step of a material is split into equal parts, as in `martensite.simulate.material_point`; its derivatives are then
central differences. Python floats and C come from the same trace.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.base.parameters import StructureKey, values_at
from martensite.export.c_core import CCore, core_of, describe_drives, list_outputs
from martensite.export.c_tried import PARTS
from martensite.export.ports.element import ElementPort
from martensite.export.ports.material import PROBES, MaterialPort
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.graph import PARAMETER
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.kernels.slopes import differentiate_results
from martensite.simulate.compiled import REPORT, compile_system
from martensite.simulate.march import SOLVED

MATERIAL_ANSWERS = ("stress", "heat")
ELEMENT_ANSWERS = ("force", "temperature", "resistance", "martensite_fraction")
RESPOND = "respond"
Functions = dict[str, Callable[..., tuple[float, ...]]]


@dataclass(frozen=True, eq=False)
class PortKernel:
    """A traced port with its parameter values."""

    system: ElementPort | MaterialPort
    program: Program
    values: list[float]
    size: int
    """Size of the state."""
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    answers: tuple[str, ...]
    """Outputs with derivatives."""
    probes: tuple[float, ...]
    """Input changes for central differences of split steps, for the inputs that lead the state. Empty if the host must
    shorten its steps.
    """

    @cached_property
    def functions(self) -> Functions:
        """Return `init`, `step`, `observe` and `respond` on floats."""
        return dict(self.program.bind_floats(*self.values))

    def write_core(self, *, name: str | None = None, precision: str = "float64") -> CCore:
        """Return the port as C, with `NAME_try`."""
        return core_of(
            self.system,
            self.program,
            self.size,
            describe_drives(self.system),
            list_outputs(self.system, self.outputs),
            name=name,
            precision=precision,
            reports=True,
            pruned=True,
            answers=self.answers,
            probes=self.probes if precision == "float64" else (),
        )

    def try_step(self, state: Sequence[float], inputs: Sequence[float], dt: float) -> tuple[Sequence[float], bool]:
        """Return the response to a step, split if necessary, and whether it was solved."""
        response = self.functions[RESPOND](*state, *inputs, dt)
        parts = 1
        while not response[self.size] <= SOLVED and self.probes and parts < PARTS:
            parts *= 2
            response = self._in_parts(state, inputs, dt, parts)
            if response[self.size] <= SOLVED:
                response = self._with_differences(response, state, inputs, dt, parts)
        return response, response[self.size] <= SOLVED and all(map(math.isfinite, response))

    def _in_parts(self, state: Sequence[float], inputs: Sequence[float], dt: float, parts: int) -> Sequence[float]:
        """Return the last of equal parts of a step, with their largest residual and crossing."""
        begin, now, worst, crossing = state[: len(inputs)], state, 0.0, 0.0
        response: Sequence[float] = ()
        for k in range(1, parts + 1):
            share = k / parts
            there = [a + (b - a) * share if k < parts else b for a, b in zip(begin, inputs, strict=True)]
            response = self.functions[RESPOND](*now, *there, dt / parts)
            now = response[: self.size]
            worst, crossing = max(worst, response[self.size]), max(crossing, response[self.size + 1])
        return [*now, worst, crossing, *response[self.size + 2 :]]

    def _with_differences(
        self, response: Sequence[float], state: Sequence[float], inputs: Sequence[float], dt: float, parts: int
    ) -> Sequence[float]:
        first, count = self.size + 2, len(self.answers)
        columns: list[list[float]] = []
        worst = response[self.size]
        for place, probe in enumerate(self.probes):
            sides: list[Sequence[float]] = []
            for change in (probe, -probe):
                moved = [one + change if k == place else one for k, one in enumerate(inputs)]
                sides.append(self._in_parts(state, moved, dt, parts))
                worst = max(worst, sides[-1][self.size])
            ends = [side[first : first + count] for side in sides]
            columns.append([(a - b) / (2.0 * probe) for a, b in zip(*ends, strict=True)])
        slopes = [one for row in zip(*columns, strict=True) for one in row]
        return [*response[: self.size], worst, response[self.size + 1], *response[first : first + count], *slopes]


def compile_port(system: ElementPort | MaterialPort) -> PortKernel:
    """Trace a port, or return the cached program of the same structure with the values of this one."""
    material = isinstance(system, MaterialPort)
    answers = MATERIAL_ANSWERS if material else ELEMENT_ANSWERS
    compiled = compile_system(system)
    values = values_at(system, compiled.paths)
    inputs = tuple(drive.name for drive in system.drives())
    program = _add_response(StructureKey(system), answers)
    return PortKernel(system, program, values, compiled.size, inputs, compiled.outputs, answers, PROBES * material)


def extend_program(system: AbstractSystem) -> tuple[Program, Any, NestedShape, list[str]]:
    """Return a copy of a system's program for further functions.

    Returns:
        The program, the system with traced parameters, the shape of its state, and the names of state and inputs.
    """
    compiled, count = compile_system(system), len(system.drives())
    program = Program(compiled.program.graph, list(compiled.program.parameters), dict(compiled.program.functions))
    traced: Any = system.rebuilt(
        {path: program.graph.input(f"p{i}", PARAMETER) for i, path in enumerate(compiled.paths)}
    )
    shape = NestedShape(traced.init(program.xp, *program.functions["init"].outputs[:count]))
    return program, traced, shape, [f"s{i}" for i in range(compiled.size)] + [f"u{i}" for i in range(count)]


@cache_answers(32)
def _add_response(keyed: StructureKey[AbstractSystem], answers: tuple[str, ...]) -> Program:
    compiled, count = compile_system(keyed.part), len(keyed.part.drives())
    program, system, shape, names = extend_program(keyed.part)
    size = compiled.size
    places = [compiled.outputs.index(name) for name in answers]

    def respond(xp: Any, *arguments: Any) -> list[Any]:
        *given, dt = arguments
        drives = given[size:]
        after, report = system.step(xp, shape.rebuild(given[:size]), *drives, dt=dt)
        outputs = system.observe(xp, after, *drives)
        return [*flatten_numbers(after), *flatten_numbers(report)[: len(REPORT)], *(outputs[k] for k in places)]

    program.add(RESPOND, [*names, "dt"], respond)
    function = program.functions[RESPOND]
    first = size + len(REPORT)
    wanted = function.inputs[size : size + count]
    slopes = differentiate_results(program, RESPOND, range(first, first + len(places)), wanted)
    flat = tuple(one for row in slopes for one in row)
    program.functions[RESPOND] = replace(function, outputs=function.outputs + flat)
    return program
