"""A command of the CLI, called in this process: what it answers, and how it refuses."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import typer
from typer.testing import CliRunner, Result

from martensite.cli import app

WIDTH = 80
"""Columns of the terminal."""


def is_wide_rule(line: str) -> bool:
    """Whether a line is the rule of a table that is wider than the terminal."""
    return set(line) == {"─"} and len(line) > WIDTH


def list_commands() -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield all commands with their words."""

    def walk(words: tuple[str, ...], one: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
        yield words, one
        context = typer.Context(one)
        for name in one.list_commands(context) if hasattr(one, "list_commands") else ():
            yield from walk((*words, name), one.get_command(context, name))

    return walk((), typer.main.get_command(app))


class Command:
    """A command by its words, such as `Command("fit", "h")`."""

    def __init__(self, *words: str) -> None:
        self.words = words

    def __call__(self, *arguments: str) -> Result:
        """Call it, whatever comes."""
        runner = CliRunner(env={"COLUMNS": str(WIDTH)})
        return runner.invoke(app, [*self.words, *arguments])

    def fine(self, *arguments: str) -> str:
        """What it prints; it must succeed, and say nothing on standard error."""
        done = self(*arguments)
        assert (done.exit_code, done.stderr) == (0, ""), done.output
        assert [line for line in done.stdout.splitlines() if is_wide_rule(line)] == []
        return done.stdout

    def report(self, *arguments: str) -> dict[str, Any]:
        """What it prints as JSON."""
        return json.loads(self.fine(*arguments, "--json"))

    def refused(self, *arguments: str) -> str:
        """The one sentence with which it is refused."""
        done = self(*arguments)
        assert (done.exit_code, done.stdout) == (2, ""), done.output
        assert done.stderr.startswith("error: ")
        assert done.stderr.endswith("\n")
        assert done.stderr.count("\n") == 1
        return done.stderr
