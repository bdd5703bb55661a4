"""C of what a chain computes from numbers alone, and of the kernels of its blocks.

What depends on the free and fixed numbers only is computed once per run, in `prepare`, and is
c[i] from then on. A kernel is printed as statements over its inputs x0, x1, … and its state
s0, s1, …; whoever asks declares these, and stores the results where they belong.
"""

from __future__ import annotations

from typing import NamedTuple

from martensite.kernels.c99 import C_DIALECT
from martensite.kernels.printer import Printer
from martensite.kernels.program import Program


class Statements(NamedTuple):
    """A kernel in C."""

    lines: list[str]
    """Assignments of what it needs on the way."""
    results: list[str]
    """Its results as expressions."""


class Kernels:
    """The kernels of a program, each printed when asked for."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._printer = Printer(program.graph, C_DIALECT)
        parameters = [program.graph.input(f"p{i}", 0) for i in range(len(program.parameters))]
        self._printer.share(parameters, lambda i: f"p[{i}]")
        self.prepare = self._prepared()

        flags = [self._printer.is_flag(node.index) for node in program.hoisted_nodes]
        self._printer.share(
            program.hoisted_nodes, lambda i: f"(c[{i}] != 0.0)" if flags[i] else f"c[{i}]"
        )

    @property
    def constants(self) -> int:
        """Length of c, at least 1."""
        return max(len(self._program.hoisted_nodes), 1)

    def _prepared(self) -> str:
        """`prepare(p, c)`. A long list of assignments: inlined, it would be compiled twice."""
        lines, values = self._printer.block(self._program.hoisted_nodes)
        lines += [f"c[{i}] = {value};" for i, value in enumerate(values)]
        body = "".join(f"    {line}\n" for line in lines)
        return (
            "static __attribute__((noinline)) void prepare(\n"
            f"    const double *restrict p, double *restrict c) {{\n{body}}}\n"
        )

    def statements(self, name: str) -> Statements:
        """One function of the program."""
        return Statements(*self._printer.block(self._program.functions[name].outputs))
