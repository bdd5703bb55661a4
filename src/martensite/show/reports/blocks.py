"""What a report is made of, whatever it is written as."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Section:
    """A heading, and a place that can be pointed to."""

    title: str


@dataclass(frozen=True)
class Text:
    """A paragraph; names stand in backquotes."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """Sentences, one below the other."""

    items: Sequence[str]


@dataclass(frozen=True)
class Notice:
    """Sentences that must not be overlooked."""

    title: str
    items: Sequence[str]
    warning: bool
    """False if the news is good."""


@dataclass(frozen=True)
class Row:
    """Cells of a table; `tag` marks a row that is of another kind."""

    cells: Sequence[str]
    tag: str = ""


@dataclass(frozen=True)
class Grid:
    """A table."""

    head: Sequence[str]
    rows: Sequence[Row]
    right: Sequence[int] = ()
    """Columns whose cells are numbers, aligned to the right."""
    wrapped: Sequence[int] = ()
    """Columns of words, which may take several lines."""
    note: str = ""
    """How to read it."""


@dataclass(frozen=True)
class Picture:
    """A figure."""

    name: str
    """Of its file, without an ending."""
    figure: Figure
    caption: str


@dataclass(frozen=True)
class Folded:
    """A table that only some will want to see."""

    title: str
    grid: Grid


Block = Section | Text | Bullets | Notice | Grid | Picture | Folded
