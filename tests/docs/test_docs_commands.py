"""Every `martensite …` command line in the documentation is one that the program accepts.

Lines in code blocks are parsed by the command line itself, options and arguments included, but
not run: code cells are run when the documentation is built. Commands named in running text
must at least exist. Source of truth: the registered commands.
"""

from __future__ import annotations

import re
import shlex
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer
from fences import ROOT, fences, pages

import martensite

SHELL = re.compile(r"^!?(martensite [^#\n]*)", re.MULTILINE)
INLINE = re.compile(r"`martensite ([a-z]+)[^`]*`")
USAGE = typer.BadParameter.__mro__[1]
"""The error of a command line that does not parse."""


def shown() -> list[tuple[str, str]]:
    """(page, command line) for every command in a code block."""
    return [
        (str(page.relative_to(ROOT)), line.strip().removesuffix(" || true"))
        for page in pages()
        for fence in fences(page)
        if fence.language != "toml"
        for line in SHELL.findall(fence.text)
    ]


@cache
def program() -> Any:
    """The command line as an object."""
    from martensite.cli import app

    return typer.main.get_command(app)


def parse(line: str) -> None:
    """Parse a command line down to its last subcommand; raises on anything unknown."""
    command = program()
    name, *arguments = shlex.split(line)
    while arguments and hasattr(command, "commands") and arguments[0] in command.list_commands(None):
        name, *arguments = arguments
        command = command.get_command(None, name)
        arguments = getattr(command, "prepend_command", list)(arguments)
    if hasattr(command, "commands") and not command.invoke_without_command:
        raise LookupError(f"no such command: {line}")
    command.make_context(name, arguments)


def find_fault(line: str) -> str | None:
    """Return why a command line does not parse; None if it does."""
    try:
        parse(line)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


def test_command_lines_parse() -> None:
    found = [(page, line, find_fault(line)) for page, line in shown()]
    assert len(found) > 100
    assert [one for one in found if one[2] is not None] == []


@pytest.mark.parametrize("line", ["martensite fly wire.toml", "martensite run wire.toml --sett x=1", "martensite run"])
def test_a_wrong_command_line_does_not_parse(line: str) -> None:
    with pytest.raises((LookupError, USAGE)):
        parse(line)


def test_commands_named_in_text_exist() -> None:
    named = [(page, name) for page in pages() for name in INLINE.findall(page.read_text(encoding="utf-8"))]
    assert len(named) > 100
    assert [(str(page), name) for page, name in named if name not in program().list_commands(None)] == []


PUBLIC = re.compile(r"from martensite\.(\w+) import|from martensite import|import martensite as ms\b")


def list_imports(page: Path) -> list[str]:
    """Lines of a page's Python that import from this package."""
    blocks = [f.text for f in fences(page) if "python" in f.language]
    return [one for text in blocks for one in text.splitlines() if re.match(r"\s*(from|import) martensite", one)]


def test_pages_import_public_names() -> None:
    """What a reader copies is promised to stay: names of `martensite` and of the packages that it offers."""
    found = [(str(page), one, PUBLIC.match(one.strip())) for page in pages() for one in list_imports(page)]
    assert len(found) > 10
    offered = {*dir(martensite), "boards", "scenario", None}
    assert [(page, one) for page, one, public in found if public is None or public[1] not in offered] == []


def test_toml_blocks_are_toml() -> None:
    texts = [f.text for page in pages() for f in fences(page) if f.language == "toml"]
    assert texts
    for text in texts:
        tomllib.loads(text)
