"""Programs of traced kernels, printed and bound for a runtime.

A program has functions over named inputs. Values that depend on parameters alone are computed once, when the
parameters are bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from martensite.kernels import floats
from martensite.kernels.graph import PARAMETER, SLOPE, VARYING, Expr, Graph, GraphNamespace
from martensite.kernels.printer import FLOAT_DIALECT, Printer, parameter_nodes

FLOAT_GLOBALS = {
    "_sqrt": math.sqrt,
    "_exp": math.exp,
    "_log": math.log,
    "_sin": math.sin,
    "_cos": math.cos,
    "_tanh": math.tanh,
    "_erfcx": floats.erfcx,
    "_nearest": floats.nearest,
    "_power": floats.power,
}


@dataclass
class Function:
    """Traced function with the names of its inputs, and its outputs as nodes."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[Expr, ...]


@dataclass(eq=False)
class Program:
    """Functions of one graph over the same parameters.

    `parameters` are the names of the parameter inputs, in order.
    """

    graph: Graph = field(default_factory=Graph)
    parameters: list[str] = field(default_factory=list[str])
    functions: dict[str, Function] = field(default_factory=dict[str, Function])

    @property
    def xp(self) -> GraphNamespace:
        """Return the namespace in which kernels are traced into this program."""
        return GraphNamespace(self.graph)

    def parameter(self, name: str) -> Expr:
        """Declare a parameter input."""
        self.parameters.append(name)
        return self.graph.input(f"p{len(self.parameters) - 1}", PARAMETER)

    def add(self, name: str, inputs: Sequence[str], kernel: Callable[..., Sequence[Any]]) -> None:
        """Trace `kernel(xp, *inputs)`, which returns a flat sequence of numbers."""
        nodes = [self.graph.input(f"{name}_{i}", VARYING) for i in inputs]
        results = kernel(self.xp, *nodes)
        outputs = tuple(map(self.as_node, results))
        self.functions[name] = Function(name, tuple(f"{name}_{i}" for i in inputs), outputs)

    def as_node(self, result: Any) -> Expr:
        """Return the result of a kernel as a node; it may be a constant number."""
        return result if isinstance(result, Expr) else self.graph.constant(result)

    def needs(self, outputs: Sequence[Expr], inputs: Iterable[str]) -> bool:
        """Return whether outputs depend on any of the inputs, by full names."""
        return any(self.list_needed(outputs, inputs))

    def list_needed(self, outputs: Sequence[Expr], inputs: Iterable[str]) -> list[bool]:
        """Return whether outputs depend on each of the inputs, by full names."""
        reached = set(self.graph.walk([node.index for node in outputs], self.graph.children))
        return [self.graph.input(name, VARYING).index in reached for name in inputs]

    @cached_property
    def hoisted_nodes(self) -> list[Expr]:
        """Return the nodes computed once per set of parameters."""
        return parameter_nodes(self.graph, [node for f in self.functions.values() for node in f.outputs])

    @property
    def constants(self) -> int:
        """Return the length of the array of parameter-dependent constants, at least 1 for C."""
        return max(1, len(self.hoisted_nodes) - self._count_slopes())

    @property
    def constant_slopes(self) -> int:
        """Return the number of constants of the derivatives."""
        return max(1, self._count_slopes())

    def _count_slopes(self) -> int:
        return sum(bool(self.graph.depends[node.index] & SLOPE) for node in self.hoisted_nodes)

    @cached_property
    def bind_floats(self) -> Callable[..., Mapping[str, Callable[..., tuple[float, ...]]]]:
        """Return a function of the parameters that returns the program functions as plain Python over floats."""
        names: dict[str, Any] = dict(FLOAT_GLOBALS)
        exec(compile(self.float_source, "<traced kernel>", "exec"), names)
        return names["bind"]

    @property
    def float_source(self) -> str:
        """Return the Python source of `bind`, a function that returns the functions."""
        printer = Printer(self.graph, FLOAT_DIALECT)
        lines, values = printer.block(self.hoisted_nodes, "h")
        names = [f"c{i}" for i in range(len(values))]
        lines += [f"{name} = {value}" for name, value in zip(names, values, strict=True)]
        printer.share(self.hoisted_nodes, lambda i: f"c{i}")
        for function in self.functions.values():
            lines += _function_source(printer, function)
        members = ", ".join(f"{name!r}: {name}" for name in self.functions)
        lines.append(f"return {{{members}}}")
        arguments = ", ".join(f"p{i}" for i in range(len(self.parameters)))
        return f"def bind({arguments}):\n" + "".join(f"    {line}\n" for line in lines)


def _function_source(printer: Printer, function: Function) -> list[str]:
    body, outputs = printer.block(function.outputs)
    result = ", ".join(outputs) + ("," if len(outputs) == 1 else "")
    return [
        f"def {function.name}({', '.join(function.inputs)}):",
        *(f"    {line}" for line in body),
        f"    return ({result})",
    ]
