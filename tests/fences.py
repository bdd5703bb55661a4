"""Fenced code blocks of Markdown files, and where the files are."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
_FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Fence(NamedTuple):
    """One code block."""

    language: str
    """What follows the opening backticks."""
    text: str


def fences(path: Path) -> list[Fence]:
    """All code blocks of a page, in order."""
    found = _FENCE.findall(path.read_text(encoding="utf-8"))
    return [Fence(language.strip(), text) for language, text in found]


def pages() -> list[Path]:
    """Every page of the documentation."""
    folder = ROOT / "docs"
    built = folder / "_build"
    return sorted(p for p in folder.rglob("*.md") if built not in p.parents)


LONG = ("martensite size ", "martensite tune ")
"""Commands of README.md that take seconds and leave nothing that a later one needs."""


SERVING = "martensite app"
"""A command that goes on until it is interrupted."""


def apart(line: str, folder: Path) -> bool:
    """Whether a command has a test of its own: a long or endless one, or one on measured data."""
    return line.startswith((*LONG, SERVING)) or needs_data(line, folder)


def needs_data(line: str, folder: Path) -> bool:
    """Whether a command of a page reads or fetches a published measurement."""
    named = [folder / word for word in shlex.split(line) if word.endswith(".toml")]
    scenarios = [path.read_text(encoding="utf-8") for path in named if path.is_file()]
    return " data fetch " in line or any('"data:' in text for text in scenarios)
