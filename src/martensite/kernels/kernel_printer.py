"""The functions of a program as C statements, whatever the functions around them look like.

What follows from the parameters p alone is computed once, in `prepare`, and is c[i] from then on.
Every other function reads c and its inputs x, and says what its results are. A program that was
differentiated (`martensite.kernels.slopes`) has the derivatives of each array in another one, whose
name has a `d` before it: dp, dc, dx, dy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.kernels.graph import PARAMETER, SLOPE, VARYING, Expr
from martensite.kernels.printer import SLOPES, Dialect, Printer
from martensite.kernels.program import Function, Program
from martensite.kernels.slopes import slope_input


class Statements(NamedTuple):
    """A function in C, without what is around it."""

    lines: list[str]
    """Assignments of what it needs on the way."""
    results: list[str]
    """Results of the statements as expressions."""
    flags: list[bool]
    """Which of them are true or false, and no numbers."""


class KernelPrinter:
    """Prints the functions of a program one by one.

    Args:
        program: the functions.
        dialect: how operations are written.
        place: how a number of an array is written: name, then place.
        test: how a number is taken for a condition.
        kept: places of the parameters that p holds; all by default.
        moving: places of the parameters whose derivatives dp holds; None if the program was not
            differentiated.
    """

    def __init__(
        self,
        program: Program,
        dialect: Dialect,
        place: str = "{}[{}]",
        test: str = "({} != 0.0)",
        kept: Sequence[int] | None = None,
        moving: Sequence[int] | None = None,
    ) -> None:
        self.program, self.place, self.moving = program, place, moving
        self.printer = Printer(program.graph, dialect)
        kept = range(len(program.parameters)) if kept is None else kept
        self._share_inputs([f"p{i}" for i in kept], [place.format("p", k) for k in range(len(kept))])
        slopes = [program.graph.input(slope_input(f"p{i}"), PARAMETER | SLOPE) for i in moving or ()]
        self.printer.share(slopes, lambda k: place.format("dp", k))
        hoisted = program.hoisted_nodes
        self.prepare = self._print(hoisted)
        """Code that computes the constants; `list_places` gives the places of its results."""
        texts = [place.format(*one) for one in self.list_places("c", hoisted)]
        tests = [test.format(t) if f else t for t, f in zip(texts, self.prepare.flags, strict=True)]
        self.printer.share(hoisted, lambda i: tests[i])

    def print_function(self, function: Function, inputs: Sequence[str] | None = None) -> Statements:
        """Return a function of the program, with its inputs where they are told to be, by default in x."""
        every = range(len(function.inputs))
        self._share_inputs(function.inputs, inputs or [self.place.format("x", i) for i in every])
        if self.moving is not None:
            graph = self.program.graph
            nodes = [graph.input(slope_input(name), VARYING | SLOPE) for name in function.inputs]
            self.printer.share(nodes, lambda i: self.place.format("dx", i))
        return self._print(function.outputs)

    def list_places(self, array: str, nodes: Sequence[Expr]) -> list[tuple[str, int]]:
        """Return the array and place of each of some nodes: numbers and derivatives are counted apart."""
        counts = {array: 0, f"d{array}": 0}
        found: list[tuple[str, int]] = []
        for node in nodes:
            name = f"d{array}" if self.printer.kind(node.index) == SLOPES else array
            found.append((name, counts[name]))
            counts[name] += 1
        return found

    def _share_inputs(self, names: Sequence[str], texts: Sequence[str]) -> None:
        self.printer.share([self.program.graph.input(n, 0) for n in names], lambda i: texts[i])

    def _print(self, outputs: Sequence[Expr]) -> Statements:
        flags = [self.printer.is_flag(node.index) for node in outputs]
        return Statements(*self.printer.block(outputs), flags)
