"""Traced kernels as C for single runs: plain functions over arrays, in double or float.

In double, operations and their order equal those on Python floats. Results are equal bit for bit if Python and C share
a libm and the compiler fuses no operations. In float the limits of `exp` and `log` follow the type, and constants are
rounded to the nearest finite value.
"""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from martensite.base.errors import require_known
from martensite.kernels.c99 import LoopCondition, scalar_dialect
from martensite.kernels.graph import Expr, Graph
from martensite.kernels.kernel_printer import KernelPrinter, Statements
from martensite.kernels.printer import Dialect
from martensite.kernels.program import Function, Program
from martensite.kernels.rolled_lines import roll_lines
from martensite.simulate.march import SOLVED

TINY, HUGE = 1.1754943508222875e-38, 3.4028234663852886e38
"""Smallest and largest normal float."""

_EVERY = {"both": "({} && {})", "either": "({} || {})"}
_DOUBLE = {
    **_EVERY,
    "nearest": "(rint({}) + 0.0)",
    "power": "({0} > 0.0 ? fmin(pow({0}, {1}), 1.0142320547350045e+304) : 0.0)",
    "quarter_sine": "sin(1.5707963267948966 * {})",
}
_FLOAT = {
    **_EVERY,
    "abs": "fabsf({})",
    "sqrt": "({0} > 0.0f ? sqrtf({0}) : 0.0f)",
    "exp": "expf({0} < 88.0f ? {0} : 88.0f)",
    "log": "logf({0} > 1.17549435e-38f ? {0} : 1.17549435e-38f)",
    "power": "({0} > 0.0f ? fminf(powf({0}, {1}), 1.65163625e+38f) : 0.0f)",
    "sin": "sinf({})",
    "cos": "cosf({})",
    "tanh": "tanhf({})",
    "nearest": "(rintf({}) + 0.0f)",
    "quarter_sine": "sinf(1.57079633f * {})",
    "eps": "1.1920929e-07f",
}


@dataclass(frozen=True)
class Precision:
    """A floating-point type in C."""

    name: str
    number: str
    suffix: str
    """Suffix of literals and of functions of libm."""
    largest: str
    size: int
    """Bytes."""
    near: float
    """Relative tolerance of a sample time."""
    solved: float
    """Residual below which the coupled step is solved."""

    def literal(self, value: float | bool) -> str:
        """Return a literal."""
        if isinstance(value, bool):
            return str(int(value))
        value = self.round_number(value)
        if math.isinf(value):
            return f"{'-' if value < 0.0 else ''}{'INFINITY' if self.suffix else 'HUGE_VAL'}"
        text = repr(value) if self.number == "double" else f"{value:.9g}"
        return f"{text if set(text) & set('.e') else f'{text}.0'}{self.suffix}"

    def round_number(self, value: float) -> float:
        """Return the nearest finite number of the type; a nonzero value stays nonzero."""
        if self.number == "double" or value == 0.0 or not math.isfinite(value):
            return value
        size = min(max(abs(value), TINY), HUGE)
        return math.copysign(struct.unpack("f", struct.pack("f", size))[0], value)

    def dialect(self, prefix: str) -> Dialect:
        """Return the dialect of C in this type, with a prefix for added functions."""
        templates = _DOUBLE if self.number == "double" else _FLOAT
        own = {"erfcx": f"{prefix}erfcx({{}})"}
        going = LoopCondition(f"{{}} > {self.literal(0.0)}")
        return scalar_dialect(self.number, {**templates, **own}, self.literal, going=going)


PRECISIONS = {
    one.name: one
    for one in (
        Precision("float64", "double", "", "DBL_MAX", 8, 1e-6, SOLVED),
        Precision("float32", "float", "f", "FLT_MAX", 4, 1e-5, 1e-5),
    )
}


def precision_of(name: str) -> Precision:
    """Return a precision by name."""
    require_known("precision", name, PRECISIONS)
    return PRECISIONS[name]


@dataclass(frozen=True)
class CKernel:
    """A traced function, with the C expressions of its inputs: `x[0]`, `u[1]`, `dt`."""

    function: Function
    inputs: tuple[str, ...]

    @staticmethod
    def of(function: Function, states: int, drives: int) -> CKernel:
        """Return a kernel of states, drives and, for one more input, the length of a step."""
        places = [*(f"x[{i}]" for i in range(states)), *(f"u[{i}]" for i in range(drives))]
        places += ["dt"] * (len(function.inputs) - len(places))
        return CKernel(function, tuple(places[: len(function.inputs)]))


def used_parameters(program: Program) -> set[int]:
    """Return the indices of the parameters that have an effect."""
    graph, stack = program.graph, [node.index for node in program.hoisted_nodes]
    numbers = {graph.input(f"p{i}", 0).index: i for i in range(len(program.parameters))}
    visited: set[int] = set()
    while stack:
        index = stack.pop()
        if index not in visited:
            visited.add(index)
            stack += graph.children(index)
    return {numbers[index] for index in visited if index in numbers}


def kernels_text(
    program: Program, parameter_indices: Sequence[int], kernels: Sequence[CKernel], prefix: str, precision: Precision
) -> str:
    """Return C of `PREFIXkernel_prepare(p, c)`, and of `PREFIXkernel_NAME(c, x, u, dt, y)` for each kernel.

    `parameter_indices` are the program's indices of the parameters in p.
    """
    dialect, zero = precision.dialect(prefix), precision.literal(0.0)
    printer = KernelPrinter(program, dialect, test=f"({{}} != {zero})", kept=parameter_indices)
    parts = [_print_function(f"{prefix}kernel_prepare", ("p",), "c", printer.prepare, precision)]
    for kernel in kernels:
        name, taken = f"{prefix}kernel_{kernel.function.name}", ("c", "x", "u", "dt")
        body = printer.print_function(kernel.function, kernel.inputs)
        parts.append(_print_function(name, taken, "y", body, precision))
    text = "\n".join(parts)
    return (_print_erfcx(precision, prefix) + text) if "erfcx(" in text else text


def _print_function(name: str, taken: Sequence[str], given: str, statements: Statements, precision: Precision) -> str:
    number, one, zero = precision.number, precision.literal(1.0), precision.literal(0.0)
    values = zip(statements.results, statements.flags, strict=True)
    numbers = [f"({value}) ? {one} : {zero}" if flag else value for value, flag in values]
    lines = [*statements.lines, *roll_lines([f"{given}[{i}] = {number};" for i, number in enumerate(numbers)])]
    body = "".join(f"    {line}\n" for line in lines)
    arguments = ", ".join(f"{number} {a}" if a == "dt" else f"const {number} *restrict {a}" for a in taken)
    unused = [a for a in taken if (a if a == "dt" else f"{a}[") not in body]
    unused += [] if statements.results else [given]
    idle = "".join(f"    (void){a};\n" for a in unused)
    return f"static void {name}({arguments}, {number} *restrict {given}) {{\n{idle}{body}}}\n"


def _print_erfcx(precision: Precision, prefix: str) -> str:
    """Return C of exp(x²) erfc(x) for x ≥ 0; above 5 by the asymptotic continued fraction."""
    number, s, at = precision.number, precision.suffix, precision.literal
    return (
        f"static {number} {prefix}erfcx({number} x) {{\n"
        f"    {number} tail = x;\n    int k;\n"
        f"    if (x < {at(5.0)}) return exp{s}(x * x) * erfc{s}(x);\n"
        f"    for (k = 24; k > 0; k--) tail = x + {at(0.5)} * ({number})k / tail;\n"
        f"    return {at(1.0)} / ({at(math.sqrt(math.pi))} * tail);\n}}\n\n"
    )


COSTS: Mapping[str, Mapping[str, int]] = {
    "add": {"add": 1},
    "sub": {"add": 1},
    "neg": {"add": 1},
    "mul": {"mul": 1},
    "div": {"div": 1},
    "lt": {"compare": 1},
    "le": {"compare": 1},
    "gt": {"compare": 1},
    "ge": {"compare": 1},
    "both": {"logic": 1},
    "either": {"logic": 1},
    "negate": {"logic": 1},
    "where": {"select": 1},
    "minimum": {"compare": 1, "select": 1},
    "maximum": {"compare": 1, "select": 1},
    "abs": {"abs": 1},
    "sqrt": {"sqrt": 1, "compare": 1, "select": 1},
    "exp": {"exp": 1, "compare": 1, "select": 1},
    "log": {"log": 1, "compare": 1, "select": 1},
    "power": {"power": 1, "compare": 2, "select": 2},
    "sin": {"sin": 1},
    "cos": {"cos": 1},
    "tanh": {"tanh": 1},
    "nearest": {"round": 1, "add": 1},
    "quarter_sine": {"sin": 1, "mul": 1},
    "erfcx": {"erfcx": 1},
}
"""Basic operations of each graph operation; a missing one costs nothing. Subtraction and sign count as additions;
`erfcx`
is an `exp` and an `erfc`, or 24 divisions.
"""
_KINDS = "add mul div sqrt exp log power sin cos tanh erfcx round abs compare select logic"
ORDER = _KINDS.split()


def count_operations(graph: Graph, outputs: Iterable[Expr], available: Iterable[Expr] = ()) -> dict[str, int]:
    """Return the largest operation counts of `outputs`, if the nodes `known` are available.

    Each node counts once, in a loop once per turn. Skipped branches and memory access are not considered.
    """
    counts: Counter[str] = Counter()
    _count_nodes(graph, [o.index for o in outputs], {k.index for k in available}, 0, 1, counts)
    return {name: counts[name] for name in ORDER if counts[name]}


def _count_nodes(
    graph: Graph, outputs: Iterable[int], available: set[int], inside: int, turns: int, counts: Counter[str]
) -> None:
    """Add the nodes of `wanted` and their inputs, `turns` times; within a loop only those that depend on it."""
    visited, stack = set(available), list(outputs)
    while stack:
        index = stack.pop()
        if index in visited or (inside and not graph.depends[index] & inside):
            continue
        visited.add(index)
        for kind, count in COSTS.get(graph.operations[index], {}).items():
            counts[kind] += count * turns
        if index in graph.loops:
            loop = graph.loops[index]
            rows = turns * len(loop.columns[0])
            _count_nodes(graph, loop.outputs, available, loop.bit, rows, counts)
        elif index in graph.repeats:
            repeat = graph.repeats[index]
            _count_nodes(graph, repeat.outputs, available, repeat.bit, turns * repeat.turns, counts)
        stack += graph.children(index)
