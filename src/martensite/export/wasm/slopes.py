"""Derivatives in a WebAssembly module: kernels that also propagate derivatives of the state.

They are the functions of the core with forward derivatives (`martensite.kernels.slopes`). A direction is a parameter,
or a signal with a constant offset from the start on; up to `WIDTH` directions share one computation of the values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import find_paths
from martensite.export.c_core import CCore
from martensite.export.c_kernels import CKernel, precision_of
from martensite.export.c_source import fill_text, print_step
from martensite.kernels.kernel_printer import KernelPrinter, Statements
from martensite.kernels.program import Program
from martensite.kernels.slopes import ZERO, differentiate_program

WIDEST = 4
"""Largest number of directions at once."""


@dataclass(frozen=True)
class CoreSlopes:
    """Directions of the derivatives of a core, and the C of its kernels with them."""

    core: CCore
    names: tuple[str, ...]
    """Parameters, then signals, as the core names them."""

    @property
    def width(self) -> int:
        """Return the directions that share values."""
        return min(WIDEST, 1 << (len(self.names) - 1).bit_length())

    @property
    def size(self) -> int:
        """Return the derivatives stored per group of directions: of constants, state, signals and results."""
        states, inputs, outputs = self.core.states, len(self.core.inputs), len(self.core.outputs)
        return self.width * (self.program.constant_slopes + (states + inputs + 1) + (states + 1) + (outputs + 1))

    @property
    def places(self) -> dict[str, int]:
        """Return the module's index of each direction: the parameters, then all signals."""
        count = len(self._parameters)
        inputs = {one.name: one.index for one in self.core.inputs}
        return {name: count + inputs[name] if name in inputs else k for k, name in enumerate(self.names)}

    @property
    def _parameters(self) -> tuple[int, ...]:
        inputs = {one.name for one in self.core.inputs}
        indices = {one.name: one.index for one in self.core.parameters}
        return tuple(indices[name] for name in self.names if name not in inputs)

    @cached_property
    def program(self) -> Program:
        """Return the differentiated functions; a step has derivatives of the state only."""
        core = self.core
        inputs = len(core.inputs) if len(self._parameters) < len(self.names) else 0
        moving = {"init": inputs, "step": core.states + inputs, "observe": core.states + inputs}
        wrt = [core.kept[i] for i in self._parameters]
        made = differentiate_program(core.program, wrt, moving, range(len(core.outputs)))
        step = made.functions["step"]
        made.functions["step"] = replace(step, outputs=step.outputs[: len(step.outputs) // 2 + core.states])
        return made

    @cached_property
    def source(self) -> str:
        """Return the C before `slopes.c`."""
        core, program = self.core, self.program
        precision = precision_of(core.precision)
        wrt = [core.kept[i] for i in self._parameters]
        test, dialect = f"({{}} != {precision.literal(0.0)})", precision.dialect(f"{core.name}_")
        kernels = KernelPrinter(program, dialect, test=test, kept=core.kept, moving=wrt)
        constants = kernels.list_places("c", program.hoisted_nodes)
        parts = [
            f"enum {{ WIDTH = {self.width}, MOVING = {len(wrt)}, VALUES = {program.constants}, "
            f"VALUE_SLOPES = {program.constant_slopes} }};\n\n{_TYPE if self.width > 1 else _PLAIN}",
            _print_kernel("prepare", ("p", "dp"), kernels.prepare, constants, "c"),
        ]
        for name, values in (("init", core.states), ("step", core.states + 2 * core.reports), ("observe", None)):
            function = program.functions[name]
            inputs = CKernel.of(function, core.states if name != "init" else 0, len(core.inputs)).inputs
            made = kernels.print_function(function, inputs)
            count = len(core.outputs) if values is None else values
            places = [("y", k) for k in range(count)] + [("dy", k) for k in range(len(made.results) - count)]
            parts.append(_print_kernel(name, _TAKEN, made, places, "y"))
        return "\n".join(parts)

    @property
    def step_source(self) -> str:
        """Return the C of a step of the core with derivatives."""
        return fill_text(self.core, print_step(self.core, _STEP_BEGIN, _STEP_KERNEL, _STEP_KEPT))


def choose_slopes(system: AbstractSystem, core: CCore, names: Sequence[str]) -> CoreSlopes:
    """Return the directions of the named parameters (unique endings suffice) and signals."""
    inputs = [one.name for one in core.inputs]
    paths = [one.name for one in core.parameters]
    chosen: dict[str, None] = {}
    for name in names:
        if name not in inputs and not find_paths(name, paths):
            raise ParameterError(f"There is no parameter or signal `{name}`. {suggest_name(name, [*inputs, *paths])}")
        chosen[name if name in inputs else system.resolve(name)] = None
    parameters = [core.parameters[paths.index(name)] for name in chosen if name not in inputs]
    for one in parameters:
        if not one.used:
            raise ParameterError(f"There is no slope by `{one.name}`: no number follows from it.")
        if core.sample == f"m->p[{one.index}]":
            raise ParameterError(f"There is no slope by `{one.name}`: it is the length of every step.")
    return CoreSlopes(core, (*(one.name for one in parameters), *(name for name in inputs if name in chosen)))


def _print_kernel(
    name: str, taken: Sequence[str], made: Statements, places: Sequence[tuple[str, int]], given: str
) -> str:
    lines = list(made.lines)
    for (array, k), value, flag in zip(places, made.results, made.flags, strict=True):
        lines.append(f"{array}[{k}] = {f'({value}) ? 1.0 : 0.0' if flag else value};")
    arguments = [
        "double dt" if one == "dt" else f"const {'slopes' if one[0] == 'd' else 'double'} *restrict {one}"
        for one in taken
    ]
    arguments += [f"double *restrict {given}", f"slopes *restrict d{given}"]
    body = "".join(f"    {line}\n" for line in lines)
    return f"static void slopes_of_{name}({', '.join(arguments)})\n{{\n{body}}}\n"


_TAKEN = ("c", "dc", "x", "dx", "u", "dt")
_PLAIN = f"typedef double slopes;\nstatic const slopes {ZERO};\n"
_TYPE = f"typedef double slopes __attribute__((vector_size(8 * WIDTH), aligned(8)));\nstatic const slopes {ZERO};\n"

_STEP_BEGIN = """
/* The state and its slopes, or neither, go on. */
static int step_with_slopes(${NAME}_model *m, const double *u, double dt, const prepared *v, tangent *t, int groups)
{
"""
_STEP_KERNEL = """\
    for (i = 0; i < groups; i++) slopes_of_step(v->c, t[i].c, m->x, t[i].x, u, dt, y, t[i].next);
"""
_STEP_KEPT = """\
    if (!finite_slopes(t, groups)) return ${NAME}_NOT_FINITE;
    keep_slopes(t, groups);
"""
