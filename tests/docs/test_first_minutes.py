"""A stranger's first ten minutes: names by tab, a run, a figure, a notebook cell, an own law.

Source of truth: what README.md and the page on laws promise. The wheel is built and unpacked into
an environment of its own that has what the core depends on and nothing else: no extra, no test
tool, no checkout. Everything happens in an empty folder.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
import venv
import zipfile
from collections.abc import Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path
from typing import Any

import pytest
from fences import README, ROOT, fences
from packaging.requirements import Requirement

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
ABSENT = ("pytest", "hatchling", "mujoco", "gymnasium", "openpyxl", "pyarrow", "emcee")
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
saved = ms.open_result("wire.nc")
assert abs(saved["temperature"] - result["temperature"]).max() < 1e-9 and saved.stroke == result.stroke
saved.plot().savefig("saved.png")
assert "temperature" in result.to_xarray()
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
NAMES = """
import martensite as ms
for inner in dir(ms):
    for name in dir(getattr(ms, inner)) if hasattr(getattr(ms, inner), "__path__") else ():
        getattr(getattr(ms, inner), name)
"""
EXTRA = """
import martensite as ms
try:
    ms.export.to_control(ms.load("wire.toml"))
except ms.InputError as error:
    assert "python-control, which is not installed; run `pip install" in str(error), error
    assert str(error).endswith("[control]'`."), error
else:
    raise SystemExit("python-control is no dependency")
"""
STUDY = """
from martensite.studies.base import STUDIES, AbstractStudy, Claim

@STUDIES.register("mine")
class Mine(AbstractStudy):
    title = "As the extension, so the force: Hooke"

    def claims(self):
        return [Claim("hooke", "force", "hooke1678", 2.0, 2.0, "N", 0.1, "reproduced", "linear", "last digit")]

    def figure(self, path):
        raise NotImplementedError
"""


def core_distributions(name: str = "martensite") -> Iterator[Distribution]:
    """What a distribution depends on without any extra, directly or not."""
    seen, left = {name}, [name]
    while left:
        found = distribution(left.pop())
        yield found
        declared = PROJECT["dependencies"] if found.name == "martensite" else found.requires or ()
        needed = map(Requirement, declared)
        wanted = {r.name for r in needed if not r.marker or r.marker.evaluate({"extra": ""})}
        left += wanted - seen
        seen |= wanted


def unpack_wheel(source: Path, folder: Path, target: Path) -> None:
    """Build the wheel of a source tree in a folder, and unpack it where it is imported from."""
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=source, check=True, capture_output=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(target)


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the wheel and the core's dependencies alone."""
    folder = tmp_path_factory.mktemp("environment")
    made = venv.EnvBuilder(symlinks=os.name != "nt").ensure_directories(folder / "venv")
    venv.create(made.env_dir)
    site = next((folder / "venv").glob("lib*/**/site-packages"))
    unpack_wheel(ROOT, folder, site)
    for one in core_distributions():
        tops = {file.parts[0] for file in one.files or ()} - {"..", "__pycache__"}
        for top in tops if one.name != "martensite" else ():
            if not (site / top).exists():
                (site / top).symlink_to(str(one.locate_file(top)))
    return Path(made.env_exe)


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


def call(python: Path, folder: Path, *words: str, **surroundings: str) -> subprocess.CompletedProcess[str]:
    """What a process of that environment says."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | surroundings
    whole = [str(python), *words]
    return subprocess.run(whole, cwd=folder, env=clean, capture_output=True, text=True, check=False)


def ask_all(python: Path, folder: Path, lines: str) -> dict[str, Any]:
    """Exit code, output and errors of `lines` of code, one after the other in a process of that environment."""
    code = (
        "import functools, json, typer.testing; from typer.testing import CliRunner; from martensite.cli import app\n"
        f"typer.testing._get_command = functools.cache(typer.testing._get_command)\n{lines}\n"
        "found = {line: CliRunner().invoke(app, line.split()) for line in lines}\n"
        "print(json.dumps({line: [one.exit_code, one.stdout, one.stderr] for line, one in found.items()}))"
    )
    done = call(python, folder, "-c", code)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("code", [TAB + NAMES, RUN + WRONG + EXTRA], ids=["names", "run"])
def test_it_works_without_any_extra(python: Path, folder: Path, code: str) -> None:
    done = call(python, folder, "-c", code)
    assert done.returncode == 0, done.stderr


WALK = """
def walk(group, words):
    for name in group.list_commands(None):
        one = group.get_command(None, name)
        yield [*words, name]
        yield from walk(one, [*words, name]) if hasattr(one, "list_commands") else ()
lines = [f"{' '.join(words)} --help" for words in walk(typer.testing._get_command(app), [])]
"""


def test_every_command_has_help(python: Path, folder: Path) -> None:
    found = ask_all(python, folder, WALK)
    assert len(found) > 40
    for line, (status, said, wrong) in found.items():
        assert (status, wrong) == (0, "") and "Usage: " in said, (line, said, wrong)
        assert "not installed" not in said, line


def test_commands_work_without_any_extra(python: Path, folder: Path) -> None:
    lines = (
        "study migaone",
        "sweep wire.toml --over diameter=0.1..0.2mm:2 --out wires.zarr",
        "export c wire.toml --out c",
        "export fmu wire.toml --sources-only",
        "check wire.toml",
        "hardware ports",
        "params wire.toml",
        "conform linear_strips.py",
        "demo",
    )
    found = ask_all(python, folder, f"lines = {lines}")
    for line, (status, said, wrong) in found.items():
        assert status == 0, (line, said, wrong)
    assert "linear-strips" in found["conform linear_strips.py"][1]
    with zipfile.ZipFile(folder / "wire.fmu") as made:
        assert "modelDescription.xml" in made.namelist()
    assert (folder / "migaone.nc").stat().st_size and (folder / "migaone.png").stat().st_size


def test_a_static_page_is_written_without_a_compiler(python: Path, folder: Path) -> None:
    (found,) = (python.parents[1]).glob("lib/**/martensite/**/flexinol_staircase.toml")
    scenario = str(found)
    bare = {"PATH": "", "CC": "", "XDG_CACHE_HOME": str(folder / "cache")}
    done = call(python, folder, "-m", "martensite", "app", scenario, "--static", "page", **bare)
    assert done.returncode == 0, done.stderr
    (module,) = (folder / "page" / "runs").glob("*.wasm")
    assert module.read_bytes().startswith(b"\0asm")


def test_a_study_of_ones_own_is_found(python: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(STUDY)
    about = tmp_path / "mine-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[martensite.studies]\nmine = mine\n")
    assert "Hooke" in call(python, tmp_path, "-m", "martensite", "study").stdout
    assert "1 reproduced" in call(python, tmp_path, "-m", "martensite", "study", "mine").stdout


def test_nothing_else_is_there(python: Path, folder: Path) -> None:
    code = (
        f"import importlib.util as u; print([n for n in {ABSENT} if u.find_spec(n)], bool(u.find_spec('martensite')))"
    )
    assert call(python, folder, "-c", code).stdout == "[] True\n"


def test_a_missing_dependency_would_be_noticed(python: Path, folder: Path) -> None:
    blocked = "import sys; sys.modules['matplotlib'] = None\n" + RUN
    assert call(python, folder, "-c", blocked).returncode != 0
