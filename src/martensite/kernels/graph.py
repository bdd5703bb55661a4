"""Expression graphs from traced kernels, without repeated expressions.

Equal expressions are one node, and constants are folded with the meaning of `floats`. Every node has its dependencies:
parameters only (computed once per run) or state and input. A body over rows (`each`) is traced once as a loop.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, count
from typing import Any

from martensite.base.errors import KernelError
from martensite.kernels import floats
from martensite.kernels.floats import expand_power
from martensite.kernels.graph_loops import GraphLoop, Repeat
from martensite.kernels.namespace import OPERATIONS
from martensite.kernels.traced_numbers import TracedNumber, make_kernel_error, make_operation_error

PARAMETER, VARYING, LOOP = 1, 2, 4
"""Bits of the dependencies of a node.

Nodes inside a loop body have the bit LOOP, or LOOP << 1 in a nested loop, and so on.
"""
SLOPE = 1 << 32
"""Additional dependency of a derivative (`martensite.kernels.slopes`)."""


FLAGS = frozenset({"lt", "le", "gt", "ge", "both", "either", "negate"})
"""Operations with true or false results."""
CONDITIONS = {"where": 1, "both": 2, "either": 2, "negate": 1}
"""Number of leading flag arguments of an operation; the others are numbers."""
UNTYPED = frozenset({"input", "constant", "each", "item", "repeat", "result"})
"""Operations without arguments, or with arguments of both types."""
CONDITION = "a condition is no number to compute with"
COMMUTATIVE = ("add", "mul", "both", "either")
"""Operations whose two arguments commute exactly."""


OPERATORS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "lt": operator.lt,
    "le": operator.le,
    "gt": operator.gt,
    "ge": operator.ge,
}


class Graph:
    """Nodes (operation, arguments) in order of creation; arguments come before their users."""

    def __init__(self) -> None:
        self.operations: list[str] = []
        self.arguments: list[tuple[Any, ...]] = []
        self.depends: list[int] = []
        self.details: list[Any] = []
        self.flags: set[int] = set()
        """Nodes that are flags, not numbers."""
        self.loops: dict[int, GraphLoop] = {}
        self.repeats: dict[int, Repeat] = {}
        self._depth = 0
        self._node_indices: dict[tuple[Any, ...], int] = {}

    def input(self, name: str, depends: int) -> Expr:
        """Return a named input."""
        return self._node("input", (name,), depends)

    def constant(self, value: float | bool) -> Expr:
        """Return a constant known while tracing."""
        try:
            value = value if isinstance(value, bool) else float(value)
        except (TypeError, ValueError) as error:
            if isinstance(error, KernelError):
                raise
            reason = f"a kernel computes with numbers, but {value!r} is none"
            raise make_kernel_error(reason, "a number, and a `return` if one is missing") from None
        return self._node("constant", (value,), 0, type(value))

    def apply(self, operation: str, *values: Any) -> Expr:
        """Return a new node, or an equal or simpler one that exists."""
        nodes = [self._expr(v) for v in values]
        simple = self._simplify(operation, nodes)
        if simple is not None:
            return simple
        indices = tuple(node.index for node in nodes)
        if operation in COMMUTATIVE and (operation, *indices[::-1], None, None) in self._node_indices:
            indices = indices[::-1]
        return self._node(operation, indices, self._join_dependencies(indices))

    def loop(
        self, body: Callable[..., Sequence[Any]], begin: Sequence[Any], columns: Sequence[Sequence[Any]]
    ) -> tuple[list[Expr], ...]:
        """Trace a body over rows, which continues the state `begin`; equal loops are one."""
        first = tuple(self._expr(value).index for value in begin)
        table = tuple(tuple(self._expr(item).index for item in column) for column in columns)
        bit, results, (state, row) = self._body(body, s=[(i,) for i in first], g=table)
        inside = [r for k, r in enumerate(results) if k < len(first) or self.depends[r.index] & bit]
        outputs = tuple(r.index for r in inside)
        reached, outside = self._reach(outputs, bit)
        read = (column for column, one in zip(table, row, strict=True) if one in reached)
        needed = tuple(dict.fromkeys((*first, *chain(*read), *outside)))
        depends = self._loop_depends(needed)
        node = self._node("each", needed, depends, (table, first, outputs)).index
        self.loops[node] = GraphLoop(table, first, state, row, outputs, tuple(outside), bit)
        places = iter(range(len(outputs)))
        return tuple(self._list_rows(node, r, places, state[k : k + 1]) for k, r in enumerate(results))

    def _list_rows(self, node: int, result: Expr, places: Iterator[int], state: Sequence[int]) -> list[Expr]:
        """Return the column of a result of a loop; results that depend on no row are equal in all."""
        loop = self.loops[node]
        if not (state or self.depends[result.index] & loop.bit):
            return [result for _ in loop.columns[0]]
        place, own = next(places), self._like(self.depends[node], (*state, result.index)[0])
        return [self._node("item", (node,), own, (place, row)) for row in range(len(loop.columns[0]))]

    def repeat(
        self, turns: int, body: Callable[..., Sequence[Any]], state: Sequence[Any], stops: bool = False
    ) -> list[Expr]:
        """Trace one iteration of a loop over a state."""
        begin = tuple(self._expr(value).index for value in state)
        bit, results, (inputs,) = self._body(body, r=[(i,) for i in begin])
        outputs = tuple(r.index for r in results)
        outside = self._reach(outputs, bit)[1]
        needed = tuple(dict.fromkeys((*begin, *outside)))
        depends = self._loop_depends(needed)
        node = self._node("repeat", needed, depends, (turns, stops, begin, outputs)).index
        self.repeats[node] = Repeat(turns, stops, begin, inputs, outputs, tuple(outside), bit)
        return [
            self._node("result", (node,), self._like(depends, input_), place) for place, input_ in enumerate(inputs)
        ]

    def _like(self, depends: int, index: int) -> int:
        """Return `depends` with the derivative bit of a node."""
        return (depends & ~SLOPE) | (self.depends[index] & SLOPE)

    def _body(
        self, body: Callable[..., Sequence[Any]], **groups: Sequence[Sequence[int]]
    ) -> tuple[int, list[Expr], list[tuple[int, ...]]]:
        """Trace the body of a loop over groups of columns of nodes, and return its bit, results and inputs by group.

        Inputs have the letter of their group. Numbers and derivatives are counted separately, so that the body of a
        loop keeps its inputs when derivatives follow.
        """
        bit, inputs = LOOP << self._depth, list[tuple[Expr, ...]]()
        for letter, columns in groups.items():
            counts, name = {0: count(), SLOPE: count()}, letter * (self._depth + 1)
            slopes = [self._join_dependencies(column) & SLOPE for column in columns]
            names = [f"{'d' if s else ''}{name}{next(counts[s])}" for s in slopes]
            inputs.append(tuple(self.input(n, bit | VARYING | s) for n, s in zip(names, slopes, strict=True)))
        self._depth += 1
        try:
            results = [self._expr(result) for result in body(*chain(*inputs))]
        finally:
            self._depth -= 1
        return bit, results, [tuple(i.index for i in group) for group in inputs]

    def _loop_depends(self, needed: Sequence[int]) -> int:
        """Return the dependencies of a loop on these nodes: the loops around it, and VARYING."""
        return VARYING | (self._join_dependencies(needed) & ~PARAMETER)

    def _reach(self, outputs: Sequence[int], bit: int) -> tuple[set[int], list[int]]:
        """Return the nodes in the body of a loop that it uses, and the nodes outside."""

        def below(index: int) -> tuple[int, ...]:
            return self.children(index) if self.depends[index] & bit else ()

        reached = set(self.walk(outputs, below))
        return reached, sorted(index for index in reached if not self.depends[index] & bit)

    def _join_dependencies(self, indices: Iterable[int]) -> int:
        depends = 0
        for index in indices:
            depends |= self.depends[index]
        return depends

    def _expr(self, value: Any) -> Expr:
        return value if isinstance(value, Expr) else self.constant(value)

    def children(self, index: int) -> tuple[int, ...]:
        """Return the operands of a node, without the derivatives of a root."""
        operation, arguments = self.operations[index], self.arguments[index]
        if operation in ("input", "constant"):
            return ()
        return arguments[:1] if operation == "implicit_root" else arguments

    def walk(self, start: Iterable[int], below: Callable[[int], Iterable[int]]) -> Iterator[int]:
        """Yield some nodes and all their descendants, each once; `below` returns the children."""
        earlier_nodes, left = set[int](), list(start)
        while left:
            index = left.pop()
            if index not in earlier_nodes:
                earlier_nodes.add(index)
                yield index
                left += below(index)

    def value_of(self, node: Expr) -> float | bool | None:
        """Return the value of a constant node; otherwise None."""
        i = node.index
        return self.arguments[i][0] if self.operations[i] == "constant" else None

    def _node(self, operation: str, args: tuple[Any, ...], depends: int, extra: Any = None) -> Expr:
        key = (operation, *args, extra, repr(args[0]) if operation == "constant" else None)
        index = self._node_indices.get(key)
        if index is None:
            flag = self._is_flag(operation, args)
            index = self._node_indices[key] = len(self.operations)
            self.operations.append(operation)
            self.arguments.append(args)
            self.depends.append(depends)
            self.details.append(extra)
            if flag:
                self.flags.add(index)
        return Expr(self, index)

    def _is_flag(self, operation: str, args: tuple[Any, ...]) -> bool:
        """Return whether a new node is a flag.

        Raises:
            KernelError: flags and numbers are mixed. Floats accept both, but in C a vector of flags has another type.
        """
        if operation in CONDITIONS:
            return self._is_choice_of_flags(operation, args)
        if operation in UNTYPED:
            return operation == "constant" and isinstance(args[0], bool)
        if not self.flags.isdisjoint(args):
            raise make_kernel_error(CONDITION, "`xp.where(condition, a, 0.0)`")
        return operation in FLAGS

    def _is_choice_of_flags(self, operation: str, args: tuple[Any, ...]) -> bool:
        """Return whether a new node is a flag, for operations with conditions."""
        count = CONDITIONS[operation]
        chosen = self.flags.intersection(args[count:])
        if not self.flags.issuperset(args[:count]):
            raise make_kernel_error("a number of a kernel is not true or false", "a comparison: `x > 0.0`")
        if chosen and not self.flags.issuperset(args):
            raise make_kernel_error(CONDITION, "`xp.where(condition, a, 0.0)`")
        return bool(chosen) or operation in FLAGS

    def _simplify(self, operation: str, nodes: list[Expr]) -> Expr | None:
        constants = [self.value_of(node) for node in nodes]
        if operation == "where":
            return self._simplify_where(nodes, constants)
        if constants and None not in constants:
            fold = OPERATORS.get(operation) or getattr(floats, operation)
            return self.constant(fold(*constants))
        if operation in ("add", "sub", "mul", "div"):
            simple = _apply_identities(operation, nodes, constants)
            return self._signs(operation, nodes, constants) if simple is None else simple
        if operation == "implicit_root" and constants[0] is not None:
            return nodes[0]
        if operation in ("both", "either") and (constants[0] is not None or constants[1] is not None):
            flag, other = (constants[0], nodes[1]) if constants[0] is not None else (constants[1], nodes[0])
            absorbing = operation == "either"
            return self.constant(absorbing) if flag is absorbing else other
        return None

    def _signs(self, operation: str, nodes: list[Expr], constants: list[Any]) -> Expr | None:
        """Return the rules for minus signs, which are also exact."""
        a, b = nodes
        if operation == "mul" and -1.0 in constants:
            return -b if constants[0] == -1.0 else -a
        first, last = (self._find_negated(node) for node in nodes)
        if operation == "add" and (first is not None or last is not None):
            return a - last if last is not None else b - first
        return a + last if operation == "sub" and last is not None else None

    def _find_negated(self, node: Expr) -> Expr | None:
        """Return the operand of a negative node; otherwise None."""
        if self.operations[node.index] != "neg":
            return None
        return Expr(self, self.arguments[node.index][0])

    def _simplify_where(self, nodes: list[Expr], constants: list[Any]) -> Expr | None:
        if constants[0] is not None:
            return nodes[1] if constants[0] else nodes[2]
        return nodes[1] if nodes[1].index == nodes[2].index else None


def _apply_identities(operation: str, nodes: list[Expr], constants: list[Any]) -> Expr | None:
    """Return the rules that are exact in floating point for finite numbers."""
    a, b = nodes
    if operation == "add":
        return b if constants[0] == 0.0 else a if constants[1] == 0.0 else None
    if operation == "sub":
        if a.index == b.index:
            return a.graph.constant(0.0)
        return a if constants[1] == 0.0 else -b if constants[0] == 0.0 else None
    if operation == "mul":
        if constants[0] == 0.0 or constants[1] == 0.0:
            return a.graph.constant(0.0)
        return b if constants[0] == 1.0 else a if constants[1] == 1.0 else None
    if constants[0] == 0.0:
        return a.graph.constant(0.0)
    return a if constants[1] == 1.0 else None


def _write_operator(operation: str, reflected: str) -> Callable[..., Any]:
    """Return an operator method of nodes that defers to a richer operand (a dual number, an array)."""

    def apply(a: Expr, b: Any) -> Any:
        if isinstance(b, Expr | float | int):
            return a.graph.apply(operation, a, b)
        if getattr(b, "shape", None) == ():  # a NumPy number
            return a.graph.apply(operation, a, b.item())
        answer = getattr(b, reflected, None)
        return a.graph.apply(operation, a, b) if answer is None else answer(a)

    return apply


def _write_reflected(operation: str) -> Callable[..., Any]:
    def apply(b: Expr, a: Any) -> Expr:
        return b.graph.apply(operation, a, b)

    return apply


class Expr(TracedNumber):
    """Node of a graph; operators build further nodes."""

    __slots__ = ("graph", "index")

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph = graph
        self.index = index

    __add__, __radd__ = _write_operator("add", "__radd__"), _write_reflected("add")
    __sub__, __rsub__ = _write_operator("sub", "__rsub__"), _write_reflected("sub")
    __mul__, __rmul__ = _write_operator("mul", "__rmul__"), _write_reflected("mul")
    __truediv__, __rtruediv__ = _write_operator("div", "__rtruediv__"), _write_reflected("div")
    __lt__, __le__ = _write_operator("lt", "__gt__"), _write_operator("le", "__ge__")
    __gt__, __ge__ = _write_operator("gt", "__lt__"), _write_operator("ge", "__le__")

    def __neg__(self) -> Expr:
        return self.graph.apply("neg", self)


class GraphNamespace:
    """Kernel operations as nodes of one graph."""

    level = 0
    """Level of numbers that are not dual."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph

    def __getattr__(self, operation: str) -> Any:
        if operation not in OPERATIONS:
            raise make_operation_error(operation)

        def build(*values: Any) -> Expr:
            return self.graph.apply(operation, *values)

        setattr(self, operation, build)
        return build

    def power(self, base: Any, exponent: Any) -> Any:
        """Return a power as one operation; an `int` is multiplied out."""
        if isinstance(exponent, int):
            return expand_power(base, exponent)
        return self.graph.apply("power", base, exponent)

    def each(self, body: Callable[..., Sequence[Any]], *columns: Sequence[Any]) -> tuple[list[Expr], ...]:
        """Add one loop over the rows of the columns."""
        return self.graph.loop(body, (), columns)

    def scan(
        self, body: Callable[..., Sequence[Any]], begin: Sequence[Any], *columns: Sequence[Any]
    ) -> tuple[list[Expr], ...]:
        """Add one loop over the rows of the columns, with a state from row to row."""
        return self.graph.loop(body, begin, columns)

    def repeat(self, count: int, body: Callable[..., Sequence[Any]], *state: Any) -> list[Expr]:
        """Add one loop over a state."""
        return self.graph.repeat(count, body, state)

    def iterate(self, most: int, body: Callable[..., Sequence[Any]], *state: Any) -> list[Expr]:
        """Add one loop over a state that ends at a first variable not above 0."""
        return self.graph.repeat(most, body, state, stops=True)

    def clip(self, x: Any, low: Any, high: Any) -> Any:
        """Return `x` limited to [low, high]."""
        return self.graph.apply("minimum", self.graph.apply("maximum", x, low), high)
