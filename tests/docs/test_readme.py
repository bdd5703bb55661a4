"""What README.md shows is true: every line is run or checked, every file it names exists.

Commands and snippets are run in `test_reader.py`; long ones and those on measured data, here.

Source of truth: the README itself. A line that is neither run nor checked fails the test, so
that nothing is left out unnoticed.
"""

from __future__ import annotations

import re
import shlex
import shutil
import tomllib
from pathlib import Path

import pytest
from app_server import running
from command import Command
from fences import README, ROOT, SERVING, apart, fences

BLOCKS = fences(README)
SHELL = [line for block in BLOCKS if block.language == "bash" for line in block.text.splitlines() if line.strip()]
SCENARIOS = [block.text for block in BLOCKS if block.language == "toml"]
SERVERS = [line for line in SHELL if line.startswith(SERVING)]
COMMANDS = [line for line in SHELL if line.startswith("martensite ") and line not in SERVERS]
INSTALLS = ("pip install ", "uv pip install ")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder as a reader of the README has it: the files shown, and the examples."""
    for text in SCENARIOS:
        name = re.match(r"# (\S+\.toml)\n", text)
        assert name, "a TOML block must begin with its file name as a comment"
        (tmp_path / name[1]).write_text(text, encoding="utf-8")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    return tmp_path


def test_there_is_something_to_check() -> None:
    assert COMMANDS and SCENARIOS


def test_every_block_has_a_language_that_is_checked() -> None:
    assert {block.language for block in BLOCKS} <= {"bash", "python", "text", "toml"}


def test_every_shell_line_is_run_or_checked() -> None:
    known = ("martensite ", "make ", *INSTALLS)
    assert [line for line in SHELL if not line.startswith(known)] == []


@pytest.mark.slow  # commands of ten seconds
@pytest.mark.parametrize("line", [line for line in COMMANDS if apart(line, ROOT)])
def test_command_runs(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    done = Command(*shlex.split(line)[1:])()
    assert done.exit_code == 0, f"{line}: {done.output}"
    assert done.stdout.strip()


def test_the_bench_opens(tmp_path: Path) -> None:
    assert SERVERS == [SERVING]
    with running(tmp_path) as bench, bench.client() as client:
        assert "<title>martensite bench</title>" in client.get("/").text


def test_a_wrong_command_does_not_run() -> None:
    assert Command("run", "nothing.toml")().exit_code == 2


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith("make ")])
def test_make_target_exists(line: str) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^([a-z]+):", makefile, re.MULTILINE)
    assert set(line.split()[1:]) <= set(targets)


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith(INSTALLS)])
def test_installation_is_of_this_checkout(line: str) -> None:
    for word in line.partition("install ")[2].replace('"', "").split():
        path, _, extras = word.partition("[")
        project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
        assert path == "."
        assert not extras or set(extras.rstrip("]").split(",")) <= set(project["optional-dependencies"])


def test_local_links_and_images_exist() -> None:
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", README.read_text(encoding="utf-8"))
    assert targets
    assert [name for name in targets if not (ROOT / name).exists()] == []
