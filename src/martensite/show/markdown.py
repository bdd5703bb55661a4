"""A summary as Markdown, with its figures in a folder beside it."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.parse import quote

from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary


def render_markdown(summary: Summary, by: str, folder: str) -> str:
    """The whole text; figures are looked for in `folder`, relative to it.

    Args:
        summary: what is written.
        by: the program that wrote it.
        folder: where the figures lie.
    """
    body = "\n\n".join(_render_block(block, folder) for block in summary.blocks)
    return f"# {summary.title}\n\n{summary.lead}\n\n{body}\n\n---\n\n{by}\n"


def _render_block(block: Block, folder: str) -> str:
    match block:
        case Heading(title):
            return f"## {title}"
        case Sentence(text):
            return text
        case BulletList(items):
            return "\n".join(_render_items(items))
        case Notice(title, items):
            lines = [f"**{title}**", "", *_render_items(items)]
            return "\n".join(f"> {line}".rstrip() for line in lines)
        case DataTable():
            return (f"### {block.folded}\n\n" if block.folded else "") + _render_table(block)
        case Picture(name, _, caption):
            place = f"{quote(folder)}/{name}.png"
            return f"![{caption.replace('`', '')}]({place})\n\n*{caption}*"


def _render_items(items: Sequence[str]) -> list[str]:
    return [f"- {item}" for item in items]


def _render_table(table: DataTable) -> str:
    marks = ["---:" if k in table.right else "---" for k in range(len(table.head))]
    rows = [_render_row(table.head), _render_row(marks)]
    for k, (first, *others) in enumerate(table.rows):
        tag = f" **({table.tags[k]})**" if table.tags.get(k) else ""
        rows.append(_render_row([first + tag, *others]))
    return "\n".join(rows) + (f"\n\n{table.note}" if table.note else "")


def _render_row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
