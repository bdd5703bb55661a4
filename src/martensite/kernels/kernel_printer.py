"""Functions of a program as C statements, independent of their surrounding function declarations.

Values that depend on the parameters p alone are computed once, in `prepare`, and are then c[i]. Every other function
reads c and its inputs x, and returns its results. In a differentiated program (`martensite.kernels.slopes`), an array
with prefix `d` has the derivatives of each array: dp, dc, dx, dy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.kernels.graph import PARAMETER, SLOPE, VARYING, Expr
from martensite.kernels.printer import SLOPES, Dialect, Printer
from martensite.kernels.program import Function, Program
from martensite.kernels.slopes import slope_input


class Statements(NamedTuple):
    """Statements of a C function, without its declaration."""

    lines: list[str]
    """Assignments of intermediate values."""
    results: list[str]
    """Results of the statements as expressions."""
    flags: list[bool]
    """True for results that are flags, not numbers."""


class KernelPrinter:
    """Printer of the functions of a program.

    Args:
        program: functions to print.
        dialect: notation of operations.
        place: notation of an array element: name, then index.
        test: conversion of a number to a condition.
        kept: indices of the parameters in p, all by default.
        moving: indices of the parameters with derivatives in dp, None if the program was not differentiated.
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
        """Return a function of the program, with its inputs at the given places, by default in x."""
        every = range(len(function.inputs))
        self._share_inputs(function.inputs, inputs or [self.place.format("x", i) for i in every])
        if self.moving is not None:
            graph = self.program.graph
            nodes = [graph.input(slope_input(name), VARYING | SLOPE) for name in function.inputs]
            self.printer.share(nodes, lambda i: self.place.format("dx", i))
        return self._print(function.outputs)

    def list_places(self, array: str, nodes: Sequence[Expr]) -> list[tuple[str, int]]:
        """Return the array and index of each of some nodes; values and derivatives are counted separately."""
        counts = {array: 0, f"d{array}": 0}
        places: list[tuple[str, int]] = []
        for node in nodes:
            name = f"d{array}" if self.printer.kind(node.index) == SLOPES else array
            places.append((name, counts[name]))
            counts[name] += 1
        return places

    def _share_inputs(self, names: Sequence[str], texts: Sequence[str]) -> None:
        self.printer.share([self.program.graph.input(n, 0) for n in names], lambda i: texts[i])

    def _print(self, outputs: Sequence[Expr]) -> Statements:
        flags = [self.printer.is_flag(node.index) for node in outputs]
        return Statements(*self.printer.block(outputs), flags)
