"""A report as one page of HTML: styles and figures inside, nothing fetched, light or dark."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from martensite.show.figures.style import styled
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

_STYLES = Path(__file__).parent / "page.css"
_CODE = re.compile(r"`([^`]+)`")
_HASH = re.compile(r"<code>(?=[0-9a-f]{64}</code>)")
_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="{by}">
<title>{title}</title>
<style>
{styles}</style>
</head>
<body>
<main>
<h1>{title}</h1>
<p class="lead">{lead}</p>
<nav>{links}</nav>
{body}
<footer>{by}</footer>
</main>
</body>
</html>
"""


def page(title: str, lead: str, blocks: Sequence[Block], by: str) -> str:
    """The whole page.

    Args:
        title: headline.
        lead: what it is about, in one line.
        blocks: its content.
        by: the program that wrote it.
    """
    sections = [block.title for block in blocks if isinstance(block, Section)]
    return _PAGE.format(
        title=escape(title), lead=inline(lead), by=escape(by), body="\n".join(map(_block, blocks)),
        links=" ".join(f'<a href="#{_anchor(one)}">{escape(one)}</a>' for one in sections),
        styles=_STYLES.read_text(encoding="utf-8"),
    )  # fmt: skip


def inline(text: str) -> str:
    """Text with names in backquotes as HTML."""
    marked = _CODE.sub(r"<code>\1</code>", escape(text, quote=False))
    return _HASH.sub(r'<code class="hash">', marked)


def _block(block: Block) -> str:
    match block:
        case Section(title):
            return f'<h2 id="{_anchor(title)}">{escape(title)}</h2>'
        case Text(text):
            return f"<p>{inline(text)}</p>"
        case Bullets(items):
            return _list(items)
        case Notice(title, items, warning):
            kind = "notice warning" if warning else "notice"
            return f'<div class="{kind}"><strong>{escape(title)}</strong>{_list(items)}</div>'
        case Grid():
            return _table(block)
        case Picture():
            return _figure(block)
        case Folded(title, grid):
            return f"<details><summary>{escape(title)}</summary>{_table(grid)}</details>"


def _anchor(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _list(items: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{inline(item)}</li>' for item in items)}</ul>"


def _table(grid: Grid) -> str:
    head = "".join(_cell("th", text, _look(grid, k)) for k, text in enumerate(grid.head))
    rows: list[str] = []
    for row in grid.rows:
        cells = [_cell("td", text, _look(grid, k)) for k, text in enumerate(row.cells)]
        if row.tag:
            mark = f'<span class="tag">{escape(row.tag)}</span></td>'
            cells[0] = cells[0].removesuffix("</td>") + mark
        kind = ' class="held"' if row.tag else ""
        rows.append(f"<tr{kind}>{''.join(cells)}</tr>")
    note = f'<p class="note">{inline(grid.note)}</p>' if grid.note else ""
    body = "\n".join(rows)
    return (
        f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>'
        f"</table></div>{note}"
    )


def _look(grid: Grid, column: int) -> str:
    """Class of the cells of a column."""
    return "number" if column in grid.right else "words" if column in grid.wrapped else ""


def _cell(kind: str, text: str, look: str) -> str:
    named = f' class="{look}"' if look else ""
    return f"<{kind}{named}>{inline(text)}</{kind}>"


def _figure(picture: Picture) -> str:
    caption = escape(picture.caption.replace("`", ""), quote=True)
    return (
        f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{_svg(picture.figure)}">'
        f"<figcaption>{inline(picture.caption)}</figcaption></figure>"
    )


def _svg(figure: Any) -> str:
    """A figure as SVG in base64; the same figure gives the same text."""
    buffer = io.BytesIO()
    with styled():
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return base64.b64encode(buffer.getvalue()).decode("ascii")
