"""Markdown about the interface of the web bench, from the docstrings of its modules.

The modules are read, not imported: the server's packages need not be installed.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import martensite

APP = Path(martensite.__file__).parent / "app"


def docstring(path: Path) -> str:
    """The docstring of a module."""
    return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""


def addresses() -> str:
    """The addresses of the server, as `site.py` lists them."""
    listed = re.search(r"(?:^    .*\n)+", docstring(APP / "site.py"), re.MULTILINE)
    lines = listed[0].splitlines() if listed else []
    return "\n".join(["```text", *(line[4:] for line in lines), "```", ""])


def calls() -> str:
    """Every call: its name, and what its module says of it."""
    found = {path.stem: docstring(path) for path in sorted((APP / "calls").glob("[!_]*.py"))}
    return "\n".join(f"`{name}`\n: {_told(text)}\n" for name, text in found.items())


def _told(text: str) -> str:
    """A docstring as the body of a definition; what is no sentence as code."""
    parts = [_shown(part) for part in re.split(r"\n\s*\n", text)]
    return "\n\n".join(parts).replace("\n", "\n  ")


def _shown(part: str) -> str:
    return f"```text\n{part}\n```" if part.startswith("{") else part
