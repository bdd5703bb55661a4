"""CUDA C of a traced system on given steps, one run per thread.

The graph is the same as for `martensite.kernels.c99`. The code is C except for a few CUDA keywords, so tests can
compile it for the processor.

One thread computes all values of common parameters, and all threads read them from constant memory. Divisions by
the same value share an inverse, and products and sums are fused. Results therefore differ from C by rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from martensite.kernels.c99 import LoopCondition, scalar_dialect, write_functions
from martensite.kernels.floats import LARGEST
from martensite.kernels.graph import PARAMETER, VARYING, Expr
from martensite.kernels.printer import Dialect, Printer, parameter_nodes
from martensite.kernels.program import Function
from martensite.kernels.rolled_lines import roll_lines
from martensite.simulate.compiled import CompiledMarch

REPORTS = 2
"""Step reports in a batch."""
THREADS = 128
"""Threads per block."""


WORDS = """#ifdef __cplusplus
#define C_NAME extern "C"
#else
#define C_NAME
#endif
#define UNUSED __attribute__((unused))
#define FUNCTION static __device__ __forceinline__
#define KERNEL C_NAME __global__ void __launch_bounds__(THREADS)
#ifndef HUGE_VAL
#define HUGE_VAL __longlong_as_double(0x7ff0000000000000LL)
#endif
"""
"""Text before all CUDA C of this package."""


@dataclass(frozen=True)
class NumberType:
    """Floating-point type in CUDA C."""

    name: str
    number: str
    suffix: str
    """Suffix of literals and library functions."""
    largest: float
    """Largest value of an exponential or power."""
    highest: float
    """Largest argument of an exponential; below its negative value, the result is 0."""
    least: float
    """Smallest argument of a logarithm."""

    def literal(self, value: float | bool) -> str:
        """Return a literal, rounded to the nearest representable value and never to 0."""
        if isinstance(value, bool):
            return str(int(value))
        if math.isinf(value) or math.isnan(value):
            return repr(value).replace("inf", "HUGE_VAL").replace("nan", "NAN")
        limits = np.finfo(self.name)
        if value != 0.0:
            value = math.copysign(min(max(abs(value), float(limits.tiny)), float(limits.max)), value)
        return f"{float(np.dtype(self.name).type(value))!r}{self.suffix}"

    def dialect(self) -> Dialect:
        """Return the operations on numbers of this type."""
        at, s = self.literal, self.suffix
        zero, top = at(0.0), at(self.highest)
        templates = {
            "abs": f"fabs{s}({{}})",
            "sqrt": f"({{0}} > {zero} ? sqrt{s}({{0}}) : {zero})",
            "exp": f"({{0}} > {at(-self.highest)} ? exp{s}({{0}} < {top} ? {{0}} : {top}) : {zero})",
            "log": f"log{s}({{0}} > {at(self.least)} ? {{0}} : {at(self.least)})",
            **{name: f"{name}{s}({{}})" for name in ("sin", "cos", "tanh")},
            "nearest": f"rint{s}({{}})",
            "erfcx": "erfcx_of({})",
            "eps": at(float(np.finfo(self.name).eps)),
        }
        going = LoopCondition(f"{{}} > {zero}")
        dialect = scalar_dialect("number", templates, at, "bool", going)
        return replace(dialect, shares_inverses=True)

    def prelude(self) -> str:
        """Return the C text of types and functions."""
        kind = "UNUSED FUNCTION", "erfcx_of", self.suffix, self.literal, self.largest
        return f"typedef {self.number} number;\n{write_functions('number', *kind)}"


NUMBER_TYPES = {
    one.name: one
    for one in (
        NumberType("float64", "double", "", LARGEST, 700.0, 1e-300),
        NumberType("float32", "float", "f", 6.0760e37, 87.0, 1.17549435e-38),
    )
}


@dataclass(frozen=True)
class MarchSource:
    """Source of runs of a system, independent of parameter values."""

    compiled: CompiledMarch
    outputs: tuple[int, ...]
    varied: tuple[int, ...]
    """Indices of the parameters that differ from run to run."""
    precision: str = "float64"
    own_steps: bool = False
    """True for individual signals and steps."""
    own_limits: bool = False
    """True for individual envelopes."""

    @property
    def kind(self) -> np.dtype[Any]:
        """Return the floating-point type."""
        return np.dtype(self.precision)

    @cached_property
    def text(self) -> str:
        """Return the CUDA C of functions and time integration."""
        constants = {
            **self.sizes,
            "THREADS": THREADS,
            "PLACES": "{" + ", ".join(map(str, [*self.compiled.signals_in_step(), 0])) + "}",
            "OWN_STEPS": int(self.own_steps),
            "OWN_LIMITS": int(self.own_limits),
        }
        defined = "".join(f"#define {name} {value}\n" for name, value in constants.items())
        parts = [defined, WORDS, NUMBER_TYPES[self.precision].prelude(), *self._print_functions()]
        return "\n".join([*parts, Path(__file__).with_name("given_steps.cu").read_text(encoding="utf-8")])

    @property
    def sizes(self) -> dict[str, int]:
        """Return the lengths of arrays."""
        compiled = self.compiled
        return {
            "COMMON": len(self._common),
            "OWN": len(self._own),
            "VARIED": len(self.varied),
            "SIZE": compiled.size,
            "DRIVES": compiled.drives,
            "INPUTS": compiled.inputs,
            "OUTPUTS": len(self.outputs),
            "REPORTS": REPORTS,
            "ENVELOPE": len(compiled.envelope),
        }

    @cached_property
    def _functions(self) -> list[Function]:
        """Return the functions of the time integration, with the requested outputs."""
        traced, judged = self.compiled.program.functions, len(self.compiled.convergence_scales)
        end = judged + len(self.compiled.envelope)
        outputs = {
            "init": traced["init"].outputs,
            "step": traced["step"].outputs[: self.compiled.size + REPORTS],
            "observe": tuple(traced["observe"].outputs[i] for i in self.outputs),
            "judge": traced["judge"].outputs[judged:end],
        }
        return [replace(traced[name], outputs=wanted) for name, wanted in outputs.items()]

    @cached_property
    def _varying(self) -> set[int]:
        """Return the nodes that contain a varied parameter."""
        graph = self.compiled.program.graph
        nodes = {graph.input(f"p{place}", PARAMETER).index for place in self.varied}
        for index in range(len(graph.operations)):
            if not nodes.isdisjoint(graph.children(index)):
                nodes.add(index)
        return nodes

    @cached_property
    def _own(self) -> list[Expr]:
        """Return the values that depend on a varied parameter."""
        return [node for node in self._prepared if node.index in self._varying]

    @cached_property
    def _common(self) -> list[Expr]:
        """Return the values of common parameters that the run or varied values use."""
        graph, varying = self.compiled.program.graph, self._varying
        reached = graph.walk([n.index for n in self._prepared], lambda i: graph.children(i) if i in varying else ())
        shared = sorted(i for i in reached if i not in varying and graph.depends[i] & PARAMETER)
        return [Expr(graph, index) for index in shared]

    @cached_property
    def _prepared(self) -> list[Expr]:
        graph = self.compiled.program.graph
        return parameter_nodes(graph, [node for one in self._functions for node in one.outputs])

    def _print_functions(self) -> Iterator[str]:
        graph, precision = self.compiled.program.graph, NUMBER_TYPES[self.precision]
        printer = Printer(graph, precision.dialect())
        parameters = [graph.input(f"p{place}", PARAMETER) for place in range(len(self.compiled.paths))]

        def share(nodes: Sequence[Expr], array: str) -> None:
            """Return nodes as array elements, with conditions as numbers."""
            test = f"({{}} != {precision.literal(0.0)})"
            texts = [f"{array}[{k}]" for k in range(len(nodes))]
            flagged = [test.format(t) if printer.is_flag(n.index) else t for t, n in zip(texts, nodes, strict=True)]
            printer.share(nodes, lambda k: flagged[k])

        def write(name: str, taken: Sequence[str], given: str, outputs: Sequence[Expr]) -> str:
            lines, results = printer.block(outputs)
            lines += roll_lines([f"{given}[{k}] = {text};" for k, text in enumerate(results)])
            arguments = ", ".join([*(f"const number *{one}" for one in taken), f"number *{given}"])
            body = "".join(f"    {line}\n" for line in lines)
            return f"FUNCTION void k_{name}({arguments}) {{\n{body}}}\n"

        share(parameters, "p")
        yield write("prepare", ["p"], "c", self._common)
        yield f"__constant__ number common[{len(self._common) + 1}];\n"
        share(self._common, "common")
        share([parameters[place] for place in self.varied], "p")
        yield write("own", ["p"], "c", self._own)
        share(self._own, "c")
        for one in self._functions:
            parts = self._place_inputs(one)
            printer.share([graph.input(name, VARYING) for name in one.inputs], lambda k, parts=parts: parts[k])
            yield write(one.name, ["c", "x", "u"], "y", one.outputs)

    def _place_inputs(self, function: Function) -> list[str]:
        """Return the states in x, then signals in u."""
        states = 0 if function.name == "init" else self.compiled.size
        rest = len(function.inputs) - states
        return [*(f"x[{k}]" for k in range(states)), *(f"u[{k}]" for k in range(rest))]
