"""The table of everyday units equals pint, so that a run without pint reads the same numbers.

Source of truth: pint. Every spelling of the table is converted by pint and must give the same
factor and offset; every spelling used in a material file must be in the table.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pint
import pytest

from martensite.base import units
from martensite.physics.materials import base as materials
from martensite.physics.materials.base import NAMES

MATERIALS = Path(materials.__file__).parent / "data"
REGISTRY = pint.UnitRegistry()


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


def test_readable_units_are_in_the_table() -> None:
    for declared, shown in units.READABLE.items():
        kelvin = "K" if declared == units.DEGREES else declared
        assert units.EVERYDAY[shown][0] == kelvin
