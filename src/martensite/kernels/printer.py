"""Printer of a graph as straight-line code in any language: order, naming and inlining.

A node with one use is written inline; other nodes get names. A dialect gives the form of each operation and the
operations that need plain names as operands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from martensite.kernels.graph import PARAMETER, SLOPE, Expr, Graph

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
    shares_inverses: bool = False
    """True if divisions by the same number use its inverse, computed once."""


@dataclass(frozen=True)
class LoopText:
    """Loop over rows, in the words of the language."""

    name: str
    row: Sequence[str]
    """Names of the inputs of the body."""
    columns: Sequence[Sequence[str]]
    body: Sequence[str]
    outputs: Sequence[str]
    row_kinds: Sequence[str]
    output_kinds: Sequence[str]

    def results(self) -> list[str]:
        """Return the names of the columns of results."""
        return [f"{self.name}_{k}" for k in range(len(self.outputs))]


@dataclass(frozen=True)
class RepeatText:
    """Loop over a state, in the words of the language."""

    name: str
    count: int
    stops: bool
    """True if the loop ends at a first state variable not above 0."""
    state: Sequence[str]
    """Names of the inputs of the body."""
    begin: Sequence[str]
    body: Sequence[str]
    outputs: Sequence[str]
    kinds: Sequence[str]
    used: Sequence[bool]
    """Results that are used afterwards."""

    def results(self) -> list[str]:
        """Return the names of the results."""
        return [f"{self.name}_{k}" for k in range(len(self.outputs))]


class Printer:
    """Printer of parts of one graph in one dialect, with a memory of named nodes."""

    def __init__(self, graph: Graph, dialect: Dialect) -> None:
        self.graph = graph
        self.dialect = dialect
        self.shared: dict[int, str] = {}

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
                lines += self._loop(index, text)
                continue
            if index in self.graph.repeats:
                text[index] = f"e{index}"
                lines += self._repeat(index, text, uses)
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
            atomic = not arguments
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

    def _loop(self, index: int, text: Mapping[int, str]) -> list[str]:
        """Print a loop over rows; its body uses separate names."""
        loop, inner = self.graph.loops[index], dict(text)
        uses = self._uses(loop.outputs, loop.bit)
        body = self._lines(uses, inner, "b")
        named = LoopText(
            name=text[index],
            row=[str(self.graph.arguments[i][0]) for i in loop.row],
            columns=[[text[i] for i in column] for column in loop.columns],
            body=body,
            outputs=[inner[i] for i in loop.outputs],
            row_kinds=[self.kind(i) for i in loop.row],
            output_kinds=[self.kind(i) for i in loop.outputs],
        )
        return self.dialect.loop(named)

    def _repeat(self, index: int, text: Mapping[int, str], uses: Mapping[int, int]) -> list[str]:
        """Print a loop over a state; its body uses separate names."""
        loop, inner = self.graph.repeats[index], dict(text)
        body = self._lines(self._uses(loop.outputs, loop.bit), inner, "t")
        taken = {self.graph.details[i] for i in uses if self.graph.arguments[i] == (index,)}
        named = RepeatText(
            name=text[index],
            count=loop.turns,
            stops=loop.stops,
            state=[str(self.graph.arguments[i][0]) for i in loop.state],
            begin=[text[i] for i in loop.begin],
            body=body,
            outputs=[inner[i] for i in loop.outputs],
            kinds=[self.kind(i) for i in loop.state],
            used=[place in taken for place in range(len(loop.state))],
        )
        return self.dialect.repeat(named)

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
        seen: set[int] = set()
        while stack:
            index = stack.pop()
            if index in seen:
                continue
            seen.add(index)
            wants = self.graph.operations[index] in self.dialect.wants_names
            loops = index in self.graph.loops or index in self.graph.repeats
            weight = 2 if wants or loops else 1
            for child in self._children(index):
                if inside and not self.graph.depends[child] & inside:
                    continue
                uses[child] = uses.get(child, 0) + weight
                stack.append(child)
        return uses

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
            return f"{text[args[0]]}_{place}[{row}]"
        if operation == "result":
            return f"{text[args[0]]}_{self.graph.details[index]}"
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


def _float_loop(loop: LoopText) -> list[str]:
    """Return a Python loop that appends to lists."""
    columns = ", ".join(f"({', '.join(column)},)" for column in loop.columns)
    results = list(zip(loop.results(), loop.outputs, strict=True))
    inner = [*loop.body, *(f"{name}.append({value})" for name, value in results)]
    return [
        *(f"{name} = []" for name, _ in results),
        f"for {', '.join(loop.row)}, in zip({columns}):",
        *(f"    {line}" for line in inner),
    ]


def _float_repeat(loop: RepeatText) -> list[str]:
    """Return a Python loop that replaces numbers."""
    state = ", ".join(loop.state)
    return [
        f"{state}, = {', '.join(loop.begin)},",
        f"for _ in range({loop.count}):",
        *([f"    if not {loop.state[0]} > 0.0:", "        break"] if loop.stops else []),
        *(f"    {line}" for line in loop.body),
        f"    {state}, = {', '.join(loop.outputs)},",
        f"{', '.join(loop.results())}, = {state},",
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
