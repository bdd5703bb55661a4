"""The parts of the how-to pages, one of every kind, are one file each: they conform, and they run.

They are written into a folder of their own as the pages say, and tried there by a process of its
own, so that no other test sees what they register.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fences import ROOT

from martensite.testing.conformance import SUITES

PAGES = ("own-parts", "own-law", "own-mechanism", "own-wire")
_FILE = re.compile(r"%%writefile (\S+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILES = {
    name: text for page in PAGES for name, text in _FILE.findall((ROOT / f"docs/howto/{page}.md").read_text("utf-8"))
}
PARTS = [name for name in FILES if name.endswith(".py") or name == "my-wire.toml"]
SHOWN_BY_OTHERS = {"ends", "fluid", "check", "study", "experiment", "command", "exporter"}
"""Kinds made like another one: fluids and ends like a heat loss, a check like a supervisor; a study is a folder.
CONTRIBUTING describes experiments, commands and exporters."""
TRY = """
import json, sys
from martensite.testing import check_target

found = [(name, one) for name in sys.argv[1:] for one in check_target(name)]
print(json.dumps([[n, o.kind, o.name, [vars(f) for f in o.faults]] for n, o in found]))
"""

ASK = """
import json, sys
from typer.testing import CliRunner
from martensite.cli import app

answers = [CliRunner().invoke(app, words) for words in json.loads(sys.argv[1])]
print(json.dumps([[one.exit_code, one.stdout] for one in answers]))
"""


def call(folder: Path, *words: str) -> str:
    """What a process says that is started in the folder."""
    done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the files of the pages, and a cache of its own."""
    found = tmp_path_factory.mktemp("own")
    for name, text in FILES.items():
        (found / name).write_text(text, encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def findings(folder: Path) -> list[Any]:
    """File, kind, name and faults of every part."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        return json.loads(call(folder, "-c", TRY, *PARTS))


def test_there_is_one_of_every_kind(findings: list[Any]) -> None:
    assert {kind for _, kind, _, _ in findings} == set(SUITES) - SHOWN_BY_OTHERS
    assert {name for name, _, _, _ in findings} == set(PARTS)


@pytest.mark.parametrize("name", PARTS)
def test_a_part_in_one_file_keeps_its_promises(name: str, findings: list[Any]) -> None:
    assert [faults for file, _, _, faults in findings if file == name] == [[]]


RUNS = {
    "own_parts.toml": "tube warm still-air battery chirp",
    "own_loop.toml": "resistance-line strain-gauge super-twisting thermostat weak-driver",
}


@pytest.fixture(scope="module")
def answers(folder: Path, findings: list[Any]) -> dict[str, tuple[int, str]]:
    """Exit code and output of every command, from one process that keeps the cache."""
    lines = {
        "linear.toml": ["check", "linear.toml", "--import", "linear_strips.py"],
        "buffer.toml": ["check", "buffer.toml", "--import", "buffer_spring.py"],
        "spool17.toml": ["check", "spool17.toml"],
    }
    for scenario, names in RUNS.items():
        files = [file for file, _, name, _ in findings if name in names.split()]
        given = [word for file in files for word in ("--import", file)]
        lines[scenario] = ["run", scenario, *given, "--set", "run.duration=0.4 s", "--json", "--no-figure"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        return dict(zip(lines, json.loads(call(folder, "-c", ASK, json.dumps([*lines.values()]))), strict=True))


@pytest.mark.parametrize("scenario", RUNS)
def test_a_run_with_them_says_that_they_conform(scenario: str, answers: dict[str, tuple[int, str]]) -> None:
    status, said = answers[scenario]
    assert status == 0, said
    assert json.loads(said)["conformance"] == dict.fromkeys(RUNS[scenario].split(), "conforms")


def test_the_plain_files_run_too(answers: dict[str, tuple[int, str]]) -> None:
    for scenario in ("linear.toml", "spool17.toml"):
        status, said = answers[scenario]
        assert status == 0 and "valid" in said, said
    status, said = answers["buffer.toml"]
    assert status == 1 and "above the `stress_limit` of 172 MPa" in said  # as the page says
