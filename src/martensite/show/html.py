"""A summary as HTML: a page with styles and figures inside, or a fragment for a notebook."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from html import escape
from pathlib import Path

from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.show.figures.style import format_svg

_STYLES = Path(__file__).parent / "page.css"
_CODE = re.compile(r"`([^`]+)`")
_HASH = re.compile(r"<code>(?=[0-9a-f]{64}</code>)")
LONG = 30
"""Smallest number of characters of a cell with line breaks."""
_PAGE = Path(__file__).parent / "page.html"


def render_page(summary: Summary, by: str) -> str:
    """Return a self-contained page that names its program."""
    sections = [block.title for block in summary.blocks if isinstance(block, Heading)]
    return _PAGE.read_text(encoding="utf-8").format(
        title=escape(summary.title),
        lead=_render_inline(summary.lead),
        by=escape(by),
        body="\n".join(map(_render_block, summary.blocks)),
        links=" ".join(f'<a href="#{_make_anchor(one)}">{escape(one)}</a>' for one in sections),
        styles=_STYLES.read_text(encoding="utf-8"),
    )


def render_fragment(summary: Summary) -> str:
    """Return title and blocks without styles."""
    lines = [f"<p><b>{escape(line)}</b></p>" for line in (summary.title,) if line]
    lead = [f"<p>{_render_inline(line)}</p>" for line in (summary.lead,) if line]
    return "\n".join([*lines, *lead, *map(_render_block, summary.blocks)])


def _render_inline(text: str) -> str:
    marked = _CODE.sub(r"<code>\1</code>", escape(text, quote=False))
    return _HASH.sub(r'<code class="hash">', marked)


def _render_block(block: Block) -> str:
    match block:
        case Heading(title):
            return f'<h2 id="{_make_anchor(title)}">{escape(title)}</h2>'
        case Sentence(text, tone):
            inner = _render_inline(text)
            return f"<p>{f'<b>{inner}</b>' if tone in ('caution', 'bad') else inner}</p>"
        case BulletList(items):
            return _render_items(items)
        case Notice(title, items, warning):
            kind = "notice warning" if warning else "notice"
            items = _render_items(items)
            return f'<div class="{kind}"><strong>{escape(title)}</strong>{items}</div>'
        case DataTable():
            table = _render_table(block)
            title = f"<details><summary>{escape(block.folded)}</summary>{table}</details>"
            return title if block.folded else table
        case Picture():
            return _render_picture(block)


def _make_anchor(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _render_items(items: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{_render_inline(item)}</li>' for item in items)}</ul>"


def _render_table(table: DataTable) -> str:
    head = "".join(_render_cell("th", text, k in table.right) for k, text in enumerate(table.head))
    rows: list[str] = []
    for k, row in enumerate(table.rows):
        cells = [_render_cell("td", text, j in table.right) for j, text in enumerate(row)]
        if table.tags.get(k):
            mark = f'<span class="tag">{escape(table.tags[k])}</span></td>'
            cells[0] = cells[0].removesuffix("</td>") + mark
        kind = ' class="held"' if table.tags.get(k) else ""
        rows.append(f"<tr{kind}>{''.join(cells)}</tr>")
    note = f'<p class="note">{_render_inline(table.note)}</p>' if table.note else ""
    body = "\n".join(rows)
    return f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>{note}'


def _render_cell(kind: str, text: str, number: bool) -> str:
    named = ' class="number"' if number else ' class="words"' if len(text) > LONG else ""
    return f"<{kind}{named}>{_render_inline(text)}</{kind}>"


def _render_picture(picture: Picture) -> str:
    caption = escape(picture.caption.replace("`", ""), quote=True)
    return (
        f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{_draw_svg(picture)}">'
        f"<figcaption>{_render_inline(picture.caption)}</figcaption></figure>"
    )


def _draw_svg(picture: Picture) -> str:
    return base64.b64encode(format_svg(picture.draw()).encode()).decode("ascii")
