"""The generated reference pages leave nothing out and let no markup through.

Source of truth: the registries, materials, bibliography and commands of the package.
"""

from __future__ import annotations

import pkgutil
import re
import sys
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest
from fences import ROOT, fences, pages

import martensite
import martensite.design.sweep
from martensite.base.registry import Registry
from martensite.physics.materials.base import load_material, material_names
from martensite.scenario import catalogue, citations

MARK = re.compile(r"<!-- from-declarations: ([\w-]+) -->")


@pytest.fixture(scope="module")
def extension() -> ModuleType:
    """The Sphinx extension that writes the pages."""
    sys.path.insert(0, str(ROOT / "docs" / "_ext"))
    try:
        return import_module("from_declarations")
    finally:
        sys.path.pop(0)


def test_every_part_and_parameter_is_there(extension: ModuleType) -> None:
    text = extension.SECTIONS["parts"]()
    for kind, registry in catalogue.list_registries().items():
        for name in registry.names():
            section = text.partition(f"(part-{kind}-{name})=")[2].partition("(part-")[0]
            assert section, f"{kind} {name}"
            for parameter in registry[name].declarations:
                assert f"| `{parameter}` |" in section


def all_registries() -> list[Registry[Any]]:
    """Every registry that a module of the package holds, or one of the sweeps."""
    found: dict[str, Registry[Any]] = {}
    packages = (martensite, martensite.design.sweep)
    for module in (m for one in packages for m in pkgutil.walk_packages(one.__path__, f"{one.__name__}.")):
        if module.name.endswith((".base", ".samples")) or "supervisor" in module.name:
            for one in vars(import_module(module.name)).values():
                if isinstance(one, Registry):
                    found[one.kind] = one
    return list(found.values())


def test_every_registry_has_a_reference(extension: ModuleType) -> None:
    """Studies have a page of their own, which takes long to compute."""
    text = "".join(extension.SECTIONS[name]() for name in ("parts", "blocks", "sweeps"))
    kinds = [one.kind for one in all_registries()]
    assert {"law", "measure", "sample", "backend", "supervisor", "block"} <= set(kinds)
    for registry in all_registries():
        if registry.kind != "study":
            missing = [name for name in registry.names() if f"`{name}`" not in text]
            assert missing == [], registry.kind


def test_every_number_of_every_material_is_there(extension: ModuleType) -> None:
    text = extension.SECTIONS["materials"]()
    for name in material_names():
        section = text.partition(f"(material-{name})=")[2].partition("(material-")[0]
        for number, entry in load_material(name).values.items():
            assert f"| `{number}` | {entry.text} |" in section


def test_every_work_is_there_without_markup(extension: ModuleType) -> None:
    text = extension.SECTIONS["bibliography"]()
    targets = re.findall(r"^\(bib-(.+)\)=$", text, re.MULTILINE)
    assert sorted(targets) == sorted(citations.read_bibliography())
    assert not re.search(r"[\\{}]", text)


def test_every_citation_leads_to_a_work(extension: ModuleType) -> None:
    """Those of the studies, whose claims take long to compute, are tested with them."""
    slow = ("studies", "figure-")
    texts = [write() for name, write in extension.SECTIONS.items() if not name.startswith(slow)]
    texts += [page.read_text(encoding="utf-8") for page in pages()]
    named = {key for text in texts for key in re.findall(r"\(\S*#bib-([\w-]+)\)", text)}
    assert named
    assert named <= set(citations.read_bibliography())


def test_every_command_is_there(extension: ModuleType) -> None:
    import typer

    from martensite.cli import app

    text = extension.SECTIONS["commands"]()
    for name in typer.main.get_command(app).list_commands(None):  # type: ignore[attr-defined]
        assert f"## `martensite {name}`" in text


def test_every_namespace_and_name_of_the_root_has_an_example(extension: ModuleType) -> None:
    """The cells run when the documentation is built."""
    parts = sys.modules["parts"]
    for namespace, names in parts.list_api().items():
        page = ROOT / "docs" / "reference" / "api" / f"{namespace}.md"
        cells = "\n".join(one.text for one in fences(page) if one.language.startswith("{code-cell}"))
        assert re.search(rf"\b{namespace}\b", cells), f"{page.name} has no example."
        missing = [name for name in names if namespace == parts.TOP and f"ms.{name}" not in cells]
        assert missing == [], f"{page.name} has no example of these names."


def test_marks_and_sections_match(extension: ModuleType) -> None:
    marks = [mark for page in pages() for mark in MARK.findall(page.read_text(encoding="utf-8"))]
    assert sorted(marks) == sorted(extension.SECTIONS)
