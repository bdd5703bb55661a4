"""The bundle and the types of the page that are committed are what their sources give."""

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


def test_the_types_of_forms_are_what_python_declares(tmp_path: Path) -> None:
    done = write_types("--check")
    assert done.returncode == 0, done.stderr
    shutil.copytree(WEB / "src" / "form", tmp_path / "web" / "src" / "form")
    shutil.copy(WEB / "write_types.py", tmp_path / "web")
    for name in ("src/martensite/scenario/catalogue.py", "src/martensite/app/forms/form_types.py"):
        place = tmp_path / name
        place.parent.mkdir(parents=True)
        text = (WEB.parent / name).read_text("utf-8")
        place.write_text(text.replace("summary: str", "summary: str | None"))
    done = write_types("--check", folder=tmp_path / "web")
    assert done.returncode == 1
    assert "not the newest" in done.stderr
