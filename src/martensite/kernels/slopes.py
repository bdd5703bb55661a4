"""Exact derivatives of traced functions: a second graph beside the first, in either direction.

Forwards, for every node v = op(a, b) the derivatives in all wanted directions are one more node,
v' = ∂op/∂a a' + ∂op/∂b b'. The directions share all values: printed in C, values are numbers and
derivatives short vectors (`differentiate_program`), or a node has a derivative for each variable
that it depends on and none for the others (`compute_partials`). Backwards, every node hands on what
the value changes by with it, ā = Σ over the users y of a: ȳ ∂y/∂a (`compute_gradient`): one sweep
costs a few times the value, however many variables there are.

All three read the rules of dual numbers (`martensite.kernels.dual`). These hold both ways: what the
tangent of one argument is multiplied by on the way ahead, ȳ is multiplied by on the way back. What
has no derivative costs nothing, and what is detached ends a chain.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from martensite.kernels.dual import Dual, DualNamespace
from martensite.kernels.graph import FLAGS, OPERATORS, PARAMETER, SLOPE, VARYING, Expr, Graph, GraphNamespace
from martensite.kernels.program import Function, Program

ZERO = "ZERO"
"""Input that stands for no slope in any direction."""
LOOPS = frozenset({"each", "item", "repeat", "result"})
TINY = 1e-300
"""Added to a divisor before its reciprocal, which changes none above 1e-284: smaller ones, such
as rates that underflow, would have an infinite one."""


def slope_input(name: str) -> str:
    """Return the name of the input with the derivatives of another."""
    return f"d{name}"


def differentiate_program(
    program: Program, wrt: Sequence[int], states: Mapping[str, int], shown: Sequence[int]
) -> Program:
    """Return the functions of a program (`init`, `step`, `observe`, …) with their derivatives, over the same graph.

    Derivatives of the parameters at the places `wrt` are given, as inputs `dp…`; `states` says for each wanted function
    how many of its first inputs have derivatives, `shown` which results of `observe` are wanted. Every function then
    returns its values, and after them one derivative for each.
    """
    twin = Program(program.graph, program.parameters)
    duals = _Slopes(program.xp, program.graph.input(ZERO, SLOPE))
    seeds = {f"p{i}": PARAMETER for i in wrt}
    for name, count in states.items():
        function = program.functions[name]
        moving = seeds | dict.fromkeys(function.inputs[:count], VARYING)
        walk = TangentWalk(program.graph, duals, _seed_inputs(program.graph, duals, moving))
        places = shown if name == "observe" else range(len(function.outputs))
        pairs = [walk.pair(function.outputs[i].index) for i in places]
        values = tuple(value for value, _ in pairs)
        slopes = tuple(duals.zero if slope is None else slope for _, slope in pairs)
        twin.functions[name] = Function(name, function.inputs, values + slopes)
    return twin


def differentiate_results(
    program: Program, name: str, places: Sequence[int], inputs: Sequence[str]
) -> list[list[Expr]]:
    """Differentiate some results of a function by some inputs, by their full names: a row for each result.

    They are plain numbers of the same graph, which every runtime prints as it prints values.
    """
    rows = (differentiate_along(program, name, places, {wanted: 1.0}) for wanted in inputs)
    return [list(row) for row in zip(*rows, strict=True)]


def differentiate_along(
    program: Program, name: str, places: Sequence[int], moving: Mapping[str, Expr | float]
) -> list[Expr]:
    """Differentiate in one direction, in which some inputs or parameters (`p3`) move: each by a node or a number."""
    graph = program.graph
    duals = _Slopes(program.xp, graph.constant(0.0))
    nodes = [graph.input(one, VARYING) for one in moving]
    known = {n.index: duals.pair(n, program.as_node(s)) for n, s in zip(nodes, moving.values(), strict=True)}
    walk = TangentWalk(graph, duals, known)
    slopes = [walk.pair(program.functions[name].outputs[i].index)[1] for i in places]
    return [duals.zero if slope is None else slope for slope in slopes]


def _seed_inputs(graph: Graph, duals: _Slopes, moving: Mapping[str, int]) -> dict[int, Any]:
    """Return the inputs, with what they depend on, as dual numbers whose tangents are inputs too."""
    return {
        graph.input(name, depends).index: duals.pair(
            graph.input(name, depends), graph.input(slope_input(name), depends | SLOPE)
        )
        for name, depends in moving.items()
    }


class _Slopes(DualNamespace):
    """Dual numbers over a graph; a choice needs a tangent where there is none: the `zero`."""

    def __init__(self, base: Any, zero: Any = 0.0) -> None:
        super().__init__(base)
        self.zero = zero

    def apply(self, operation: str, arguments: Sequence[Any]) -> Any:
        """Return the result of an operation of the graph, with its tangent if an argument has one."""
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


# ---------------------------------------------------------------- forwards


class _Level:
    """Known derivatives inside one body of a loop, or outside of all."""

    def __init__(self, bit: int, known: dict[int, Any]) -> None:
        self.bit = bit
        self.known = known
        self.loops: dict[int, list[list[Any]]] = {}


class TangentWalk:
    """Re-reads nodes of a graph with the derivatives of some inputs."""

    ends = frozenset({"input", "constant", "detach"})
    """Operations that are taken as they are."""
    follows_roots = False
    """True if a root is read again; its derivatives always come from its Newton step."""

    def __init__(self, graph: Graph, duals: _Slopes, moving: Mapping[int, Any]) -> None:
        """Take a graph, the dual numbers made of it, and of its nodes those that have derivatives."""
        self._graph, self._duals = graph, duals
        self._levels = [_Level(0, dict(moving))]

    def pair(self, index: int) -> tuple[Expr, Expr | None]:
        """Return the value of a node, and its derivatives if it has any."""
        value, slope = self._duals.parts(self._read(index))
        return value, slope

    def _level(self, index: int) -> _Level:
        """Return the innermost level that a node belongs to."""
        depends = self._graph.depends[index]
        return next(x for x in reversed(self._levels) if not x.bit or depends & x.bit)

    def _read(self, index: int) -> Any:
        """Return a node as a dual number, or bare if it has no derivative."""
        for needed in self._list_needed(index):
            level = self._level(needed)
            if needed not in level.known:
                level.known[needed] = self._simple(self._made(needed, level))
        return self._level(index).known[index]

    def _list_needed(self, index: int) -> list[int]:
        """Return the nodes to be read first, in the order in which they were made."""
        found: set[int] = set()
        stack = [index]
        while stack:
            index = stack.pop()
            if index in found or index in self._level(index).known:
                continue
            found.add(index)
            operation, arguments = self._graph.operations[index], self._graph.arguments[index]
            if operation == "implicit_root" and not self.follows_roots:
                stack.append(arguments[1])
            elif operation not in self.ends:
                stack += arguments
        return sorted(found)

    def _made(self, index: int, level: _Level) -> Any:
        graph = self._graph
        operation, args = graph.operations[index], graph.arguments[index]
        bare = Expr(graph, index)
        if operation in self.ends:
            return bare
        if operation == "implicit_root" and not self.follows_roots:
            _, slope = self._duals.parts(self._level(args[1]).known[args[1]])
            return self._duals.pair(Expr(graph, args[0]), slope)
        if operation in ("each", "repeat"):
            read = self._each if operation == "each" else self._repeat
            level.loops[index] = read(index)
            return bare
        if operation in ("item", "result"):
            return self._take_result(index, level)
        read = [self._level(a).known[a] for a in args]
        if not any(isinstance(r, Dual) or r.index != a for r, a in zip(read, args, strict=True)):
            return bare
        return self._duals.apply(operation, read)

    def _take_result(self, index: int, level: _Level) -> Any:
        graph, detail = self._graph, self._graph.details[index]
        place, row = detail if graph.operations[index] == "item" else (detail, 0)
        return level.loops[graph.arguments[index][0]][place][row]

    def _simple(self, read: Any) -> Any:
        """Without a derivative that is 0 by construction."""
        if isinstance(read, Dual):
            slope = read.tangent
            if slope is None or slope.index == self._duals.zero.index:
                return read.value
            if self._graph.value_of(slope) == 0.0:
                return read.value
        return read

    # ------------------------------------------------------------ loops

    def _each(self, index: int) -> list[list[Any]]:
        """Return a loop over rows: its results by place and row."""
        loop = self._graph.loops[index]
        columns = [[self._duals.parts(self._read(i)) for i in column] for column in loop.columns]
        moving = [any(slope is not None for _, slope in column) for column in columns]
        values = [[value for value, _ in column] for column in columns]
        slopes = [
            [self._duals.zero if slope is None else slope for _, slope in column]
            for column, moves in zip(columns, moving, strict=True)
            if moves
        ]
        kept: list[bool] = []

        def body(*row: Expr) -> Sequence[Expr]:
            flat, kept[:] = self._inside(loop.bit, loop.row, row, moving, loop.outputs)
            return flat

        found = self._graph.loop(body, *self._part(values, slopes))
        rest = iter(found[len(loop.outputs) :])
        rows = range(len(values[0]))
        return [
            [self._duals.pair(v[k], s[k] if s else None) for k in rows]
            for v, s in ((found[i], next(rest) if has else None) for i, has in enumerate(kept))
        ]

    def _repeat(self, index: int) -> list[list[Any]]:
        """Return a loop over a state: its results by place, in rows of one."""
        loop, graph = self._graph.repeats[index], self._graph
        begin = [self._duals.parts(self._read(i)) for i in loop.begin]
        moving = [slope is not None for _, slope in begin]
        values = [value for value, _ in begin]

        def body(*state: Expr) -> Sequence[Expr]:
            flat, has = self._inside(loop.bit, loop.state, state, moving, loop.outputs)
            count = len(has)
            slopes = iter(flat[count:])
            every = [next(slopes) if h else self._duals.zero for h in has]
            found[:] = has
            return [*flat[:count], *(s for s, m in zip(every, moving, strict=True) if m)]

        found: list[bool] = []
        while True:
            slopes = [self._duals.zero if s is None else s for (_, s), m in zip(begin, moving, strict=True) if m]
            results = graph.repeat(loop.turns, body, *self._part(values, slopes), loop.stops)
            spread = [a or b for a, b in zip(moving, found, strict=True)]
            if spread == moving:
                break
            moving[:] = spread
        rest = iter(results[len(values) :])
        return [[self._duals.pair(value, next(rest) if m else None)] for value, m in zip(results, moving, strict=False)]

    def _part(self, values: list[Any], slopes: list[Any]) -> tuple[list[Any], list[Any]]:
        """Return the parts that a loop takes: derivatives are separate unless they are plain numbers."""
        zero: Any = self._duals.zero
        return (values, slopes) if self._graph.depends[zero.index] & SLOPE else ([*values, *slopes], [])

    def _inside(
        self, bit: int, inputs: Sequence[int], row: Sequence[Expr], moving: Sequence[bool], outputs: Iterable[int]
    ) -> tuple[list[Expr], list[bool]]:
        """Return the values, then slopes, of the results of a body; and which of them have slopes."""
        slopes = iter(row[len(inputs) :])
        known = {
            i: self._duals.pair(value, next(slopes) if moves else None)
            for i, value, moves in zip(inputs, row, moving, strict=False)
        }
        pairs = [self._duals.parts(one) for one in self._write_body(bit, known, outputs)]
        has = [slope is not None for _, slope in pairs]
        return [*(value for value, _ in pairs), *(s for _, s in pairs if s is not None)], has

    def _write_body(self, bit: int, known: dict[int, Any], outputs: Iterable[int]) -> list[Any]:
        self._levels.append(_Level(bit, known))
        try:
            return [self._read(index) for index in outputs]
        finally:
            self._levels.pop()


# ---------------------------------------------------------------- one derivative for each variable


class _Row:
    """A tangent: derivatives by variable, with the arithmetic that dual numbers ask for."""

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
    """The graph's operations; a choice between tangents is one between their entries."""

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
        kept = {i: s for i, s in read.tangent.row.items() if self._graph.value_of(s) != 0.0}
        return self._duals.pair(read.value, _Row(kept) if kept else None)

    def _each(self, index: int) -> list[list[Any]]:
        loop = self._graph.loops[index]
        columns = [[self._read(i) for i in column] for column in loop.columns]
        rows = (dict(zip(loop.row, row, strict=True)) for row in zip(*columns, strict=True))
        found = [self._write_body(loop.bit, row, loop.outputs) for row in rows]
        return [list(column) for column in zip(*found, strict=True)]

    def _repeat(self, index: int) -> list[list[Any]]:
        """A search for a root stays a loop: its derivatives come from the Newton step behind it."""
        loop = self._graph.repeats[index]
        begin = [self._read(i) for i in loop.begin]

        def turn(*state: Any) -> list[Any]:
            known = dict(zip(loop.state, state, strict=True))
            return self._write_body(loop.bit, known, loop.outputs)

        def turn_values(*state: Any) -> list[Any]:
            return [self._duals.parts(one)[0] for one in turn(*state)]

        found = begin
        for _ in range(0 if loop.stops else loop.turns):
            found = turn(*found)
        if loop.stops or not any(isinstance(one, Dual) for one in found):
            values = [self._duals.parts(one)[0] for one in begin]
            found = self._graph.repeat(loop.turns, turn_values, values, (), loop.stops)
        return [[one] for one in found]


def compute_partials(values: Sequence[Expr], variables: Sequence[Expr]) -> tuple[list[Expr], list[dict[int, Expr]]]:
    """Return the traced values as they are computed beside their derivatives, and these, forwards.

    For each value a row: number of the variable -> derivative, those that are zero left out.
    """
    graph = values[0].graph if values else None
    if graph is None:
        return [], []
    duals, one = _Slopes(_Choosing(graph)), graph.constant(1.0)
    moving = {v.index: duals.pair(v, _Row({i: one})) for i, v in enumerate(variables)}
    walk = _PartialsWalk(graph, duals, moving)
    pairs = [walk.pair(value.index) for value in values]
    rows: list[Any] = [slopes for _, slopes in pairs]
    return [value for value, _ in pairs], [{} if row is None else row.row for row in rows]


# ---------------------------------------------------------------- backwards


def compute_gradient(value: Expr, variables: Sequence[Expr]) -> dict[int, Expr] | None:
    """Compute the gradient of one value backwards; None if there is a loop on the way."""
    graph, places = value.graph, {v.index: i for i, v in enumerate(variables)}
    order = _list_dependent(graph, value.index, frozenset(places))
    if order is None:
        return None
    duals, moving = _Slopes(GraphNamespace(graph)), frozenset(order)
    bars: dict[int, Any] = {value.index: graph.constant(1.0)} if order else {}
    found: dict[int, Expr] = {}
    for index in reversed(order):
        bar = bars[index]
        if index in places:
            found[places[index]] = bar
            continue
        arguments = [Expr(graph, i) for i in graph.arguments[index]]
        for k, argument in enumerate(graph.arguments[index]):
            if argument in moving:
                one = [*arguments[:k], duals.pair(arguments[k], bar), *arguments[k + 1 :]]
                _, share = duals.parts(duals.apply(graph.operations[index], one))
                if share is not None:
                    bars[argument] = bars[argument] + share if argument in bars else share
    return {i: slope for i, slope in found.items() if graph.value_of(slope) != 0.0}


def _list_dependent(graph: Graph, value: int, variables: frozenset[int]) -> list[int] | None:
    """Return the nodes between value and variables that depend on the variables, in the order of computation.

    None if there are loops among it.
    """
    moving: set[int] = set()
    for index in sorted(graph.walk([value], partial(_list_arguments, graph))):
        if index in variables or any(a in moving for a in _list_arguments(graph, index)):
            moving.add(index)
    if any(graph.operations[index] in LOOPS for index in moving):
        return None
    return sorted(moving)


def _list_arguments(graph: Graph, index: int) -> tuple[int, ...]:
    """Return the arguments that derivatives follow: no flags, nothing detached, for a root its Newton step."""
    operation, arguments = graph.operations[index], graph.arguments[index]
    if operation in ("input", "constant", "detach") or operation in FLAGS:
        return ()
    return arguments[1:] if operation in ("where", "implicit_root") else arguments
