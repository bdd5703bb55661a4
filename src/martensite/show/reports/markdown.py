"""A report as Markdown, with its figures in a folder beside it."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.parse import quote

from martensite.show.reports.blocks import (
    Block,
    Bullets,
    Folded,
    Grid,
    Notice,
    Picture,
    Section,
    Text,
)


def page(title: str, lead: str, blocks: Sequence[Block], by: str, folder: str) -> str:
    """The whole text; figures are looked for in `folder`, relative to it.

    Args:
        title: headline.
        lead: what it is about, in one line.
        blocks: its content.
        by: the program that wrote it.
        folder: where the figures lie.
    """
    body = "\n\n".join(_block(block, folder) for block in blocks)
    return f"# {title}\n\n{lead}\n\n{body}\n\n---\n\n{by}\n"


def _block(block: Block, folder: str) -> str:
    match block:
        case Section(title):
            return f"## {title}"
        case Text(text):
            return text
        case Bullets(items):
            return _list(items)
        case Notice(title, items):
            return "\n".join(f"> {line}".rstrip() for line in [f"**{title}**", "", *_lines(items)])
        case Grid():
            return _table(block)
        case Picture(name, _, caption):
            place = f"{quote(folder)}/{name}.png"
            return f"![{caption.replace('`', '')}]({place})\n\n*{caption}*"
        case Folded(title, grid):
            return f"### {title}\n\n{_table(grid)}"


def _list(items: Sequence[str]) -> str:
    return "\n".join(_lines(items))


def _lines(items: Sequence[str]) -> list[str]:
    return [f"- {item}" for item in items]


def _table(grid: Grid) -> str:
    marks = ["---:" if k in grid.right else "---" for k in range(len(grid.head))]
    rows = [_row(grid.head), _row(marks)]
    for row in grid.rows:
        first, *others = row.cells
        rows.append(_row([f"{first} **({row.tag})**" if row.tag else first, *others]))
    return "\n".join(rows) + (f"\n\n{grid.note}" if grid.note else "")


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
