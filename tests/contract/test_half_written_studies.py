"""A half-written study fails alone, with one sentence.

Source of truth: studies in a temporary folder that is added to the package, each broken in one way.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from command import Command

import martensite.studies
import martensite.studies.base
from martensite.base.errors import InputError
from martensite.base.registry import Registry
from martensite.studies.base import load_studies, load_study, study_names
from martensite.testing.conformance import check_conformance

STUDY = Command("study")
BROKEN = {
    "half_syntax": "invalid syntax (line 10 of ",
    "half_import": "No module named 'nowhere'",
    "half_claims": "claims.toml",
    "half_printed": "printed.toml",
    "half_results": "KeyError: ",
}
"""Folder of each broken study, and words of its sentence."""


def break_study(folder: Path) -> None:
    """Copy a study that works into a folder, under the name of the folder, and break it."""
    source = Path(str(import_module("martensite.studies.wire_heating").__file__)).parent
    shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__"))
    file = folder / "__init__.py"
    text = file.read_text().replace('register("wire-heating")', f'register("{folder.name}")')
    match folder.name:
        case "half_syntax":
            text = text.replace("class WireHeating(TableStudy):", "class WireHeating(TableStudy:")
        case "half_import":
            text = text.replace("from martensite.studies.tables", "import nowhere\nfrom martensite.studies.tables")
        case "half_claims":
            (folder / "claims.toml").unlink()
        case "half_printed":
            (folder / "printed.toml").unlink()
        case "half_results":
            (folder / "results.json").write_text("{}")
    file.write_text(text)


@pytest.fixture
def broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The package of studies, with a folder of broken studies."""
    names = study_names()
    for name in BROKEN:
        break_study(tmp_path / name)
    monkeypatch.setattr(martensite.studies, "__path__", [*martensite.studies.__path__, str(tmp_path)])
    registry: Registry[martensite.studies.base.AbstractStudy] = Registry("study", "martensite.studies")
    for name in names:
        registry.register(name)(type(load_study(name)))
    monkeypatch.setattr(martensite.studies.base, "STUDIES", registry)
    yield
    for name in BROKEN:
        martensite.studies.__dict__.pop(name, None)
        sys.modules.pop(f"martensite.studies.{name}", None)


def test_the_other_studies_load(broken: None) -> None:
    studies, failures = load_studies()
    assert {"migaone", "wire-heating", "half_results"} <= {one.key for one in studies}
    assert len(failures) == len(BROKEN) - 1  # results are read later
    for name, words in BROKEN.items():
        if name != "half_results":
            (sentence,) = [one for one in failures if name in one]
            assert words in sentence and "\n" not in sentence
    for name in ("half_syntax", "half_import", "half_claims"):
        with pytest.raises(InputError, match="cannot be imported"):
            load_study(name)


def test_the_command_lists_the_others_and_names_each_failure(broken: None) -> None:
    done = STUDY()
    assert done.exit_code == 0 and "migaone" in done.stdout and "half_" not in done.stdout
    lines = done.stderr.splitlines()
    assert len(lines) == len(BROKEN) and all(line.startswith("error: ") for line in lines)
    for name, words in BROKEN.items():
        assert [line for line in lines if name in line and words in line]
    assert STUDY("migaone").exit_code == 0
    both = STUDY("migaone", "half_results")
    assert both.exit_code == 1 and "MigaOne" in both.stdout and both.stderr.count("\n") == 1
    assert "half_claims" in STUDY.refused("half_claims")


def test_no_shipped_study_fails() -> None:
    studies, failures = load_studies()
    assert failures == []
    assert [one.key for one in studies if not check_conformance(type(one), "study").holds] == []


def test_conform_covers_studies(broken: None) -> None:
    found = Command("conform")("wire-heating")
    assert found.exit_code == 0 and "study `wire-heating` conforms: 4 checks passed" in found.stdout
    found = Command("conform")("half_results")
    assert found.exit_code == 1 and "KeyError" in found.stdout
