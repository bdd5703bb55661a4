"""Markdown about the interface of the web bench, from the docstrings of its modules.

Calls are read, not imported: the server's packages need not be installed.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import martensite.app
from martensite.app.routes import ROUTES

APP = Path(martensite.app.__file__).parent


def docstring(path: Path) -> str:
    """The docstring of a module."""
    return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""


def addresses() -> str:
    """The addresses of the server, as `site.py` lists them."""
    listed = re.search(r"(?:^    .*\n)+", docstring(APP / "site.py"), re.MULTILINE)
    lines = listed[0].splitlines() if listed else []
    return "\n".join(["```text", *(line[4:] for line in lines), "```", ""])


def calls() -> str:
    """Every call: its name, and what its function says of it."""
    rows = sorted(ROUTES.items())
    return "\n".join(f"`{name}`\n: {_told(_explain_call(*place))}\n" for name, place in rows)


def _explain_call(module: str, function: str) -> str:
    """The docstring of a function that answers a call."""
    tree = ast.parse((APP / "calls" / f"{module}.py").read_text(encoding="utf-8"))
    found = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == function)
    return ast.get_docstring(next(found)) or ""


def _told(text: str) -> str:
    """A docstring as the body of a definition; what is no sentence as code."""
    parts = [_shown(part) for part in re.split(r"\n\s*\n", text)]
    return "\n\n".join(parts).replace("\n", "\n  ")


def _shown(part: str) -> str:
    return f"```text\n{part}\n```" if part.startswith("{") else part
