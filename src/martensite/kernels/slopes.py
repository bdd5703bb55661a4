"""Exact derivatives of traced functions along directions, as a second graph.

Each node v = op(a, b) has the derivative v' = ∂op/∂a a' + ∂op/∂b b' as a further node, by the rules of dual numbers
(`martensite.kernels.dual`). In `differentiate_program` derivatives of all directions are short vectors in C, and values
are shared scalars. Nodes without derivatives cost nothing, and detached nodes end a chain. Derivatives by variable, and
gradients, are in `martensite.kernels.partials`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from martensite.kernels.dual import Dual, DualNamespace
from martensite.kernels.graph import OPERATORS, PARAMETER, SLOPE, VARYING, Expr, Graph
from martensite.kernels.program import Function, Program

ZERO = "ZERO"
"""Input that represents a zero derivative in all directions."""
TINY = 1e-300
"""Constant added to a divisor before its reciprocal, without effect above 1e-284.

It keeps reciprocals of underflowing rates finite.
"""


def slope_input(name: str) -> str:
    """Return the name of the input with the derivatives of another input."""
    return f"d{name}"


def differentiate_program(
    program: Program, wrt: Sequence[int], states: Mapping[str, int], outputs: Sequence[int]
) -> Program:
    """Return the functions of a program (`init`, `step`, `observe`, …) with derivatives, over the same graph.

    Inputs `dp…` are the derivatives of the parameters at the places `wrt`. `states` gives the number of leading inputs
    with derivatives for each function, and `outputs` the wanted results of `observe`. Each function returns its values,
    then one derivative per value.
    """
    twin = Program(program.graph, program.parameters)
    duals = GraphDuals(program.xp, program.graph.input(ZERO, SLOPE))
    seeds = {f"p{i}": PARAMETER for i in wrt}
    for name, count in states.items():
        function = program.functions[name]
        moving = seeds | dict.fromkeys(function.inputs[:count], VARYING)
        walk = TangentWalk(program.graph, duals, _seed_inputs(program.graph, duals, moving))
        places = outputs if name == "observe" else range(len(function.outputs))
        pairs = [walk.pair(function.outputs[i].index) for i in places]
        values = tuple(value for value, _ in pairs)
        slopes = tuple(duals.fill(slope) for _, slope in pairs)
        twin.functions[name] = Function(name, function.inputs, values + slopes)
    return twin


def differentiate_results(
    program: Program, name: str, places: Sequence[int], inputs: Sequence[str]
) -> list[list[Expr]]:
    """Differentiate results of a function with respect to inputs, by full names: one row per result.

    The derivatives are scalar nodes of the same graph, which every runtime can print.
    """
    graph = program.graph
    outputs = [program.functions[name].outputs[i] for i in places]
    duals = GraphDuals(program.xp, graph.constant(0.0))
    columns: list[list[Expr]] = []
    for wanted in inputs:
        node = graph.input(wanted, VARYING)
        walk = TangentWalk(graph, duals, {node.index: duals.pair(node, program.as_node(1.0))})
        columns.append([duals.fill(walk.pair(one.index)[1]) for one in outputs])
    return [list(row) for row in zip(*columns, strict=True)]


def _seed_inputs(graph: Graph, duals: GraphDuals, moving: Mapping[str, int]) -> dict[int, Any]:
    """Return the inputs and their dependents as dual numbers with inputs as tangents."""
    return {
        graph.input(name, depends).index: duals.pair(
            graph.input(name, depends), graph.input(slope_input(name), depends | SLOPE)
        )
        for name, depends in moving.items()
    }


class GraphDuals(DualNamespace):
    """Dual numbers over a graph; a choice uses `zero` for a missing tangent."""

    def __init__(self, base: Any, zero: Any = 0.0) -> None:
        super().__init__(base)
        self.zero = zero

    def apply(self, operation: str, arguments: Sequence[Any]) -> Any:
        """Return the result of a graph operation, with a tangent if an argument has one."""
        if operation == "div":
            return self._divide_once(*arguments)
        rule = OPERATORS.get(operation)
        return rule(*arguments) if rule else getattr(self, operation)(*arguments)

    def _divide_once(self, top: Any, bottom: Any) -> Any:
        """a/b with one division for all directions."""
        (a, da), (b, db) = self.parts(top), self.parts(bottom)
        ratio, share = a / b, 1.0 / (b + TINY)
        change = da
        if db is not None:
            change = -(db * ratio) if da is None else da - db * ratio
        return self.pair(ratio, None if change is None else change * share)


class _Level:
    """Known derivatives inside one loop body, or outside all loops."""

    def __init__(self, bit: int, node_values: dict[int, Any]) -> None:
        self.bit = bit
        self.node_values = node_values
        self.loops: dict[int, Sequence[Sequence[Any]]] = {}


class TangentWalk:
    """Re-evaluation of graph nodes with the derivatives of inputs."""

    ends = frozenset({"input", "constant", "detach"})
    """Operations that are copied unchanged."""
    follows_roots = False
    """True to re-evaluate roots; their derivatives always come from their Newton step."""

    def __init__(self, graph: Graph, duals: GraphDuals, moving: Mapping[int, Any]) -> None:
        """Prepare the walk from a graph, its dual numbers, and the nodes with derivatives."""
        self._graph, self._duals = graph, duals
        self._levels = [_Level(0, dict(moving))]

    def pair(self, index: int) -> tuple[Expr, Expr | None]:
        """Return the value of a node, and its derivatives if there are any."""
        value, slope = self._duals.parts(self._read(index))
        return value, slope

    def _level(self, index: int) -> _Level:
        """Return the innermost level of a node."""
        depends = self._graph.depends[index]
        return next(x for x in reversed(self._levels) if not x.bit or depends & x.bit)

    def _read(self, index: int) -> Any:
        """Return a node as a dual number, or unchanged without derivatives."""
        for needed in self._list_needed(index):
            level = self._level(needed)
            if needed not in level.node_values:
                level.node_values[needed] = self._simple(self._differentiate_node(needed, level))
        return self._level(index).node_values[index]

    def _list_needed(self, index: int) -> list[int]:
        """Return the prerequisite nodes, in order of creation."""
        nodes: set[int] = set()
        stack = [index]
        while stack:
            index = stack.pop()
            if index in nodes or index in self._level(index).node_values:
                continue
            nodes.add(index)
            operation, arguments = self._graph.operations[index], self._graph.arguments[index]
            if operation == "implicit_root" and not self.follows_roots:
                stack.append(arguments[1])
            elif operation not in self.ends:
                stack += arguments
        return sorted(nodes)

    def _differentiate_node(self, index: int, level: _Level) -> Any:
        graph = self._graph
        operation, args = graph.operations[index], graph.arguments[index]
        bare = Expr(graph, index)
        if operation in self.ends:
            return bare
        if operation == "implicit_root" and not self.follows_roots:
            _, slope = self._duals.parts(self._level(args[1]).node_values[args[1]])
            return self._duals.pair(Expr(graph, args[0]), slope)
        if operation in ("each", "repeat"):
            read = self._each if operation == "each" else self._repeat
            level.loops[index] = read(index)
            return bare
        if operation in ("item", "result"):
            return self._take_result(index, level)
        read = [self._level(a).node_values[a] for a in args]
        if not any(isinstance(r, Dual) or r.index != a for r, a in zip(read, args, strict=True)):
            return bare
        return self._duals.apply(operation, read)

    def _take_result(self, index: int, level: _Level) -> Any:
        graph, detail = self._graph, self._graph.details[index]
        place, row = detail if graph.operations[index] == "item" else (detail, 0)
        return level.loops[graph.arguments[index][0]][place][row]

    def _simple(self, read: Any) -> Any:
        """Return a dual number without a derivative that is 0 by construction."""
        if isinstance(read, Dual):
            slope = read.tangent
            if slope is None or slope.index == self._duals.zero.index:
                return read.value
            if self._graph.value_of(slope) == 0.0:
                return read.value
        return read

    # ------------------------------------------------------------ loops

    def _each(self, index: int) -> Sequence[Sequence[Any]]:
        """Return the results of a loop over rows, by place and row."""
        loop = self._graph.loops[index]

        def body(*numbers: Any) -> list[Any]:
            node_values = dict(zip((*loop.state, *loop.row), numbers, strict=True))
            return self._write_body(loop.bit, node_values, loop.outputs)

        begin, *columns = ([self._read(i) for i in column] for column in (loop.begin, *loop.columns))
        return self._duals.scan(body, begin, *columns)

    def _repeat(self, index: int) -> Sequence[Sequence[Any]]:
        """Return the results of a loop over a state, by place, in rows of one."""
        loop, duals = self._graph.repeats[index], self._duals
        begin = [duals.parts(self._read(i)) for i in loop.begin]

        def trace(moving: list[bool]) -> tuple[list[Expr], list[bool]]:
            flags = list[bool]()

            def body(*numbers: Expr) -> list[Any]:
                node_values = dict(zip(loop.state, duals.join(numbers, moving), strict=True))
                pairs = [duals.parts(one) for one in self._write_body(loop.bit, node_values, loop.outputs)]
                flags[:] = duals.list_moving(pairs, moving)
                return duals.split(pairs, flags)

            return self._graph.repeat(loop.turns, body, duals.split(begin, moving), loop.stops), flags

        results, moving = duals.spread(begin, trace)
        return [[one] for one in duals.join(results, moving)]

    def _write_body(self, bit: int, node_values: dict[int, Any], outputs: Iterable[int]) -> list[Any]:
        self._levels.append(_Level(bit, node_values))
        try:
            return [self._read(index) for index in outputs]
        finally:
            self._levels.pop()
