"""Results on a terminal: a summary as text, or its numbers as JSON for programs."""

from __future__ import annotations

import json as formats
import os
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import typer

from martensite.base.summary import Summary, Tone

PIPE_WIDTH = 150
"""Width of tables without a terminal [columns]."""
_STYLES: dict[Tone, dict[str, Any]] = {
    "title": {"bold": True},
    "good": {"fg": "green"},
    "caution": {"fg": "yellow"},
    "bad": {"fg": "red"},
}


def print_summary(
    summary: Summary, json: bool = False, files: Iterable[Path] | None = None, *, wrap: bool = False
) -> None:
    """Print a summary, or its numbers as JSON.

    Args:
        summary: the result.
        json: print JSON.
        files: written files; None for commands without files.
        wrap: break sentences at 80 columns if the output is no terminal, which breaks them itself.
    """
    written = [str(path) for path in files or ()]
    if json:
        print_json(summary.data if files is None else summary.data | {"files": written})
        return
    if wrap and not sys.stdout.isatty():
        summary = summary.wrap_sentences()
    for line in summary.format_lines(measure_width(), paint_text):
        typer.echo(line)
    for name in written:
        typer.echo(f"wrote {name}")


def print_json(value: Any) -> None:
    """Print JSON; NaN and infinity become null."""
    from martensite.scenario.exact_text import convert_to_plain

    typer.echo(formats.dumps(convert_to_plain(value), indent=2, ensure_ascii=False))


def paint_text(text: str, tone: Tone) -> str:
    """Return a text in the colour of its tone; pipes receive no colour."""
    return typer.style(text, **_STYLES[tone]) if tone in _STYLES and text.strip() else text


def measure_width() -> int:
    """Return the width for tables [columns]."""
    if sys.stdout.isatty():
        return shutil.get_terminal_size().columns
    given = os.environ.get("COLUMNS", "")
    return int(given) if given.isdecimal() else PIPE_WIDTH
