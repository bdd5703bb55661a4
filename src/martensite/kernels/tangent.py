"""Exact derivatives of traced functions: a second graph beside the first, forward in its order.

For every node v = op(a, b) the derivatives in all wanted directions are one more node,
v' = ∂op/∂a a' + ∂op/∂b b', by the rules of dual numbers (`martensite.kernels.dual`). The
directions share all values: printed in C, values are numbers and derivatives short vectors.
What has no derivative costs nothing, and what is detached ends a chain.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from martensite.kernels.dual import Dual, DualNamespace
from martensite.kernels.graph import PARAMETER, SLOPE, VARYING, Expr, Graph, GraphNamespace
from martensite.kernels.program import Function, Program

ZERO = "ZERO"
"""Input that stands for no slope in any direction."""
TINY = 1e-300
"""Added to a divisor before its reciprocal, which changes none above 1e-284: smaller ones, such
as rates that underflow, would have an infinite one."""
_OPERATORS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "neg": operator.neg,
    "lt": operator.lt,
    "le": operator.le,
    "gt": operator.gt,
    "ge": operator.ge,
}


def slope_input(name: str) -> str:
    """Name of the input with the derivatives of another."""
    return f"d{name}"


def differentiate_program(
    program: Program, wrt: Sequence[int], states: Mapping[str, int], shown: Sequence[int]
) -> Program:
    """The functions of a program with their derivatives, over the same graph.

    Args:
        program: functions `init`, `step`, `observe`, …
        wrt: places of the parameters whose derivatives are given, as inputs `dp…`.
        states: for each wanted function, how many of its first inputs have derivatives.
        shown: which results of `observe` are wanted.

    Every function then returns its values, and after them one derivative for each.
    """
    twin = Program(program.graph, program.parameters)
    seeds = {f"p{i}": PARAMETER for i in wrt}
    for name, count in states.items():
        function = program.functions[name]
        moving = seeds | dict.fromkeys(function.inputs[:count], VARYING)
        walk = TangentWalk(program.graph, moving)
        places = shown if name == "observe" else range(len(function.outputs))
        pairs = [walk.pair(function.outputs[i].index) for i in places]
        values = tuple(value for value, _ in pairs)
        slopes = tuple(walk.zero if slope is None else slope for _, slope in pairs)
        twin.functions[name] = Function(name, function.inputs, values + slopes)
    return twin


class _Slopes(DualNamespace):
    """Dual numbers over the graph, whose missing tangents are a node of their own kind."""

    def __init__(self, graph: Graph) -> None:
        base: Any = GraphNamespace(graph)
        super().__init__(base)
        self.zero = graph.input(ZERO, SLOPE)


class _Level:
    """What is known inside one body of a loop, or outside of all."""

    def __init__(self, bit: int, known: dict[int, Any]) -> None:
        self.bit = bit
        self.known = known
        self.loops: dict[int, list[list[Any]]] = {}


class TangentWalk:
    """Re-reads nodes of a graph with the derivatives of some inputs."""

    def __init__(self, graph: Graph, moving: Mapping[str, int]) -> None:
        self._graph = graph
        self._duals = _Slopes(graph)
        self.zero: Expr = self._duals.zero
        known = {
            graph.input(name, depends).index: self._dual(
                graph.input(name, depends), graph.input(slope_input(name), depends | SLOPE)
            )
            for name, depends in moving.items()
        }
        self._levels = [_Level(0, known)]

    def pair(self, index: int) -> tuple[Expr, Expr | None]:
        """Value of a node, and its derivatives if it has any."""
        value, slope = self._duals.parts(self._read(index))
        return value, slope

    def _dual(self, value: Expr, slope: Expr | None) -> Any:
        return self._duals.pair(value, slope)

    def _level(self, index: int) -> _Level:
        """The innermost level that a node belongs to."""
        depends = self._graph.depends[index]
        return next(x for x in reversed(self._levels) if not x.bit or depends & x.bit)

    def _read(self, index: int) -> Any:
        """A node as a dual number, or bare if it has no derivative."""
        for needed in self._list_needed(index):
            level = self._level(needed)
            if needed not in level.known:
                level.known[needed] = self._simple(self._made(needed, level))
        return self._level(index).known[index]

    def _list_needed(self, index: int) -> list[int]:
        """The nodes to be read first, in the order in which they were made."""
        found: set[int] = set()
        stack = [index]
        while stack:
            index = stack.pop()
            if index in found or index in self._level(index).known:
                continue
            found.add(index)
            operation, arguments = self._graph.operations[index], self._graph.arguments[index]
            if operation == "implicit_root":
                stack.append(arguments[1])
            elif operation not in ("input", "constant", "detach"):
                stack += arguments
        return sorted(found)

    def _made(self, index: int, level: _Level) -> Any:
        graph = self._graph
        operation, args = graph.operations[index], graph.arguments[index]
        bare = Expr(graph, index)
        if operation in ("input", "constant", "detach"):
            return bare
        if operation == "implicit_root":
            _, slope = self._duals.parts(self._level(args[1]).known[args[1]])
            return self._dual(Expr(graph, args[0]), slope)
        if operation in ("each", "repeat"):
            read = self._each if operation == "each" else self._repeat
            level.loops[index] = read(index)
            return bare
        if operation in ("item", "result"):
            return self._take_result(index, level)
        read = [self._level(a).known[a] for a in args]
        if not any(isinstance(r, Dual) or r.index != a for r, a in zip(read, args, strict=True)):
            return bare
        if operation == "div":
            return self._divide_once(*read)
        rule = _OPERATORS.get(operation)
        return rule(*read) if rule else getattr(self._duals, operation)(*read)

    def _take_result(self, index: int, level: _Level) -> Any:
        """One result of a loop."""
        graph, detail = self._graph, self._graph.details[index]
        place, row = detail if graph.operations[index] == "item" else (detail, 0)
        return level.loops[graph.arguments[index][0]][place][row]

    def _divide_once(self, top: Any, bottom: Any) -> Any:
        """a/b with one division for all directions."""
        (a, da), (b, db) = self._duals.parts(top), self._duals.parts(bottom)
        ratio, share = a / b, 1.0 / (b + TINY)
        change = da
        if db is not None:
            change = -(db * ratio) if da is None else da - db * ratio
        return self._dual(ratio, None if change is None else change * share)

    def _simple(self, read: Any) -> Any:
        """Without a derivative that is 0 by construction."""
        if isinstance(read, Dual):
            slope = read.tangent
            if slope is None or slope.index == self.zero.index or self._vanishes(slope):
                return read.value
        return read

    def _vanishes(self, slope: Expr) -> bool:
        return self._graph.value_of(slope) == 0.0

    # ------------------------------------------------------------ loops

    def _each(self, index: int) -> list[list[Any]]:
        """A loop over rows: its results by place and row."""
        loop = self._graph.loops[index]
        columns = [[self._duals.parts(self._read(i)) for i in column] for column in loop.columns]
        moving = [any(slope is not None for _, slope in column) for column in columns]
        values = [[value for value, _ in column] for column in columns]
        slopes = [
            [self.zero if slope is None else slope for _, slope in column]
            for column, moves in zip(columns, moving, strict=True)
            if moves
        ]
        kept: list[bool] = []

        def body(*row: Expr) -> Sequence[Expr]:
            flat, kept[:] = self._inside(loop.bit, loop.row, row, moving, loop.outputs)
            return flat

        found = self._graph.loop(body, values, slopes)
        rest = iter(found[len(loop.outputs) :])
        rows = range(len(values[0]))
        return [
            [self._dual(v[k], s[k] if s else None) for k in rows]
            for v, s in ((found[i], next(rest) if has else None) for i, has in enumerate(kept))
        ]

    def _repeat(self, index: int) -> list[list[Any]]:
        """A loop over a state: its results by place, in rows of one."""
        loop, graph = self._graph.repeats[index], self._graph
        begin = [self._duals.parts(self._read(i)) for i in loop.begin]
        moving = [slope is not None for _, slope in begin]
        values = [value for value, _ in begin]

        def body(*state: Expr) -> Sequence[Expr]:
            flat, has = self._inside(loop.bit, loop.state, state, moving, loop.outputs)
            count = len(has)
            slopes = iter(flat[count:])
            every = [next(slopes) if h else self.zero for h in has]
            found[:] = has
            return [*flat[:count], *(s for s, m in zip(every, moving, strict=True) if m)]

        found: list[bool] = []
        while True:
            slopes = [
                self.zero if s is None else s for (_, s), m in zip(begin, moving, strict=True) if m
            ]
            results = graph.repeat(loop.turns, body, values, slopes, loop.stops)
            spread = [a or b for a, b in zip(moving, found, strict=True)]
            if spread == moving:
                break
            moving[:] = spread
        rest = iter(results[len(values) :])
        return [
            [self._dual(value, next(rest) if m else None)]
            for value, m in zip(results, moving, strict=False)
        ]

    def _inside(
        self,
        bit: int,
        inputs: Sequence[int],
        row: Sequence[Expr],
        moving: Sequence[bool],
        outputs: Iterable[int],
    ) -> tuple[list[Expr], list[bool]]:
        """Values, then slopes, of the results of a body; and which of them have slopes."""
        slopes = iter(row[len(inputs) :])
        known = {
            i: self._dual(value, next(slopes) if moves else None)
            for i, value, moves in zip(inputs, row, moving, strict=False)
        }
        self._levels.append(_Level(bit, known))
        try:
            pairs = [self.pair(index) for index in outputs]
        finally:
            self._levels.pop()
        has = [slope is not None for _, slope in pairs]
        return [*(value for value, _ in pairs), *(s for _, s in pairs if s is not None)], has
