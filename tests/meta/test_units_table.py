"""The table of everyday units equals pint, so that a run without pint reads the same numbers.

What people write is read, or answered with a spelling that is read.

Source of truth: pint, and what is meant. Every spelling of the table is converted by pint and must give the same
factor and offset; every spelling used in a material file must be in the table.
"""

from __future__ import annotations

import re
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

import pint
import pytest

from martensite.base import units
from martensite.base.errors import DataError, UnitError
from martensite.physics.materials import base as materials
from martensite.physics.materials.base import NAMES
from martensite.scenario.scenario import load

MATERIALS = Path(materials.__file__).parent / "data"
EXAMPLES = Path(__file__).parents[2] / "examples"
REGISTRY: Any = pint.UnitRegistry()


@pytest.mark.parametrize("spelling", units.EVERYDAY)
def test_spelling_means_what_pint_says(spelling: str) -> None:
    unit, factor, offset = units.EVERYDAY[spelling]
    zero = REGISTRY.Quantity(0.0, spelling).to(unit).magnitude
    hundred = REGISTRY.Quantity(100.0, spelling).to(unit).magnitude
    assert zero == pytest.approx(offset, abs=1e-12)
    assert (hundred - zero) / 100.0 == pytest.approx(factor, rel=1e-12)


def test_comparison_can_fail() -> None:
    """A wrong factor is seen: the check above is not blind."""
    assert REGISTRY.Quantity(100.0, "mm").to("m").magnitude != pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("unit", sorted({unit for unit, _ in NAMES.values()}))
def test_canonical_units_need_no_pint(unit: str) -> None:
    assert units.EVERYDAY[unit] == (unit, 1.0, 0.0)


@pytest.mark.parametrize("path", sorted(MATERIALS.glob("*.toml")), ids=lambda path: path.stem)
def test_material_files_need_no_pint(path: Path) -> None:
    values = tomllib.loads(path.read_text(encoding="utf-8"))["values"]
    spelled = {re.sub(r"^\S+\s*", "", entry["value"]) or "1" for entry in values.values()}
    assert spelled <= units.EVERYDAY.keys()


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_need_no_pint(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its import takes longer than a short run: neither reading an example nor printing its results needs it."""
    monkeypatch.setattr(units, "_ask_pint", lambda spelling, unit: pytest.fail(f"`{spelling}` for `{unit}`"))
    if "[run]" in path.read_text(encoding="utf-8"):
        with suppress(DataError):  # measured data that are not on this machine
            for name, one in load(path).system.outputs().items():
                units.from_si(1.0, units.of_column(name, one.unit), one.unit)


@pytest.mark.parametrize("spelling", sorted({*units.EVERYDAY, "mW/mm^2", "N*mm", "rpm", "kJ/kg/K", "mg*cm^2", "1/min"}))
def test_products_of_units_agree_with_pint(spelling: str) -> None:
    """The same factor, or the same refusal; what the table cannot read is left to pint."""
    for unit in ("1", "m", "s", "K", "degC", "Pa", "N/m", "N*m", "W", "ohm*m", "Hz", "rad", "rad/s", "J/kg/K", "W/m^2"):
        with suppress(UnitError):
            expected = units._ask_pint(spelling, unit)
            assert units.find_conversion(spelling, unit) == pytest.approx(expected, rel=1e-12, abs=1e-15)
            continue
        with pytest.raises(UnitError):
            units.find_conversion(spelling, unit)


def test_readable_units_are_in_the_table() -> None:
    for declared, shown in units.READABLE.items():
        kelvin = "K" if declared == units.DEGREES else declared
        assert units.EVERYDAY[shown][0] == kelvin


MEANT = """
K degC: 22 C|22 deg C|22 Celsius;  K degF: 60 F;  K K: 300 k;  N gf: 500 g|500 grams|500 gm;  N kgf: 10 kg|10 Kg
N lbf: 1 lb|1 pound;  N ozf: 2 oz;  N N: 5 Newtons;  kg kg: 5 N;  kg g: 100 gf;  V V: 5 Volt|12 V DC|5 v;  A mA: 200 ma
A A: 2 Amps;  ohm ohm: 3 R|3 Ohm;  ohm kohm: 1 k;  m in: 3";  m thou: 6 mil;  m mm: 0.1 MM;  Pa MPa: 172 mpa
N/m lbf/in: 5 lb/in;  N/m gf/mm: 5 g/mm;  Hz 1/min: 30 rpm;  Hz Hz: 2 hz;  rad/s rpm: 2 Hz;  1 %: 4 pct;  s s: 1S
"""
"""Unit that is expected, spelling that is meant: what people write."""


def test_what_people_write_is_read() -> None:
    read = {
        "5 volts": 5.0,
        "0.1mm": 1e-4,
        "3 in": 0.0762,
        "2 amps": 2.0,
        "\u221210 °C": 263.15,
        "25 ksi": 25e3 * 6894.757293168,
    }
    wanted = dict(zip(read, ("V", "m", "m", "A", "K", "Pa"), strict=True))
    assert {text: units.parse_quantity(text, unit) for text, unit in wanted.items()} == pytest.approx(read)


@pytest.mark.parametrize("line", re.split(r";\s*|\n", MEANT.strip()))
def test_what_is_not_read_is_answered_with_what_is(line: str) -> None:
    unit, meant, written = re.split(r":? ", line, maxsplit=2)
    for text in written.split("|"):
        with pytest.raises(UnitError, match=f"Did you mean `{re.escape(meant)}`"):
            units.parse_quantity(text, unit)
    units.parse_quantity(f"1 {meant}", unit)


def test_what_cannot_be_meant_is_said() -> None:
    words = {"AWG 38": "copper wire, 0.101 mm", "24awg": "0.511 mm", "1,5 mm": "decimal point", "5 V": "to `m`.$"}
    for text, said in words.items():
        with pytest.raises(UnitError, match=said):
            units.parse_quantity(text, "m")
    with pytest.raises(UnitError, match="2 pi rad"):
        units.parse_quantity("10 rad/s", "Hz")
