"""Printer of a graph as straight-line code in any language: order, naming and inlining.

A node with one use is written inline; other nodes get names. A dialect gives the form of each operation and the
operations that need plain names as operands.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count

from martensite.kernels.graph import PARAMETER, SLOPE, Expr, Graph
from martensite.kernels.graph_loops import GraphLoop, Repeat

DEEPEST = 24
FLAG, NUMBER, SLOPES = "flag", "number", "slopes"
"""Kinds of nodes: flag, number, or derivatives in several directions."""


@dataclass(frozen=True)
class Dialect:
    """Rules of a language for expressions and assignments."""

    templates: Mapping[str, str]
    wants_names: frozenset[str]
    assign: Callable[[str, str, str], str]
    """Name, expression and kind of a node."""
    constant: Callable[[float | bool], str]
    loop: Callable[[LoopText], list[str]]
    repeat: Callable[[RepeatText], list[str]]
    most_variables: float = math.inf
    """Largest number of state variables with separate names; more are elements of an array."""
    shares_inverses: bool = False
    """True if divisions by the same number use its inverse, computed once."""


@dataclass(frozen=True)
class LoopText:
    """Loop over rows, in the words of the language."""

    name: str
    rows: int
    row: Sequence[str]
    """Names of the inputs of the body from the columns."""
    columns: Sequence[Sequence[str]]
    row_kinds: Sequence[str]
    state: Sequence[str]
    """Names of the inputs of the body that are carried from row to row."""
    begin: Sequence[str]
    state_kinds: Sequence[str]
    body: Sequence[str]
    carried: Sequence[str]
    """Next state, as results of the body."""
    result_columns: Mapping[str, tuple[str, str]]
    """Names of the columns of results -> result of the body, and its kind."""


@dataclass(frozen=True)
class RepeatText:
    """Loop over a state, in the words of the language."""

    name: str
    count: int
    stops: bool
    """True if the loop ends at a first state variable not above 0."""
    state: Sequence[str]
    """Names of the state variables, during and after the loop."""
    begin: Sequence[str]
    body: Sequence[str]
    outputs: Sequence[str]
    kinds: Sequence[str]


class Printer:
    """Printer of parts of one graph in one dialect, with a memory of named nodes."""

    def __init__(self, graph: Graph, dialect: Dialect) -> None:
        self.graph = graph
        self.dialect = dialect
        self.shared: dict[int, str] = {}
        self._ends: set[tuple[int, int]] = set()
        """Loops and places of the results of which only the last row is used."""
        self._states: dict[int, list[str]] = {}
        """Repeat -> names of its state variables."""

    def block(self, outputs: Iterable[Expr], assigned: str = "v") -> tuple[list[str], list[str]]:
        """Return the assignments that compute `outputs`, and the outputs as expressions."""
        wanted = [node.index for node in outputs]
        text: dict[int, str] = {}
        lines = self._lines(self._uses(wanted), text, assigned)
        return lines, [text[i] for i in wanted]

    def _lines(self, uses: Mapping[int, int], text: dict[int, str], assigned: str) -> list[str]:
        """Return the assignments of the named nodes among the used nodes, and add all to `text`."""
        depth: dict[int, int] = {}
        lines: list[str] = []
        inverses = self._inverses(uses)
        for index in sorted(uses):
            if index in self.graph.loops:
                text[index] = f"e{index}"
                lines += self._loop(index, text, uses)
                continue
            if index in self.graph.repeats:
                text[index] = f"e{index}"
                lines += self._repeat(index, text)
                continue
            expression = self._expression(index, text)
            arguments = self._children(index)
            if index in inverses:
                divisor = arguments[1]
                name = f"i{divisor}"
                if index == inverses[index]:
                    one = self.dialect.constant(1.0)
                    inverse = self.dialect.templates["div"].format(one, text[divisor])
                    lines.append(self.dialect.assign(name, inverse, NUMBER))
                expression = self.dialect.templates["mul"].format(text[arguments[0]], name)
            depth[index] = 1 + max((depth.get(a, 0) for a in arguments), default=0)
            atomic = not arguments or self.graph.operations[index] in ("item", "result")
            if atomic or (uses[index] == 1 and depth[index] < DEEPEST):
                text[index] = expression
                continue
            name = f"{assigned}{index}"
            lines.append(self.dialect.assign(name, expression, self.kind(index)))
            text[index], depth[index] = name, 0
        return lines

    def _inverses(self, uses: Mapping[int, int]) -> dict[int, int]:
        """Return the divisions with a common inverse -> the first of them."""
        by: dict[int, list[int]] = {}
        for index in sorted(uses) if self.dialect.shares_inverses else ():
            if self.graph.operations[index] == "div" and index not in self.shared:
                by.setdefault(self.graph.arguments[index][1], []).append(index)
        groups = [group for group in by.values() if len(group) > 1]
        return {index: group[0] for group in groups for index in group}

    def _loop(self, index: int, text: Mapping[int, str], uses: Mapping[int, int]) -> list[str]:
        """Print a loop over rows; its body uses separate names."""
        loop, name = self.graph.loops[index], text[index]
        size, places = len(loop.state), self._find_used(index, uses)
        states = [f"{name}_s{place}" for place in range(size)]
        body, carried, results, read = self._body(loop, states, [*range(size), *places], text, "b")
        columns = [(i, column) for i, column in zip(loop.row, loop.columns, strict=True) if i in read]
        kinds = [self.kind(loop.outputs[place]) for place in places]
        names = [f"{name}_{place}" for place in places]
        named = LoopText(
            name=name,
            rows=len(loop.columns[0]),
            row=[str(self.graph.arguments[i][0]) for i, _ in columns],
            columns=[[text[i] for i in column] for _, column in columns],
            row_kinds=[self.kind(i) for i, _ in columns],
            state=states,
            begin=[text[i] for i in loop.begin],
            state_kinds=[self.kind(i) for i in loop.state],
            body=body,
            carried=carried,
            result_columns=dict(zip(names, zip(results, kinds, strict=True), strict=True)),
        )
        return self.dialect.loop(named)

    def _find_used(self, index: int, uses: Mapping[int, int]) -> list[int]:
        """Return the places of results that a loop must keep, and note those of which only the last state is used."""
        used: dict[int, set[int]] = {}
        for place, row in (self.graph.details[i] for i in uses if self.graph.arguments[i] == (index,)):
            used.setdefault(place, set()).add(row)
        loop = self.graph.loops[index]
        last = {len(loop.columns[0]) - 1}
        ends = {place for place, rows in used.items() if place < len(loop.state) and rows == last}
        self._ends = {one for one in self._ends if one[0] != index} | {(index, place) for place in ends}
        return [place for place in sorted(used) if place not in ends]

    def _body(
        self,
        loop: GraphLoop | Repeat,
        states: Sequence[str],
        places: Sequence[int],
        text: Mapping[int, str],
        letter: str,
    ) -> tuple[list[str], list[str], list[str], Collection[int]]:
        """Return the lines of the body of a loop, its next state, other results at `places`, and used nodes."""
        inner = dict(text)
        self.shared.update(zip(loop.state, states, strict=True))
        wanted = [loop.outputs[place] for place in places]
        uses = self._uses(wanted, loop.bit)
        lines = self._lines(uses, inner, letter)
        for i in loop.state:
            del self.shared[i]
        results = [inner[i] for i in wanted]
        return lines, results[: len(states)], results[len(states) :], uses

    def _repeat(self, index: int, text: Mapping[int, str]) -> list[str]:
        """Print a loop over a state; its body uses separate names."""
        loop, name = self.graph.repeats[index], text[index]
        kinds = [self.kind(i) for i in loop.state]
        states = self._states[index] = self._name_states(name, kinds)
        body, outputs, *_ = self._body(loop, states, range(len(kinds)), text, "t")
        begin = [text[i] for i in loop.begin]
        return self.dialect.repeat(RepeatText(name, loop.turns, loop.stops, states, begin, body, outputs, kinds))

    def _name_states(self, name: str, kinds: Sequence[str]) -> list[str]:
        """Return the names of the state variables of a loop, during and after it."""
        if len(kinds) <= self.dialect.most_variables:
            return [f"{name}_{place}" for place in range(len(kinds))]
        counts = {kind: count() for kind in kinds}
        return [f"{'d' if kind == SLOPES else ''}{name}[{next(counts[kind])}]" for kind in kinds]

    def share(self, nodes: Iterable[Expr], name: Callable[[int], str]) -> None:
        """Declare that these nodes have a name from now on."""
        for position, node in enumerate(nodes):
            self.shared[node.index] = name(position)

    def kind(self, index: int) -> str:
        """Return the kind: flag, number, or derivatives."""
        if self.is_flag(index):
            return FLAG
        return SLOPES if self.graph.depends[index] & SLOPE else NUMBER

    def is_flag(self, index: int) -> bool:
        """Return whether a node is a flag."""
        return index in self.graph.flags

    def _children(self, index: int) -> tuple[int, ...]:
        if index in self.shared or self.graph.operations[index] in ("input", "constant"):
            return ()
        return self.graph.children(index)

    def _uses(self, wanted: Sequence[int], inside: int = 0) -> dict[int, int]:
        """Count the uses of each needed node; operations that need names count double.

        Inside the body of a loop only nodes with its bit count, as the others have names.
        """
        uses: dict[int, int] = {}
        stack = list(wanted)
        for index in wanted:
            uses[index] = uses.get(index, 0) + 1
        earlier_nodes: set[int] = set()
        while stack:
            index = stack.pop()
            if index in earlier_nodes:
                continue
            earlier_nodes.add(index)
            for child, weight in self._weigh(index).items():
                if inside and not self.graph.depends[child] & inside:
                    continue
                uses[child] = uses.get(child, 0) + weight
                stack.append(child)
        return uses

    def _weigh(self, index: int) -> Mapping[int, int]:
        """Return the operands of a node, and how often the node uses each; 2 if it must be a name."""
        loop = self.graph.loops.get(index) or self.graph.repeats.get(index)
        children = self._children(index)
        if loop is None:
            weight = 2 if self.graph.operations[index] in self.dialect.wants_names else 1
            return {child: weight * number for child, number in Counter(children).items()}
        once = Counter((*loop.begin, *chain.from_iterable(loop.columns if isinstance(loop, GraphLoop) else ())))
        named = set(loop.outside)
        return {child: 2 if child in named else once[child] for child in children}

    def _expression(self, index: int, text: dict[int, str]) -> str:
        if index in self.shared:
            return self.shared[index]
        operation, args = self.graph.operations[index], self.graph.arguments[index]
        if operation == "input":
            return str(args[0])
        if operation == "constant":
            return self.dialect.constant(args[0])
        if operation == "item":
            place, row = self.graph.details[index]
            end = (args[0], place) in self._ends
            return f"{text[args[0]]}_s{place}" if end else f"{text[args[0]]}_{place}[{row}]"
        if operation == "result":
            place: int = self.graph.details[index]
            return self._states[args[0]][place]
        return self.dialect.templates[operation].format(*(text[a] for a in self._children(index)))


def parameter_nodes(graph: Graph, outputs: Iterable[Expr]) -> list[Expr]:
    """Return the nodes that depend on parameters only and feed nodes that depend on more."""

    def below(index: int) -> tuple[int, ...]:
        return graph.children(index) if graph.depends[index] & ~SLOPE not in (0, PARAMETER) else ()

    reached = graph.walk([node.index for node in outputs], below)
    return [Expr(graph, index) for index in sorted(reached) if graph.depends[index] & ~SLOPE == PARAMETER]


def python_constant(value: float | bool) -> str:
    """Return a literal; infinities become overflowing numbers."""
    return repr(value).replace("inf", "1e999")


PYTHON_OPERATORS = {
    "add": "({} + {})",
    "sub": "({} - {})",
    "mul": "({} * {})",
    "div": "({} / {})",
    "neg": "(-{})",
    "lt": "({} < {})",
    "le": "({} <= {})",
    "gt": "({} > {})",
    "ge": "({} >= {})",
    "detach": "{}",
    "implicit_root": "{}",
    "eps": "2.220446049250313e-16",
}
"""Operations with the same form in Python and C."""


ITEM = re.compile(r"(\w+)\[(\d+)\]")


def _float_loop(loop: LoopText) -> list[str]:
    """Return a Python loop that appends to lists."""
    state = ", ".join(loop.state)
    return [
        *(f"{name} = []" for name in loop.result_columns),
        *([f"{state}, = {', '.join(loop.begin)},"] if state else []),
        f"for {', '.join(loop.row)}, in zip({', '.join(map(_list_items, loop.columns))}):"
        if loop.row
        else f"for _ in range({loop.rows}):",
        *(f"    {line}" for line in loop.body),
        *(f"    {name}.append({value})" for name, (value, _) in loop.result_columns.items()),
        *([f"    {state}, = {', '.join(loop.carried)},"] if state else []),
    ]


def _list_items(cells: Sequence[str]) -> str:
    """Return a column as an expression: a list of results, a slice of it, or a tuple."""
    matches = [ITEM.fullmatch(cell) for cell in cells]
    items = [(one[1], int(one[2])) for one in matches if one]
    (name, first), (_, last) = (items[0], items[-1]) if items else (("", 0), ("", 0))
    step = 1 if last >= first else -1
    if not items or items != [(name, first + step * k) for k in range(len(cells))]:
        return f"({', '.join(cells)},)"
    end = last + step
    return f"{name}[{first}:{end if end >= 0 else ''}:{step}]"


def _float_repeat(loop: RepeatText) -> list[str]:
    """Return a Python loop that replaces numbers."""
    state = ", ".join(loop.state)
    return [
        f"{state}, = {', '.join(loop.begin)},",
        f"for _ in range({loop.count}):",
        *([f"    if not {loop.state[0]} > 0.0:", "        break"] if loop.stops else []),
        *(f"    {line}" for line in loop.body),
        f"    {state}, = {', '.join(loop.outputs)},",
    ]


FLOAT_DIALECT = Dialect(
    templates={
        **PYTHON_OPERATORS,
        "where": "({1} if {0} else {2})",
        "both": "({} and {})",
        "either": "({} or {})",
        "negate": "(not {})",
        "minimum": "({0} if {0} < {1} else {1})",
        "maximum": "({0} if {0} > {1} else {1})",
        "abs": "(-{0} if {0} < 0.0 else {0})",
        "sqrt": "(_sqrt({0}) if {0} > 0.0 else 0.0)",
        "exp": "_exp({0} if {0} < 700.0 else 700.0)",
        "log": "_log({0} if {0} > 1e-300 else 1e-300)",
        "power": "_power({}, {})",
        "sin": "_sin({})",
        "cos": "_cos({})",
        "tanh": "_tanh({})",
        "nearest": "_nearest({})",
        "quarter_sine": "_sin(1.5707963267948966 * {})",
        "erfcx": "_erfcx({})",
    },
    wants_names=frozenset({"minimum", "maximum", "abs", "sqrt", "exp", "log"}),
    assign=lambda name, expression, kind: f"{name} = {expression}",
    constant=python_constant,
    loop=_float_loop,
    repeat=_float_repeat,
)
