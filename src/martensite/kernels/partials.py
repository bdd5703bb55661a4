"""Exact derivatives of traced values, one per variable on which each node depends, forwards or backwards.

Forwards (`compute_partials`) the tangent of a node is a row of derivatives. Backwards (`compute_gradient`), the adjoint
of a node is ā = Σ ȳ ∂y/∂a over its users y; one sweep costs a few evaluations for any number of variables. Both use
the rules of dual numbers: the factor of a tangent forwards is the factor of ȳ backwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from martensite.kernels.dual import Dual
from martensite.kernels.graph import FLAGS, Expr, Graph, GraphNamespace
from martensite.kernels.slopes import GraphDuals, TangentWalk

LOOPS = frozenset({"each", "item", "repeat", "result"})


class _Row:
    """Tangent as derivatives by variable, with the arithmetic of dual numbers."""

    __slots__ = ("row",)

    def __init__(self, row: dict[int, Any]) -> None:
        self.row = row

    def __add__(self, other: _Row) -> _Row:
        joined = dict(self.row)
        for i, slope in other.row.items():
            joined[i] = joined[i] + slope if i in joined else slope
        return _Row(joined)

    def __sub__(self, other: _Row) -> _Row:
        return self + (-other)

    def __neg__(self) -> _Row:
        return _Row({i: -slope for i, slope in self.row.items()})

    def __mul__(self, factor: Any) -> _Row:
        return _Row({i: slope * factor for i, slope in self.row.items()})


class _Choosing(GraphNamespace):
    """Graph operations in which a choice of tangents is a choice of their entries."""

    def where(self, flag: Any, yes: Any, no: Any) -> Any:
        if not (isinstance(yes, _Row) or isinstance(no, _Row)):
            return self.graph.apply("where", flag, yes, no)
        a, b = (x.row if isinstance(x, _Row) else {} for x in (yes, no))
        keys = [*a, *(i for i in b if i not in a)]
        return _Row({i: self.graph.apply("where", flag, a.get(i, 0.0), b.get(i, 0.0)) for i in keys})


class _PartialsWalk(TangentWalk):
    """Walk with rows as tangents; loops over values with tangents are unrolled."""

    ends = frozenset({"input", "constant"})
    follows_roots = True

    def _simple(self, read: Any) -> Any:
        if not isinstance(read, Dual):
            return read
        slopes = {i: s for i, s in read.tangent.row.items() if self._graph.value_of(s) != 0.0}
        return self._duals.pair(read.value, _Row(slopes) if slopes else None)

    def _each(self, index: int) -> list[list[Any]]:
        loop, result_rows = self._graph.loops[index], list[list[Any]]()
        state, *columns = ([self._read(i) for i in column] for column in (loop.begin, *loop.columns))
        for row in zip(*columns, strict=True):
            node_values = dict(zip((*loop.state, *loop.row), (*state, *row), strict=True))
            result_rows.append(self._write_body(loop.bit, node_values, loop.outputs))
            state = result_rows[-1][: len(state)]
        return [list(column) for column in zip(*result_rows, strict=True)]

    def _repeat(self, index: int) -> list[list[Any]]:
        """Keep a root search as a loop; its derivatives come from the following Newton step."""
        loop = self._graph.repeats[index]
        begin = [self._read(i) for i in loop.begin]

        def turn(*state: Any) -> list[Any]:
            node_values = dict(zip(loop.state, state, strict=True))
            return self._write_body(loop.bit, node_values, loop.outputs)

        def turn_values(*state: Any) -> list[Any]:
            return [self._duals.parts(one)[0] for one in turn(*state)]

        current_state = begin
        for _ in range(0 if loop.stops else loop.turns):
            current_state = turn(*current_state)
        if loop.stops or not any(isinstance(one, Dual) for one in current_state):
            values = [self._duals.parts(one)[0] for one in begin]
            current_state = self._graph.repeat(loop.turns, turn_values, values, loop.stops)
        return [[one] for one in current_state]


def compute_partials(values: Sequence[Expr], variables: Sequence[Expr]) -> tuple[list[Expr], list[dict[int, Expr]]]:
    """Return the traced values and their forward derivatives.

    Each value has a row, number of the variable -> derivative, without zeros.
    """
    graph = values[0].graph if values else None
    if graph is None:
        return [], []
    duals, one = GraphDuals(_Choosing(graph)), graph.constant(1.0)
    moving = {v.index: duals.pair(v, _Row({i: one})) for i, v in enumerate(variables)}
    walk = _PartialsWalk(graph, duals, moving)
    pairs = [walk.pair(value.index) for value in values]
    rows: list[Any] = [slopes for _, slopes in pairs]
    return [value for value, _ in pairs], [{} if row is None else row.row for row in rows]


def compute_gradient(value: Expr, variables: Sequence[Expr]) -> dict[int, Expr] | None:
    """Compute the gradient of one value backwards; None if a loop is on the path."""
    graph, places = value.graph, {v.index: i for i, v in enumerate(variables)}
    order = _list_dependent(graph, value.index, frozenset(places))
    if order is None:
        return None
    duals, moving = GraphDuals(GraphNamespace(graph)), frozenset(order)
    bars: dict[int, Any] = {value.index: graph.constant(1.0)} if order else {}
    gradient: dict[int, Expr] = {}
    for index in reversed(order):
        bar = bars[index]
        if index in places:
            gradient[places[index]] = bar
            continue
        arguments = [Expr(graph, i) for i in graph.arguments[index]]
        for k, argument in enumerate(graph.arguments[index]):
            if argument in moving:
                one = [*arguments[:k], duals.pair(arguments[k], bar), *arguments[k + 1 :]]
                _, share = duals.parts(duals.apply(graph.operations[index], one))
                if share is not None:
                    bars[argument] = bars[argument] + share if argument in bars else share
    return {i: slope for i, slope in gradient.items() if graph.value_of(slope) != 0.0}


def _list_dependent(graph: Graph, value: int, variables: frozenset[int]) -> list[int] | None:
    """Return the nodes between value and variables, in order of computation; None if they contain loops."""
    moving: set[int] = set()
    for index in sorted(graph.walk([value], partial(_list_arguments, graph))):
        if index in variables or any(a in moving for a in _list_arguments(graph, index)):
            moving.add(index)
    if any(graph.operations[index] in LOOPS for index in moving):
        return None
    return sorted(moving)


def _list_arguments(graph: Graph, index: int) -> tuple[int, ...]:
    """Return the differentiable arguments: no flags, no detached nodes, and the Newton step of a root."""
    operation, arguments = graph.operations[index], graph.arguments[index]
    if operation in ("input", "constant", "detach") or operation in FLAGS:
        return ()
    return arguments[1:] if operation in ("where", "implicit_root") else arguments
