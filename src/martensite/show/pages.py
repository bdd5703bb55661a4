"""Summaries as files: a page of HTML, or Markdown with a folder of figures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from martensite.base.errors import DataError
from martensite.base.files import make_folder, replace_together, write_file
from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.fit.fit_provenance import describe_program
from martensite.show.figures.style import write_figure
from martensite.show.html import render_page

if TYPE_CHECKING:
    from martensite.fit.fit import Fit
    from martensite.identify.chains.uncertainty import ChainUncertainty
    from martensite.identify.chains.validation import Validation
    from martensite.scenario.scenario import Scenario
    from martensite.search.profile import Profile

_NAME = re.compile(r"(`[^`]+`)")
_MARKUP = re.compile(r"<(?=[A-Za-z/!?])|`|(?<=\])\(")
"""Characters that begin a tag, a name in backquotes, or the address of a link."""
HTML, MARKDOWN = (".html", ".htm"), (".md", ".markdown")


def write_report(
    fit: Fit, path: str | Path, *, scenario: Scenario | None = None, title: str = "", profiles: Sequence[Profile] = ()
) -> list[Path]:
    """Write the report of a fit; existing files are replaced.

    Args:
        fit: a finished fit.
        path: an .html file with figures inside, or an .md file with figures in the folder `NAME_figures` next to it.
            The folder of the path must exist.
        scenario: the start scenario, if the fit has none; for title, file and material.
        title: headline; by default made of the names of the records.
        profiles: profile likelihoods of some parameters.

    Returns:
        The written files, the report first.
    """
    from martensite.show.summaries.fit import summarise_fit

    return write_page(summarise_fit(fit, scenario, profiles, title), path)


def write_model_report(
    validations: Sequence[Validation], path: str | Path, uncertainty: ChainUncertainty | None = None, title: str = ""
) -> list[Path]:
    """Write the report of a model on records; existing files are replaced.

    Args:
        validations: the same model on one or several records.
        path: an .html or .md file, as for `write_report`.
        uncertainty: adds parameters to the report, and bands to its figures.
        title: headline; by default made of the name of the model.

    Returns:
        The written files, the report first.
    """
    from martensite.show.summaries.identification import summarise_model

    return write_page(summarise_model(validations, uncertainty, title), path)


def write_page(summary: Summary, path: str | Path) -> list[Path]:
    """Write a summary with its figures; return the written files, the page first."""
    path, by = check_page_path(path), f"Written by {describe_program()}."
    if path.suffix.lower() in HTML:
        write_file(path, render_page(summary, by))
    else:
        with replace_together():
            _write_figures(summary, path)
            write_file(path, render_markdown(summary, by, find_figure_folder(path).name))
    return list_page_files(summary, path)


def list_page_files(summary: Summary, path: Path) -> list[Path]:
    """Return all files of `write_page`, the page first."""
    if path.suffix.lower() in HTML:
        return [path]
    folder = find_figure_folder(path)
    names = [block.name for block in summary.blocks if isinstance(block, Picture)]
    return [path, *(folder / f"{name}.png" for name in names)]


def check_page_path(path: str | Path) -> Path:
    """Return the path of a page."""
    path = Path(path)
    if path.suffix.lower() not in (*HTML, *MARKDOWN):
        raise DataError(f"A report ends in .html or .md, but this is `{path}`.")
    if not path.parent.is_dir():
        raise DataError(f"The folder of `{path}` does not exist; create it first.")
    return path


def find_figure_folder(path: Path) -> Path:
    """Return the folder of the figures of a page in Markdown."""
    return path.with_name(f"{path.stem}_figures")


def _write_figures(summary: Summary, path: Path) -> None:
    folder = find_figure_folder(path)
    for block in summary.blocks:
        if isinstance(block, Picture):
            make_folder(folder)
            write_figure(block.draw(), folder / f"{block.name}.png")


def render_markdown(summary: Summary, by: str, folder: str) -> str:
    """Return the whole text, with figures in the relative `folder`."""
    body = "\n\n".join(_render_block(block, folder) for block in summary.blocks)
    return f"# {_escape_text(summary.title)}\n\n{_escape_text(summary.lead)}\n\n{body}\n\n---\n\n{_escape_text(by)}\n"


def _render_block(block: Block, folder: str) -> str:
    match block:
        case Heading(title):
            return f"## {_escape_text(title)}"
        case Sentence(text):
            return _escape_text(text)
        case BulletList(items):
            return "\n".join(_render_items(items))
        case Notice(title, items):
            lines = [f"**{_escape_text(title)}**", "", *_render_items(items)]
            return "\n".join(f"> {line}".rstrip() for line in lines)
        case DataTable():
            return (f"### {_escape_text(block.folded)}\n\n" if block.folded else "") + _render_table(block)
        case Picture(name, _, caption):
            place = f"{quote(folder)}/{name}.png"
            alternative = _escape_text(caption.replace("`", ""))
            return f"![{alternative}]({place})\n\n*{_escape_text(caption)}*"


def _escape_text(text: str) -> str:
    """Return a line without mark-up except names in backquotes.

    Entities are portable between readers of Markdown, unlike backslashes.
    """
    parts = _NAME.split(" ".join(text.splitlines()))
    parts[::2] = [_MARKUP.sub(lambda found: f"&#{ord(found[0])};", part) for part in parts[::2]]
    return "".join(parts)


def _render_items(items: Sequence[str]) -> list[str]:
    return [f"- {_escape_text(item)}" for item in items]


def _render_table(table: DataTable) -> str:
    marks = ["---:" if k in table.right else "---" for k in range(len(table.head))]
    rows = [_render_row(table.head), _render_row(marks)]
    for k, (first, *others) in enumerate(table.rows):
        tag = f" **({table.tags[k]})**" if table.tags.get(k) else ""
        rows.append(_render_row([first + tag, *others]))
    return "\n".join(rows) + (f"\n\n{_escape_text(table.note)}" if table.note else "")


def _render_row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(_escape_text(cell).replace("|", "\\|") for cell in cells) + " |"
