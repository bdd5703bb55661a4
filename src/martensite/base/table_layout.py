"""Plain-text tables that keep to a width without breaking a word or a number.

Wide cells are wrapped between words; a table that is still too wide is split into several tables, each with the first
column.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from textwrap import wrap

GAP = 2
"""Spaces between columns."""


@dataclass(frozen=True)
class _Column:
    head: str
    cells: Sequence[str]
    right: bool

    @property
    def width(self) -> int:
        return max(len(line) for text in (self.head, *self.cells) for line in text.split("\n"))

    @property
    def narrowest(self) -> int:
        """Return the width below which a word or a number would be broken."""
        numbers = self.cells if self.right else [w for cell in self.cells for w in cell.replace("\n", " ").split(" ")]
        return max(map(len, ["", *self.head.split(), *numbers]))

    def align(self, text: str, width: int) -> str:
        return text.rjust(width) if self.right else text.ljust(width)


def _wrap_cell(text: str, width: int) -> list[str]:
    lines = (wrap(line, max(width, 1), break_long_words=False, break_on_hyphens=False) for line in text.split("\n"))
    return [part for wrapped in lines for part in wrapped or [""]]


Paint = Callable[[str, str], str]
"""Function that colours a padded text (second argument) by its cell (first argument)."""


def format_table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    right: Sequence[int],
    width: int,
    paint: Paint = lambda _, text: text,
) -> Iterator[str]:
    """Yield the lines of a table of at most `width` characters; columns in `right` are not wrapped."""
    columns = [_Column(name, [row[k] for row in rows], k in right) for k, name in enumerate(head)]
    for k, group in enumerate(_group_columns(columns, width)):
        if k:
            yield ""
        yield from _format_group(group, len(rows), width, paint)


def _group_columns(columns: list[_Column], width: int) -> Iterator[list[_Column]]:
    """Yield groups of columns that fit the width; all groups begin with the first column."""
    first, *others = columns
    group = [first]
    for column in others:
        taken = sum(one.narrowest + GAP for one in group)
        if len(group) > 1 and taken + column.narrowest > width:
            yield group
            group = [first]
        group.append(column)
    yield group


def _fit_widths(group: Sequence[_Column], width: int) -> list[int]:
    """Return column widths; the widest columns are narrowed until all fit."""
    widths, limits = [one.width for one in group], [one.narrowest for one in group]
    for _ in range(sum(widths) + GAP * (len(group) - 1) - width):
        loose = [k for k, limit in enumerate(limits) if widths[k] > limit]
        if not loose:
            break
        widths[max(loose, key=lambda k: widths[k])] -= 1
    return widths


def _format_group(group: Sequence[_Column], count: int, width: int, paint: Paint) -> Iterator[str]:
    widths = _fit_widths(group, width)
    heads = [_wrap_cell(one.head.strip(), w) for one, w in zip(group, widths, strict=True)]
    most = max(map(len, heads))
    for line in range(most):
        # headings end on the same line, right above their column
        texts = [h[line - most + len(h)] if line >= most - len(h) else "" for h in heads]
        yield _join_cells(group, widths, texts)
    yield "─" * (sum(widths) + GAP * (len(widths) - 1))
    for k in range(count):
        cells = [one.cells[k] for one in group]
        parts = [_wrap_cell(cell, w) for cell, w in zip(cells, widths, strict=True)]
        for line in range(max(map(len, parts))):
            texts = [part[line] if line < len(part) else "" for part in parts]
            yield _join_cells(group, widths, texts, [lambda text, cell=cell: paint(cell, text) for cell in cells])


def _join_cells(
    group: Sequence[_Column],
    widths: Sequence[int],
    texts: Sequence[str],
    paints: Sequence[Callable[[str], str]] | None = None,
) -> str:
    padded = [one.align(t, w) for one, t, w in zip(group, texts, widths, strict=True)]
    if not group[-1].right:
        padded[-1] = padded[-1].rstrip()
    if paints is not None:
        padded = [paint(text) for paint, text in zip(paints, padded, strict=True)]
    return (" " * GAP).join(padded).rstrip()
