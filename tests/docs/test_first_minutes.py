"""A stranger's first ten minutes: names by tab, a run, a figure, a notebook cell, an own law.

Source of truth: what README.md and the page on laws promise. Everything happens in an empty folder,
in a process of its own that has the core's dependencies and none of the extras.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from fences import README, ROOT, fences

EXTRAS = (
    "jax starlette uvicorn distributed zarr control fmpy gymnasium mujoco pyarrow numpyro SALib"
)
PRELUDE = f"import sys\nsys.modules |= dict.fromkeys({EXTRAS.split()!r})\n"
"""A module that is None in `sys.modules` cannot be imported: as if it were not installed."""

TAB = """
import rlcompleter, martensite as ms
complete = rlcompleter.Completer({"ms": ms}).complete
names, k = [], 0
while (found := complete("ms.", k)) is not None:
    names.append(found.removeprefix("ms.").rstrip("("))
    k += 1
public = [name for name in names if not name.startswith("_")]
assert len(public) <= 45, public
assert {"run", "load", "Wire", "Result", "fit", "design", "plot"} <= set(public), public
"""
RUN = """
import martensite as ms
result = ms.run("wire.toml")
assert result["temperature"].max() > 340.0
assert len(repr(result).splitlines()) < 10
assert "<table" in result._repr_html_()
result.plot().savefig("wire.png")
result.save("wire.nc")
assert abs(ms.open_result("wire.nc")["temperature"].values - result["temperature"]).max() < 1e-9
"""
WRONG = """
import martensite as ms
try:
    ms.run(ms.load("wire.toml").single_system.element)
except ms.InputError as error:
    assert "Wire" in str(error), error
else:
    raise SystemExit("an element was run")
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty folder with the scenario of README.md and the law of the page on laws."""
    found = tmp_path_factory.mktemp("stranger")
    scenario = next(f.text for f in fences(README) if f.text.startswith("# wire.toml"))
    (found / "wire.toml").write_text(scenario, encoding="utf-8")
    page = (ROOT / "docs/howto/own-law.md").read_text("utf-8")
    law = page.partition("%%writefile linear_strips.py\n")[2].partition("```")[0]
    (found / "linear_strips.py").write_text(law, encoding="utf-8")
    return found


def call(folder: Path, code: str, *words: str) -> subprocess.CompletedProcess[str]:
    """What a process says that knows the core's dependencies alone."""
    whole = [sys.executable, "-c", PRELUDE + code, *words]
    return subprocess.run(whole, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("code", [TAB, RUN, WRONG], ids=["tab", "run", "wrong"])
def test_it_works_without_any_extra(folder: Path, code: str) -> None:
    done = call(folder, code)
    assert done.returncode == 0, done.stderr


def test_a_law_of_ones_own_conforms(folder: Path) -> None:
    words = ("conform", "linear_strips.py")
    done = call(folder, "from martensite.cli import main\nmain()", *words)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "linear-strips" in done.stdout


def test_a_missing_dependency_would_be_noticed(folder: Path) -> None:
    assert call(folder, "sys.modules['matplotlib'] = None\n" + RUN).returncode != 0
