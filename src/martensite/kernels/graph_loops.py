"""Loops of an expression graph."""

from __future__ import annotations

from typing import NamedTuple


class GraphLoop(NamedTuple):
    """Loop with a body for every row of some columns."""

    columns: tuple[tuple[int, ...], ...]
    begin: tuple[int, ...]
    state: tuple[int, ...]
    """Inputs of the body that are carried from row to row; the first outputs are their next values."""
    row: tuple[int, ...]
    """Inputs of the body, one per column."""
    outputs: tuple[int, ...]
    outside: tuple[int, ...]
    """Other nodes that the body uses."""
    bit: int
    """Dependency bit of the nodes of the body."""


class Repeat(NamedTuple):
    """Loop whose body replaces a state by the next state."""

    turns: int
    stops: bool
    """True if the loop also ends at a first state variable that is not above 0."""
    begin: tuple[int, ...]
    state: tuple[int, ...]
    """Inputs of the body."""
    outputs: tuple[int, ...]
    outside: tuple[int, ...]
    """Other nodes that the body uses."""
    bit: int
    """Dependency bit of the nodes of the body."""
