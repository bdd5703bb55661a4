"""Materials: what a file says is what is read, and what is wrong is said in one sentence."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from martensite.base.errors import InputError
from martensite.physics.materials.base import NAMES, load_material, material_names

SOUND = """
title = "T"
summary = "S"
limits = "L"
[sources.a]
cite = "martensite"
text = "a source"
[sources.spare]
cite = "liang1990"
text = "stands behind no number"
[values]
E_A = { value = "75 GPa", kind = "assumed", source = "a", where = "page 3", note = "why" }
A_s = { value = "68 °C", kind = "recalled", source = "a" }
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", material_names())
def test_every_shipped_material_loads(name: str) -> None:
    material = load_material(name)
    assert material.name == name
    assert material.values
    assert all(number.unit == NAMES[key][0] for key, number in material.values.items())


def test_numbers_are_si_and_carry_their_origin(tmp_path: Path) -> None:
    material = load_material(write(tmp_path, SOUND))
    number = material.values["E_A"]
    assert (number.value, number.unit, number.text) == (75e9, "Pa", "75 GPa")
    assert (number.kind, number.source, number.where, number.note) == ("assumed", "a", "page 3", "why")
    assert material.values["A_s"].value == pytest.approx(341.15)


def test_only_sources_behind_a_number_are_cited(tmp_path: Path) -> None:
    assert load_material(write(tmp_path, SOUND)).cites() == ["martensite"]


def test_relative_file_is_found_in_the_given_folder(tmp_path: Path) -> None:
    write(tmp_path, SOUND)
    assert load_material("mine.toml", tmp_path).name == "mine"


def test_reading_needs_neither_pint_nor_numpy() -> None:
    code = (
        "import sys; from martensite.physics.materials.base import load_material, material_names;"
        "[load_material(n) for n in material_names()];"
        "sys.exit(bool({'pint', 'numpy'} & sys.modules.keys()))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


SPOILED = [
    ("[values]", "[values]\nE_B = { value = '1 GPa', kind = 'assumed', source = 'a' }", "`E_A`"),
    ('"75 GPa"', '"75 MPa/K"', "`MPa/K` cannot be converted to `Pa`"),
    ('"75 GPa"', '"75"', "has no unit"),
    ('"75 GPa"', "75e9", "must be text in quotes"),
    ('kind = "assumed", ', "", "needs `kind`"),
    ('kind = "recalled"', 'kind = "guess"', "no kind `guess`"),
    ('source = "a" }', 'source = "b" }', "no source `b`"),
    ('note = "why"', 'notes = "why"', "Did you mean `note`"),
    ('title = "T"', 'titel = "T"', "Did you mean `title`"),
    ('title = "T"', "title = T", "not valid TOML"),
    ('cite = "martensite"', "", "needs `cite`"),
]


@pytest.mark.parametrize("old, new, expected", SPOILED)
def test_spoiled_file_is_refused_with_a_sentence(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in SOUND
    with pytest.raises(InputError) as caught:
        load_material(write(tmp_path, SOUND.replace(old, new, 1)))
    assert expected in str(caught.value)
    assert "mine.toml" in str(caught.value)


def test_misspelt_name_names_the_nearest() -> None:
    with pytest.raises(InputError, match="Did you mean `flexinol-90`"):
        load_material("flexinol90")


def test_missing_file_is_named() -> None:
    with pytest.raises(InputError, match=r"no material file `nowhere\.toml`"):
        load_material("nowhere.toml")
