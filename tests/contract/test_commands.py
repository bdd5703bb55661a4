"""Commands are found by their folder.

Source of truth: a copy of the package, in a temporary folder, with one file more.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import martensite
from martensite.cli import app
from martensite.cli.app import Commands

GREET = '''\
"""`greet`: a command in one file."""

import typer

from martensite.cli.{place} import {group}
from martensite.cli.options import Json


@{group}.command("greet", rich_help_panel="Simulate")
def greet(json: Json = False) -> None:
    """Print a greeting."""
    typer.echo("Hello")
'''


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package, to which each test adds its files."""
    folder = tmp_path_factory.mktemp("tree")
    source = Path(next(iter(martensite.__path__)))
    shutil.copytree(source, folder / "martensite", ignore=shutil.ignore_patterns("__pycache__", "static*"))
    return folder


def call(tree: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Call a command of the copy in a new process."""
    environment = os.environ | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": ""}  # compile the copy once
    command = [sys.executable, "-m", "martensite", *words]
    return subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, check=False)


def test_a_command_is_one_file(tree: Path) -> None:
    folder = tree / "martensite/cli/commands"
    (folder / "greeting.py").write_text(GREET.format(place="app", group="app"))
    (folder / "export/greeting.py").write_text(GREET.format(place="commands.export", group="export"))
    assert call(tree, "greet").stdout == call(tree, "export", "greet").stdout == "Hello\n"
    section = call(tree, "--help").stdout.partition("Simulate:")[2].partition("\n\n")[0]
    assert "greet   Print a greeting." in section


def test_a_broken_command_fails_alone(tree: Path) -> None:
    broken = tree / "martensite/cli/commands/broken.py"
    broken.write_text('from martensite.cli.app import app\n\n@app.command("broken"\ndef broken(): ...\n')
    try:
        assert call(tree, "list", "law").returncode == 0
        shown = call(tree, "--help")
        assert shown.returncode == 0 and "broken.py` cannot be imported" in " ".join(shown.stdout.split())
        done = call(tree, "broken")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert "broken.py` cannot be imported" in done.stderr
    finally:
        broken.unlink()


def test_only_the_file_of_a_command_is_imported() -> None:
    code = (
        "import sys; from martensite.cli import app\n"
        "try: app(['run', '--help'])\n"
        "except SystemExit: pass\n"
        "start = 'martensite.cli.commands.'\n"
        "print(sorted(m.removeprefix(start) for m in sys.modules if m.startswith(start)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "['run']"


def test_every_command_has_a_group_of_the_help_and_its_own_name() -> None:
    from typer.main import get_command

    group = get_command(app)
    assert isinstance(group, Commands)
    names = group.list_commands(None)  # type: ignore[arg-type]
    assert {getattr(group.commands[name], "rich_help_panel", None) for name in names} == {*Commands.order}
    declared = [one.name for one in (*app.registered_commands, *app.registered_groups)]
    assert sorted(map(str, declared)) == sorted(names)
    assert group.folder.list_failures() == []
