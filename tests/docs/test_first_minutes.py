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
ABSENT = (
    "pytest",
    "jax",
    "starlette",
    "hatchling",
    "martensite_app",
    "martensite_export",
    "martensite_studies",
    "martensite_control",
    "martensite_hardware",
    "martensite_sweep",
    "martensite_testing",
)
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
for convert in (result.to_xarray, result.to_pandas):
    try:
        convert()
    except ms.InputError as error:
        assert "pip install 'martensite[xarray]'" in str(error), error
    else:
        raise SystemExit("xarray is no part of the core")
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
EXPORT = """
import martensite as ms
assert (dir(ms.export), getattr(ms.export, "__path__", None)) == ([], None)
try:
    ms.export.to_fmu(ms.load("wire.toml"), "wire.fmu")
except ms.InputError as error:
    assert str(error).endswith("not installed; run `pip install 'martensite[export]'`."), error
else:
    raise SystemExit("exports are no part of the core")
"""
SWEEP = """
import martensite as ms
assert "size_wire" in dir(ms.design) and not {"run_sweep", "SweepTable", "tune_model"} & set(dir(ms.design))
assert "plot_fit" in dir(ms.plot) and "plot_sweep" not in dir(ms.plot)
assert ms.design.size_wire and ms.design.StoppedError
for ask in (lambda: ms.design.run_sweep("wire.toml", over=["diameter=1..2 mm:2"]), lambda: ms.plot.plot_pareto):
    try:
        ask()
    except ms.InputError as error:
        assert str(error).endswith("not installed; run `pip install 'martensite[sweep]'`."), error
    else:
        raise SystemExit("sweeps are no part of the core")
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


def call(python: Path, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """What a process of that environment says."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    whole = [str(python), *words]
    return subprocess.run(whole, cwd=folder, env=clean, capture_output=True, text=True, check=False)


def ask_all(python: Path, folder: Path, *lines: str) -> list[Any]:
    """Exit code, output and errors of some command lines, one after the other in a process of that environment."""
    code = (
        "import json; from typer.testing import CliRunner; from martensite.cli import app\n"
        f"found = [CliRunner().invoke(app, line.split()) for line in {lines}]\n"
        "print(json.dumps([[one.exit_code, one.stdout, one.stderr] for one in found]))"
    )
    done = call(python, folder, "-c", code)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("code", [TAB, RUN, WRONG, EXPORT, SWEEP], ids=["tab", "run", "wrong", "export", "sweep"])
def test_it_works_without_any_extra(python: Path, folder: Path, code: str) -> None:
    done = call(python, folder, "-c", code)
    assert done.returncode == 0, done.stderr


def test_a_law_of_ones_own_conforms(python: Path, folder: Path, tmp_path: Path) -> None:
    unpack_wheel(ROOT / "testing", tmp_path, tmp_path)
    done = call(python, tmp_path, "-m", "martensite", "conform", str(folder / "linear_strips.py"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "linear-strips" in done.stdout


def test_exports_say_what_brings_them(python: Path, folder: Path) -> None:
    need = "This needs `martensite-export`, which is not installed; run `pip install 'martensite[export]'`."
    for answer in ask_all(python, folder, "export c wire.toml", "export --help", "export"):
        assert answer == [2, "", f"error: {need}\n"]


def test_a_shell_that_completes_words_of_absent_exports_is_told_nothing(python: Path, folder: Path) -> None:
    code = "import os; os.environ |= dict(_MARTENSITE_COMPLETE='complete_bash', COMP_WORDS='martensite export ', "
    done = call(python, folder, "-c", code + "COMP_CWORD='2'); from martensite.cli import main; main()")
    assert (done.stdout.strip(), done.stderr) == ("", "")


def test_exports_are_added_by_their_wheel(python: Path, folder: Path, tmp_path: Path) -> None:
    unpack_wheel(ROOT / "export", tmp_path, tmp_path)  # a process begins to look in the folder it is called in
    words = ["export", "fmu", str(folder / "wire.toml"), "--sources-only"]
    done = call(python, tmp_path, "-m", "martensite", *words)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(tmp_path / "wire.fmu") as made:
        assert "modelDescription.xml" in made.namelist()
    done = call(python, tmp_path, "-c", "import martensite as ms; print(ms.export.Fmu.__module__, len(dir(ms.export)))")
    assert done.stdout.split()[0] == "martensite_export.fmu.archive" and int(done.stdout.split()[1]) > 20


def test_sweeps_say_what_brings_them(python: Path, folder: Path) -> None:
    need = "This needs `martensite-sweep`, which is not installed; run `pip install 'martensite[sweep]'`."
    for answer in ask_all(
        python, folder, "sweep wire.toml --over diameter=1..2", "sensitivity --help", "pareto", "design wire.toml"
    ):
        assert answer == [2, "", f"error: {need}\n"]


def test_tuning_says_what_brings_it(python: Path, folder: Path) -> None:
    need = "This needs `martensite-control`, which is not installed; run `pip install 'martensite[control]'`."
    (answer,) = ask_all(python, folder, "tune wire.toml")
    assert answer == [2, "", f"error: {need}\n"]


def test_suites_say_what_brings_them(python: Path, folder: Path) -> None:
    need = "This needs `martensite-testing`, which is not installed; run `pip install 'martensite[testing]'`."
    (answer,) = ask_all(python, folder, "conform brinson")
    assert answer == [2, "", f"error: {need}\n"]


def test_sweeps_are_added_by_their_wheel(python: Path, folder: Path, tmp_path: Path) -> None:
    without = call(python, folder, "-m", "martensite", "--help").stdout
    unpack_wheel(ROOT / "sweep", tmp_path, tmp_path)
    assert call(python, tmp_path, "-m", "martensite", "--help").stdout == without
    assert "--over NAME=NUMBERS" in call(python, tmp_path, "-m", "martensite", "sweep", "--help").stdout
    done = call(
        python, tmp_path, "-c", "import martensite as ms; print(ms.design.run_sweep.__module__, dir(ms.design))"
    )
    assert done.stdout.startswith("martensite_sweep.api ") and "'run_sweep'" in done.stdout


def test_the_studies_are_offered(python: Path, folder: Path) -> None:
    for code, said, refusal in ask_all(python, folder, "study", "study migaone", "cite migaone"):
        assert (code, said) == (2, "")
        assert refusal.startswith("error: No study ")
        assert "; `pip install 'martensite[studies]'` brings " in refusal
        assert refusal.count("\n") == 1


def test_the_demonstration_needs_no_study(python: Path, folder: Path) -> None:
    done = call(python, folder, "-m", "martensite", "demo")
    assert done.returncode == 0, done.stderr
    assert "pip install 'martensite[studies]'" in done.stdout
    assert (folder / "migaone.nc").stat().st_size and (folder / "migaone.png").stat().st_size


def test_a_study_of_ones_own_is_found(python: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(STUDY)
    about = tmp_path / "mine-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[martensite.studies]\nmine = mine\n")
    assert "Hooke" in call(python, tmp_path, "-m", "martensite", "study").stdout
    assert "1 reproduced" in call(python, tmp_path, "-m", "martensite", "study", "mine").stdout
    done = call(python, tmp_path, "-m", "martensite", "study", "migaone")
    assert (done.returncode, "martensite[studies]" in done.stderr) == (2, True)


def test_nothing_else_is_there(python: Path, folder: Path) -> None:
    code = (
        f"import importlib.util as u; print([n for n in {ABSENT} if u.find_spec(n)], bool(u.find_spec('martensite')))"
    )
    assert call(python, folder, "-c", code).stdout == "[] True\n"


def test_a_missing_dependency_would_be_noticed(python: Path, folder: Path) -> None:
    blocked = "import sys; sys.modules['matplotlib'] = None\n" + RUN
    assert call(python, folder, "-c", blocked).returncode != 0
