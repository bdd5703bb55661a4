"""The two distributions of this repository belong together.

Source of truth: their declarations, `pyproject.toml` and `studies/pyproject.toml`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from martensite.studies.base import STUDIES

ROOT = Path(__file__).resolve().parents[2]
CORE, STUDIED = (
    tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))["project"] for folder in ("", "studies")
)


def test_they_agree() -> None:
    for key in ("version", "requires-python", "license", "license-files", "authors"):
        assert CORE[key] == STUDIED[key], key
    assert (ROOT / "LICENSE").read_bytes() == (ROOT / "studies" / "LICENSE").read_bytes()


def test_each_asks_for_the_other_of_its_own_version() -> None:
    assert STUDIED["dependencies"] == [f"martensite=={CORE['version']}"]
    wanted = [f"martensite-studies=={CORE['version']}"]
    assert CORE["optional-dependencies"]["studies"] == wanted


def test_every_study_has_its_entry_point() -> None:
    points = STUDIED["entry-points"][STUDIES.group]
    folders = {path.parent.name for path in (ROOT / "studies" / "src").rglob("claims.toml")}
    assert {module.rpartition(".")[2] for module in points.values()} == folders
    assert {name: STUDIES[name].__module__ for name in points} == points
