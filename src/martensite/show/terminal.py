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
"""Width of the output without a terminal [columns]."""
_STYLES: dict[Tone, dict[str, Any]] = {
    "title": {"bold": True},
    "good": {"fg": "green"},
    "caution": {"fg": "yellow"},
    "bad": {"fg": "red"},
}


def print_summary(summary: Summary, json: bool = False, files: Iterable[Path] | None = None) -> None:
    """Print what there is to say of a result, or as JSON all its numbers; `files` is None where none is written."""
    written = [str(path) for path in files or ()]
    if json:
        print_json(summary.data if files is None else summary.data | {"files": written})
        return
    for line in summary.format_lines(measure_width(), paint_text):
        typer.echo(line)
    for name in written:
        typer.echo(f"wrote {name}")


def print_json(value: Any) -> None:
    """Print JSON; numbers that JSON does not have become null."""
    from martensite.scenario.exact_text import convert_to_plain

    typer.echo(formats.dumps(convert_to_plain(value), indent=2, ensure_ascii=False))


def paint_text(text: str, tone: Tone) -> str:
    """Return a text in the colour of its tone; nothing is coloured where no terminal shows it."""
    return typer.style(text, **_STYLES[tone]) if tone in _STYLES and text.strip() else text


def measure_width() -> int:
    """Return the columns that tables may take."""
    if sys.stdout.isatty():
        return shutil.get_terminal_size().columns
    given = os.environ.get("COLUMNS", "")
    return int(given) if given.isdecimal() else PIPE_WIDTH
