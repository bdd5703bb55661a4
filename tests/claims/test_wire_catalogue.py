"""The wire catalogue: every cell has a kind and a source, and the table agrees with itself.

Source of truth: the maker's conditions (172 MPa of pull, 69 MPa of cooling deformation), the
resistivity of NiTi, and which cells a named text prints. Two copies of a number, in the table and
here, cannot make a misprint right, but relations between columns can find one.
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from pathlib import Path

import pytest

from martensite.base.errors import InputError
from martensite.physics.materials.base import KINDS, load_material
from martensite.physics.materials.wires import UNITS, WireSize, load_wires, wire_catalogues
from martensite.scenario.citations import read_bibliography

CATALOGUE = load_wires("flexinol")
SIZES = list(CATALOGUE.sizes.values())
VERIFIED = {
    "0.025 mm": {"diameter", "resistance", "pull", "current", "cooling_70", "cooling_90"},
    "0.10 mm": {"pull", "cooling_70", "cooling_90"},
    "0.15 mm": {"current"},
    "0.25 mm": {"resistance"},
    "0.51 mm": {"resistance", "current"},
}
"""Cells that a text that was read prints; all others are recalled."""
NITI = load_material("flexinol-90").values
STORED = 65.0 * NITI["heat_capacity"].value + NITI["latent_heat"].value
"""Heat to warm and transform a kilogram [J/kg]."""
PULSES = [11.2, 4.7, 3.5, 2.3, 1.2, 1.2, 1.0, 0.77, 0.79, 0.74, 0.73, 0.67]
"""I²R · 1 s over the heat that is stored, thin to thick."""


def working_stress(size: WireSize) -> float:
    """Pull over section [MPa]."""
    return size.pull_force / size.section / 1e6


def test_flexinol_is_there_with_twelve_sizes_thin_to_thick() -> None:
    assert wire_catalogues() == ["flexinol"]
    assert len(SIZES) == 12
    assert all(a.diameter.value < b.diameter.value for a, b in pairwise(SIZES))


@pytest.mark.parametrize("size", SIZES, ids=lambda size: size.name)
class TestRow:
    """One size."""

    def test_every_cell_has_kind_source_and_unit(self, size: WireSize) -> None:
        assert list(size.cells()) == list(UNITS)
        for name, cell in size.cells().items():
            assert cell.kind in KINDS
            assert CATALOGUE.sources[cell.source].cite in read_bibliography()
            assert cell.unit == UNITS[name]
            assert cell.value > 0.0

    def test_only_what_a_text_prints_is_called_datasheet(self, size: WireSize) -> None:
        found = {name for name, cell in size.cells().items() if cell.kind == "datasheet"}
        assert found == VERIFIED.get(size.name, set())
        for name, cell in size.cells().items():
            if name in found:
                assert cell.note.startswith("secondary copy")
                assert cell.source != "tcf1140"
            else:
                assert (cell.kind, cell.source) == ("recalled", "tcf1140")

    def test_name_is_the_diameter_and_the_note_its_inches(self, size: WireSize) -> None:
        printed = re.search(r"printed as ([\d.]+) in$", size.diameter.note)
        assert printed is not None
        assert size.diameter.value == pytest.approx(float(printed[1]) * 0.0254, rel=1e-12)
        assert float(size.name.removesuffix(" mm")) == pytest.approx(1e3 * size.diameter.value, rel=0.03)

    def test_forces_belong_to_the_stresses_of_the_maker(self, size: WireSize) -> None:
        assert 171.9 <= working_stress(size) <= 174.3
        assert size.deformation_force / size.section / 1e6 == pytest.approx(69.0, rel=0.02)

    def test_resistivity_is_that_of_niti(self, size: WireSize) -> None:
        assert 72e-8 <= size.resistance.value * size.section <= 106e-8

    def test_warm_alloy_cools_faster(self, size: WireSize) -> None:
        assert size.cooling_90.value < size.cooling_70.value


@pytest.mark.parametrize(("size", "ratio"), list(zip(SIZES, PULSES, strict=True)))
def test_one_second_pulse_goes_from_loss_to_storage(size: WireSize, ratio: float) -> None:
    mass = NITI["density"].value * size.section
    pulse = size.current.value**2 * size.resistance.value
    places = 1 if ratio >= 1.0 else 2
    assert round(pulse / (mass * STORED), places) == ratio


def test_thicker_wire_costs_more_current_and_time() -> None:
    for name in ("pull", "deformation", "current", "cooling_70", "cooling_90"):
        column = [size.cells()[name].value for size in SIZES]
        assert column == sorted(column), name
    ohms = [size.resistance.value for size in SIZES]
    assert ohms == sorted(ohms, reverse=True)


def test_forces_are_weights() -> None:
    size = CATALOGUE["0.51 mm"]
    assert size.pull_force == pytest.approx(3.56 * 9.80665)
    assert size.section == pytest.approx(0.25 * math.pi * 0.508e-3**2)


SPOILED = [
    ('value = "891 g"', 'value = "891 mm"', "`mm` cannot be converted to `kg`"),
    ('value = "891 g"', 'value = "891"', "has no unit"),
    ('[sizes."0.25 mm"]', '[sizes."0.25 mm"]\nohms = {}', "has no `ohms`"),
    ('source = "workshop"', 'source = "nowhere"', "no source `nowhere`"),
    ('kind = "recalled"', 'kind = "known"', "no kind `known`"),
    ('current = { value = "45 mA"', 'currant = { value = "45 mA"', "Did you mean `current`"),
    ("limits = ", "limit = ", "Did you mean `limits`"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), SPOILED)
def test_spoiled_catalogue_is_refused(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    file = Path(load_wires.__code__.co_filename).parent / "catalogues/flexinol.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.toml") as caught:
        load_wires(tmp_path / "mine.toml")
    assert sentence in str(caught.value)


def test_unknown_names_are_answered_with_the_nearest() -> None:
    with pytest.raises(InputError, match="Did you mean `flexinol`"):
        load_wires("flexinoll")
    with pytest.raises(InputError, match=r"No wire size named `0\.26 mm`"):
        CATALOGUE["0.26 mm"]
    with pytest.raises(InputError, match="no catalogue file"):
        load_wires("nowhere.toml")
