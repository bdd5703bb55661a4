"""The bundle and the types of the page that are committed are what their sources give."""

import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from node_js import WEB, node


def test_the_bundle_is_the_newest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MARTENSITE_STATIC", raising=False)
    done = subprocess.run([node(), "test/fresh.mjs"], cwd=WEB, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_an_old_bundle_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bench.js").write_text("old")
    monkeypatch.setenv("MARTENSITE_STATIC", str(tmp_path))
    done = subprocess.run([node(), "test/fresh.mjs"], cwd=WEB, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "not the newest" in done.stderr


def write_types(*arguments: str, folder: Path = WEB) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(folder / "write_types.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def list_sources() -> list[Path]:
    """Return the Python files that types, constants and sentences follow from."""
    sys.path.insert(0, str(WEB))
    module = runpy.run_path(str(WEB / "write_types.py"))
    return list(dict.fromkeys([*module["SOURCES"], *module["CONSTANTS"], *module["SENTENCES"]]))


@pytest.mark.parametrize(
    ("old", "new"),
    [("summary: str", "summary: str | None"), ("FINER = ", "FINER = 1"), ("use later cycles", "use other cycles")],
)
def test_types_constants_and_sentences_of_the_page_are_those_of_python(tmp_path: Path, old: str, new: str) -> None:
    done = write_types("--check")
    assert done.returncode == 0, done.stderr
    for folder in ("form", "engine"):
        shutil.copytree(WEB / "src" / folder, tmp_path / "web" / "src" / folder)
    for script in WEB.glob("write_*.py"):
        shutil.copy(script, tmp_path / "web")
    for source in list_sources():
        place = tmp_path / source.relative_to(WEB.parent)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(source.read_text("utf-8").replace(old, new))
    done = write_types("--check", folder=tmp_path / "web")
    assert done.returncode == 1
    assert "not the newest" in done.stderr
