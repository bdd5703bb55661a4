"""Pages about a source are built from what its studies found, and say the same things in the same order.

Source of truth: the numbers that studies come with; of the few that are typed, laws and materials of the package.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from fences import ROOT, fences

from martensite.physics.materials.base import load_material
from martensite.studies.base import load_study
from martensite.studies.tables import printed_numbers

FOLDER = ROOT / "docs" / "sources"
PAGES = sorted(path for path in FOLDER.glob("*.md") if path.stem != "index")
SECTIONS = [
    *("Run it", "Claims and verdicts", "Misprints", "Contradictions", "Assumptions", "Recommended values"),
    *("Beyond the paper", "Reproduce and cite"),
]
FIELD = re.compile(r"\{\{([a-z-]+): .+?\}\}")
PUBLIC = re.compile(r"(?:from|import) (page_setup|martensite as ms|math|numpy as np|matplotlib\.pyplot as plt)\b")
SHEET = load_material("migaone-15").values
SPRING = printed_numbers("platform")
MEAN = SPRING.coil_diameter - SPRING.diameter
RATE = SPRING.G_M * SPRING.diameter**4 / (8 * MEAN**3 * SPRING.turns)
CONTRACTION = SPRING.height - SPRING.turns * SPRING.diameter
HEATED, MOTOR = printed_numbers("wire_heating"), printed_numbers("sommerfeld")
FINGER = printed_numbers("finger")
SEARCHED = {row.name: row.value for row in printed_numbers("finger_calibration").searched}
TYPED = {
    "platform": {
        "837 J/(kg K)": SHEET["heat_capacity"].value,
        "24.2 kJ/kg": SHEET["latent_heat"].value / 1e3,
        "15 mm": 1e3 * SPRING.turns * SPRING.diameter,
        "60 mm": 1e3 * SPRING.height,
        "574 MPa": RATE * CONTRACTION * 8 * math.sqrt(3) * MEAN / (math.pi * SPRING.diameter**3) / 1e6,
    },
    "sommerfeld": {
        "24.2 kJ/kg": SHEET["latent_heat"].value / 1e3,
        "13 times": MOTOR.constant**2 / MOTOR.resistance / MOTOR.friction,
        "1.3 Ω": HEATED.resistance_A * HEATED.length,
        "1.5 Ω": HEATED.resistance_M * HEATED.length,
    },
    "finger": {
        "6500 kg/m³": load_material("finger-mas").values["density"].value,
        "319.75 K": SEARCHED["T_L"] - SEARCHED["sigma_L"] / SEARCHED["dsigma_dT"],
        "12.5 MPa/K": FINGER.latent_heat * 6500.0 / (325.0 * FINGER.eps_T) / 1e6,
        "10.6 mm": (250.0 - (1 + FINGER.eps_T) * 500.0 * FINGER.length) / 2,
    },
    "migaone": {
        "34 MPa": 0.4 * 9.80665 / (math.pi / 4 * 0.381e-3**2) / 1e6,
        "837 J/(kg K)": SHEET["heat_capacity"].value,
        "24.2 kJ/kg": SHEET["latent_heat"].value / 1e3,
    },
}
"""Numbers that stand on a page as they are, with where they come from."""


@pytest.fixture(scope="module")
def sources() -> Iterator[ModuleType]:
    """The helper that writes these pages."""
    folder = str(ROOT / "docs" / "_ext")
    sys.path.insert(0, folder)
    yield import_module("sources")
    sys.path.remove(folder)


def read(page: Path) -> str:
    return page.read_text("utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_number_is_one_of_a_study(page: Path, sources: ModuleType) -> None:
    text = read(page)
    named = set(FIELD.findall(text))
    assert named
    if all(load_study(name).load_shipped_answer() for name in named):  # what is not shipped takes minutes
        assert not FIELD.search(sources.with_numbers(text))


@pytest.mark.parametrize("field", ["{{migaone: no_such_number:.1f}}", "{{migaone: claims[nothing].computed}}"])
def test_a_number_of_no_study_is_noticed(field: str, sources: ModuleType) -> None:
    with pytest.raises(KeyError):
        sources.with_numbers(field)


def test_numbers_are_written_as_in_a_text(sources: ModuleType) -> None:
    assert sources.with_numbers("{{migaone: printed.surface:.2e}} m²") == "3.26·10⁻⁵ m²"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_have_the_same_sections(page: Path) -> None:
    assert re.findall(r"^## (.+)$", read(page), re.MULTILINE) == SECTIONS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_import_what_is_public(page: Path) -> None:
    cells = [fence.text for fence in fences(page) if fence.language.startswith("{code-cell}")]
    lines = [line for cell in cells for line in cell.splitlines() if re.match(r"(?:from|import) ", line)]
    assert lines
    assert [line for line in lines if not PUBLIC.match(line)] == []


@pytest.mark.parametrize(("page", "words"), [(page, words) for page, known in TYPED.items() for words in known])
def test_a_typed_number_is_right(page: str, words: str) -> None:
    digits = words.partition(" ")[0]
    assert words in read(FOLDER / f"{page}.md").replace("\n", " ")
    assert abs(TYPED[page][words] - float(digits)) <= 0.5 * 10.0 ** -len(digits.partition(".")[2])
