"""What the distribution declares, in its own file, in the recipe for conda and in the studies that it holds.

Source of truth: `pyproject.toml`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from martensite.studies.base import STUDIES

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def test_there_is_one_distribution() -> None:
    assert [path.parent for path in ROOT.glob("*/pyproject.toml")] == []
    assert not [line for extra in PROJECT["optional-dependencies"].values() for line in extra if "martensite-" in line]


def test_every_folder_of_studies_is_a_study() -> None:
    folders = {path.parent.name for path in (ROOT / "src/martensite/studies").rglob("claims.toml")}
    assert {STUDIES[name].__module__.rpartition(".")[2] for name in STUDIES.names()} == folders


def read_recipe() -> dict[str, Any]:
    """The package of the recipe for conda."""
    yaml = pytest.importorskip("yaml")  # of the documentation's tools
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text("utf-8"))
    assert recipe["context"]["version"] == PROJECT["version"]
    return recipe


def test_the_recipe_for_conda_asks_for_the_same() -> None:
    made = read_recipe()
    wanted = [f"python{PROJECT['requires-python']}", *(d.partition(";")[0] for d in PROJECT["dependencies"])]
    asked = [line.replace(" ", "") for line in made["requirements"]["run"]]
    assert asked == [line.replace(" ", "").lower() for line in wanted]


def test_a_recipe_of_another_version_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PROJECT, "version", "0.0.0")
    with pytest.raises(AssertionError):
        read_recipe()
