"""Summary of a result: sentences, tables, figures, and values for programs.

A terminal, Markdown, HTML, JSON and the web bench render the same `Summary`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from textwrap import fill
from typing import TYPE_CHECKING, Any, Literal

from martensite.base.services import import_service
from martensite.base.table_layout import format_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Tone = Literal["", "title", "good", "caution", "bad"]
PAGE_WIDTH = 80
"""Width of plain text [columns]."""


@dataclass(frozen=True)
class Heading:
    """Title of the following blocks."""

    title: str
    detail: bool = False
    """True if the following blocks appear on pages only."""


@dataclass(frozen=True)
class Sentence:
    """Line or paragraph; names are in backquotes."""

    text: str
    tone: Tone = ""


@dataclass(frozen=True)
class BulletList:
    """List of sentences."""

    items: Sequence[str]
    detail: bool = False
    """True if it appears on pages only."""


@dataclass(frozen=True)
class Notice:
    """Sentences that must not be overlooked."""

    title: str
    items: Sequence[str]
    warning: bool
    """False for good news."""


@dataclass(frozen=True)
class DataTable:
    """Table of words and numbers."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()
    """Right-aligned columns."""
    note: str = ""
    """Note on how to read the table."""
    detail: Sequence[int] = ()
    """Columns that appear on pages only."""
    tags: Mapping[int, str] = field(default_factory=dict[int, str])
    """Row -> label of an unusual row."""
    tones: Mapping[str, Tone] = field(default_factory=dict[str, Tone])
    """Text of a cell -> tone."""
    folded: str = ""
    """Title of a table that is collapsed on pages; empty for other tables."""

    def drop_details(self) -> DataTable:
        """Return the table without columns for pages."""
        columns = [k for k in range(len(self.head)) if k not in self.detail]
        return DataTable(
            [self.head[k] for k in columns],
            [[row[k].replace("`", "") + self._tag(i) * (k == 0) for k in columns] for i, row in enumerate(self.rows)],
            [place for place, k in enumerate(columns) if k in self.right],
            tones=self.tones,
        )

    def _tag(self, row: int) -> str:
        return f" ({self.tags[row]})" if self.tags.get(row) else ""


@dataclass(frozen=True)
class Picture:
    """Figure."""

    name: str
    """File name without suffix."""
    draw: Callable[[], Figure]
    caption: str


Block = Heading | Sentence | BulletList | Notice | DataTable | Picture


@dataclass(frozen=True)
class Summary:
    """Result as text, tables and values."""

    title: str
    """May be empty."""
    blocks: Sequence[Block]
    data: Any = None
    """All values by name in SI, ready for JSON."""
    lead: str = ""
    """Subject, in one line."""

    def __str__(self) -> str:
        return "\n".join(self.format_lines())

    def wrap_sentences(self) -> Summary:
        """Return the summary with its title, sentences and items broken at 80 columns."""
        blocks = [_wrap_block(block) for block in self.blocks]
        return replace(self, title=_wrap_text(self.title), blocks=blocks, lead=_wrap_text(self.lead))

    def brief(self, most: int = 8) -> str:
        """Return the first lines of the plain text, and the number of further lines."""
        lines = list(self.format_lines())
        more = [f"… {len(lines) - most} more lines in summary()"] if len(lines) > most else []
        return "\n".join([*lines[:most], *more])

    def _repr_html_(self) -> str:
        return import_service("render_html")(self)

    def format_lines(
        self, width: int = PAGE_WIDTH, paint: Callable[[str, Tone], str] = lambda text, _: text
    ) -> Iterator[str]:
        """Yield plain text without figures and details; tables keep to a width, sentences are not wrapped."""
        if self.title:
            yield paint(self.title, "title")
        if self.lead:
            yield self.lead
        detail = False
        for block in self.blocks:
            detail = block.detail if isinstance(block, Heading) else detail
            if not detail:
                yield from _format_block(block, width, paint)


def _wrap_text(text: str) -> str:
    lines = text.split("\n")
    return "\n".join(fill(one, PAGE_WIDTH, break_long_words=False, break_on_hyphens=False) for one in lines)


def _wrap_block(block: Block) -> Block:
    match block:
        case Heading(title):
            return replace(block, title=_wrap_text(title))
        case Sentence(text):
            return replace(block, text=_wrap_text(text))
        case BulletList(items):
            return replace(block, items=[_wrap_text(one) for one in items])
        case Notice(title, items):
            room = len(title) + 2
            return replace(block, items=[_wrap_text(f"{title}: {one}")[room:] for one in items])
        case _:
            return block


def _format_block(block: Block, width: int, paint: Callable[[str, Tone], str]) -> Iterator[str]:
    match block:
        case Heading(title):
            yield paint(title, "title")
        case Sentence(text, tone):
            yield paint(text, tone)
        case BulletList(items) if not block.detail:
            yield from items
        case Notice(title, items, warning):
            yield from (paint(f"{title}: {one}", "caution" if warning else "") for one in items)
        case DataTable() if not block.folded:
            table = block.drop_details()
            yield ""
            yield from format_table(
                table.head, table.rows, table.right, width, lambda cell, text: paint(text, table.tones.get(cell, ""))
            )
            yield ""
        case _:
            pass
