"""The distributions of this repository belong together.

Source of truth: their declarations, `pyproject.toml` and those in the folders of `APART`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from martensite.studies.base import STUDIES

ROOT = Path(__file__).resolve().parents[2]
APART = ("app", "control", "export", "hardware", "studies", "sweep", "testing")
"""Folders of what is installed apart, which are extras too."""


def read_project(folder: str) -> dict[str, Any]:
    """What a folder declares."""
    return tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))["project"]


CORE = read_project("")
EXTRAS = CORE["optional-dependencies"]


@pytest.mark.parametrize("folder", APART)
def test_they_agree(folder: str) -> None:
    other = read_project(folder)
    for key in ("version", "requires-python", "license", "authors"):
        assert CORE[key] == other[key], key
    assert set(other["license-files"]) <= set(CORE["license-files"])
    assert (ROOT / "LICENSE").read_bytes() == (ROOT / folder / "LICENSE").read_bytes()


@pytest.mark.parametrize("folder", APART)
def test_each_asks_for_the_other_of_its_own_version(folder: str) -> None:
    assert f"martensite=={CORE['version']}" in read_project(folder)["dependencies"]
    assert f"martensite-{folder}=={CORE['version']}" in EXTRAS[folder]


@pytest.mark.parametrize("extra", ["control", "fmu", "gymnasium", "mujoco"])
def test_what_an_export_needs_brings_the_exports(extra: str) -> None:
    assert set(EXTRAS["export"]) < set(EXTRAS[extra])


def test_what_runs_sweeps_brings_them() -> None:
    (sweeps,) = EXTRAS["sweep"]
    assert sweeps in EXTRAS["cluster"] and sweeps in read_project("app")["dependencies"]


def test_every_study_has_its_entry_point() -> None:
    points = read_project("studies")["entry-points"][STUDIES.group]
    folders = {path.parent.name for path in (ROOT / "studies" / "src").rglob("claims.toml")}
    assert {module.rpartition(".")[2] for module in points.values()} == folders
    assert {name: STUDIES[name].__module__ for name in points} == points


def read_recipe() -> dict[str, dict[str, Any]]:
    """The packages of the recipe for conda, by their names."""
    yaml = pytest.importorskip("yaml")  # of the documentation's tools
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text("utf-8"))
    assert recipe["context"]["version"] == CORE["version"]
    return {output["package"]["name"]: output for output in recipe["outputs"]}


@pytest.mark.parametrize("folder", ("", *APART))
def test_the_recipe_for_conda_asks_for_the_same(folder: str) -> None:
    project = read_project(folder)
    made = read_recipe()[project["name"]]
    pinned = [line.replace("==${{ version }}", f"=={CORE['version']}") for line in made["requirements"]["run"]]
    wanted = [f"python{project['requires-python']}", *(d.partition(";")[0] for d in project["dependencies"])]
    assert [line.replace(" ", "") for line in pinned] == [line.replace(" ", "").lower() for line in wanted]
    assert f"install {f'./{folder}' if folder else '.'} " in made["build"]["script"]


def test_a_recipe_that_asks_for_less_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CORE, "version", "0.0.0")
    with pytest.raises(AssertionError):
        read_recipe()
