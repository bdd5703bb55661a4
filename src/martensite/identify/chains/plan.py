"""Blocks in series as programs: every block traced once, with all its partial derivatives.

A block takes signals x with derivatives S_x (one column per number of this block and earlier ones) and its state s with
S_s; its partial derivatives give

    S_y = y_x S_x + y_s S_s + y_θ,    S_s⁺ = s_x S_x + s_s S_s + s_θ

in one pass with the simulation. Only non-zero entries are computed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from martensite.identify.blocks.base import AbstractBlock
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.graph import VARYING
from martensite.kernels.partials import compute_gradient, compute_partials
from martensite.kernels.program import Function, Program


@dataclass(frozen=True)
class Entry:
    """A non-zero partial derivative d row / d column, and the place of its value."""

    row: int
    column: int
    place: int
    constant: bool = False
    """True if it is the same in every sample."""


@dataclass(frozen=True)
class TracedBlock:
    """One function of a block: rows are its results, columns its arguments."""

    name: str
    rows: int
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class ChainPiece:
    """A block in the plan of a chain."""

    block: AbstractBlock
    first: int
    """Column of its first free number, after the initial state."""
    step: TracedBlock
    """Rows: outputs, then states. Columns: inputs, states, free numbers."""
    rest: TracedBlock
    """Rows: states. Columns: inputs, free numbers."""

    @property
    def count(self) -> int:
        """Return the number of free parameters."""
        return len(self.block.numbers())


@dataclass(frozen=True, eq=False)
class ChainPlan:
    """A chain as programs. Parameters: all free numbers, all fixed numbers, then dt."""

    program: Program
    pieces: tuple[ChainPiece, ...]

    @property
    def columns(self) -> int:
        """Return the number of free numbers."""
        return sum(piece.count for piece in self.pieces)

    @property
    def states(self) -> int:
        """Return the number of states."""
        return sum(piece.block.states() for piece in self.pieces)

    @property
    def width(self) -> int:
        """Return the largest number of signals between two blocks."""
        return max(max(p.block.inputs, p.block.outputs) for p in self.pieces)


def plan_blocks(blocks: Sequence[AbstractBlock]) -> ChainPlan:
    """Return the plan of blocks in series, traced once per structure."""
    return _plan_keyed(tuple(_Shaped(block) for block in blocks))


class _Shaped:
    """A block that equals all blocks of its structure."""

    def __init__(self, block: AbstractBlock) -> None:
        self.block, self.key = block, block.structure()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Shaped) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@cache_answers(64)
def _plan_keyed(shaped: tuple[_Shaped, ...]) -> ChainPlan:
    program = Program()
    blocks = [one.block for one in shaped]
    theta = [[program.parameter(n) for n in block.numbers()] for block in blocks]
    given = [[program.parameter(n) for n in block.fixed] for block in blocks]
    dt = program.parameter("dt")
    pieces: list[ChainPiece] = []
    first = 0
    for k, block in enumerate(blocks):
        twin = block.with_fixed_values(given[k])
        pieces.append(_build_piece(program, twin, k, first, theta[k], dt))
        first += len(theta[k])
    return ChainPlan(program, tuple(pieces))


def _build_piece(program: Program, block: AbstractBlock, k: int, first: int, theta: list[Any], dt: Any) -> ChainPiece:
    x = [f"x{i}" for i in range(block.inputs)]
    s = [f"s{i}" for i in range(block.states())]
    inputs, states = len(x), len(s)

    def step(xp: Any, moving: Sequence[Any]) -> Sequence[Any]:
        numbers = moving[inputs + states :]
        y, after = block.step(xp, numbers, moving[inputs : inputs + states], moving[:inputs], dt)
        return [*y, *after]

    def rest(xp: Any, moving: Sequence[Any]) -> Sequence[Any]:
        return list(block.rest(xp, moving[inputs:], moving[:inputs], dt))

    return ChainPiece(
        block,
        first,
        _trace_block(program, f"b{k}", [*x, *s], theta, step),
        _trace_block(program, f"r{k}", x, theta, rest),
    )


def _trace_block(
    program: Program,
    name: str,
    inputs: list[str],
    theta: list[Any],
    kernel: Callable[[Any, Sequence[Any]], Sequence[Any]],
) -> TracedBlock:
    """Add a kernel to the program, with and without its derivatives."""
    moving = [*(program.graph.input(i, VARYING) for i in inputs), *theta]
    values, rows = _differentiate_block(program, kernel, moving)
    entries: list[Entry] = []
    slopes: list[Any] = []
    for row, slopes_of_row in enumerate(rows):
        for column, slope in slopes_of_row.items():
            varies = bool(program.graph.depends[slope.index] & VARYING)
            entries.append(Entry(row, column, len(values) + len(slopes), not varies))
            slopes.append(slope)
    program.functions[name] = Function(name, tuple(inputs), (*values, *slopes))
    program.functions[f"v{name}"] = Function(f"v{name}", tuple(inputs), tuple(values))
    return TracedBlock(name, len(values), tuple(entries))


def _differentiate_block(
    program: Program, kernel: Callable[[Any, Sequence[Any]], Sequence[Any]], moving: Sequence[Any]
) -> tuple[list[Any], list[dict[int, Any]]]:
    """Return values and derivatives, backwards for a single value if that takes less work."""
    traced = [program.as_node(value) for value in kernel(program.xp, moving)]
    values, rows = compute_partials(traced, moving)
    if len(values) == 1:
        back = compute_gradient(values[0], moving)
        ahead = rows[0]
        if back is not None and _count_work(program, back) < _count_work(program, ahead):
            return values, [back]
    return values, rows


def _count_work(program: Program, slopes: dict[int, Any]) -> int:
    """Return the number of operations per sample."""
    graph, nodes = program.graph, set[int]()
    stack = [slope.index for slope in slopes.values()]
    while stack:
        index = stack.pop()
        if index not in nodes and graph.depends[index] & VARYING:
            nodes.add(index)
            stack += graph.children(index)
    return len(nodes)
