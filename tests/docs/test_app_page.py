"""The pages on the web bench are true: their programs run, and their reference leaves no call out.

Source of truth: a bench that the program starts itself, and the table of the calls.
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from fences import ROOT, fences

from martensite.app.routes import ROUTES

PAGES = [ROOT / "docs" / "howto" / f"app-{name}.md" for name in ("sessions", "api")]
CELL, PROGRAM = [block.text for page in PAGES for block in fences(page) if block.language == "python"]
(SCENARIO,) = [
    block.text.partition("\n")[2]
    for block in fences(ROOT / "docs" / "tutorial.md")
    if "%%writefile lift.toml" in block.text
]
APP = ROOT / "src" / "martensite" / "app"


@pytest.fixture
def lift(tmp_path: Path) -> None:
    """The scenario of the tutorial, in the folder in which a program of the page runs."""
    scenario = SCENARIO.partition("%%writefile lift.toml\n")[2] or SCENARIO
    (tmp_path / "lift.toml").write_text(scenario, encoding="utf-8")


@pytest.mark.usefixtures("lift")
def test_the_cell_of_a_notebook_shows_its_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(CELL, names)
    assert names["bench"].scenario.text == (tmp_path / "lift.toml").read_text("utf-8")


@pytest.mark.usefixtures("lift")
def test_the_program_runs(tmp_path: Path) -> None:
    """Two weights, two strokes; the heavier one is lifted a little less."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=tmp_path,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    light, heavy = (line.split() for line in done.stdout.splitlines())
    assert (light[:2], heavy[:2]) == (["500", "g:"], ["800", "g:"])
    assert 5.0 < float(light[2]) < 12.0
    assert light[2] != heavy[2]


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The generated sections of the page."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    bench = import_module("bench")
    return {"calls": bench.calls(), "addresses": bench.addresses()}


def test_every_call_is_there(written: dict[str, str]) -> None:
    assert "run" in ROUTES
    missing = [name for name in ROUTES if f"`{name}`\n: " not in written["calls"]]
    assert missing == []


def test_every_address_is_there(written: dict[str, str]) -> None:
    source = (APP / "site.py").read_text(encoding="utf-8")
    for address in ("/api/call/", "/api/jobs", "/api/files", "/watch"):
        assert address in source
        assert address in written["addresses"]
