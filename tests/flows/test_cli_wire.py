"""`martensite wire`: what a wire at hand needs and does.

Source of truth: Ohm's law, a heat balance written here, the maker's cells, and a run of the same wire.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command import Command

from martensite.base.errors import ParameterError
from martensite.design.sizing.wire_ratings import COOLINGS, WireInHand, rate_wire
from martensite.kernels import floats
from martensite.physics.materials.base import load_material
from martensite.physics.materials.wires import load_wires
from martensite.physics.thermal.base import Cylinder

WIRE = Command("wire")
USUAL = "--diameter", "0.1 mm", "--length", "10 cm", "--supply", "5 V"


def test_numbers_are_those_of_a_heat_balance_and_of_ohm() -> None:
    found = rate_wire(WireInHand(diameter=1e-4, length=0.1, supply=5.0, load=0.8))
    values = {name: number.value for name, number in load_material("flexinol-90").values.items()}
    area, ohms = 0.25 * math.pi * found.size.diameter.value**2, found.size.resistance.value * 0.1
    hold = values["A_f"] + 0.8 / area / values["C_A"] + 10.0
    film = COOLINGS["air"].film(floats, hold, 295.15, Cylinder(found.size.diameter.value, 0.1))
    loss = film * (hold - 295.15) * math.pi * found.size.diameter.value * 0.1
    assert found.holding_current == pytest.approx(math.sqrt(loss / ohms), rel=1e-9)
    strain = values["eps_L"] + 0.8 / area * (1.0 / values["E_M"] - 1.0 / values["E_A"])
    assert found.stroke == pytest.approx(0.98 * strain * 0.1, rel=1e-9)
    series, power = found.series_resistor(found.holding_current)
    assert found.holding_current * (series + ohms) == pytest.approx(5.0)
    assert power == pytest.approx(found.holding_current**2 * series)
    assert found.duty(found.holding_current) * 25.0 / ohms == pytest.approx(loss)


def test_a_spring_takes_what_it_adds_off_the_stroke() -> None:
    wire = WireInHand(diameter=1e-4, length=0.1, supply=5.0, spring=100.0, preload=0.5)
    found = rate_wire(wire)
    assert found.hot_force == pytest.approx(0.5 + 100.0 * found.stroke)
    weight = rate_wire(WireInHand(diameter=1e-4, length=0.1, supply=5.0, load=0.5))
    assert 0.9 * weight.stroke < found.stroke < weight.stroke
    assert found.strand.reachable_strain(0.5 / found.size.section, found.hot_stress) * 0.098 == pytest.approx(
        found.stroke
    )


def test_sizes_stand_beside_the_table() -> None:
    """Within the factor that the check of the catalogue finds; nothing is fitted to a size."""
    ratios = []
    for size in list(load_wires().sizes.values())[::4]:
        found = rate_wire(WireInHand(diameter=size.diameter.value, length=0.1, supply=24.0))
        assert found.cycle is not None
        ratios.append(found.cycle.current / size.current.value)
    assert 0.6 < min(ratios) < max(ratios) < 1.5


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"supply": 1.0}, "the supply drives"),
        ({"current_limit": 0.1}, "the supply drives 0.1 A"),
        ({"alloy": "70", "ambient": 330.0}, "does not come back"),
        ({"load": 3.0}, "above the maker's 172 MPa"),
    ],
)
def test_what_does_not_work_is_said(change: dict[str, float | str], fault: str) -> None:
    found = rate_wire(WireInHand(**({"diameter": 1e-4, "length": 0.1, "supply": 5.0} | change)))  # type: ignore[arg-type]
    assert any(fault in one for one in found.faults)


def test_the_command(tmp_path: Path) -> None:
    text = WIRE.fine(*USUAL, "--current-limit", "2 A", "--figure", str(tmp_path / "circuit.svg"))
    assert "Flexinol 0.10 mm, 90 °C, 100 mm, 12.6 ohm" in text
    assert "drives 8 of them at once" in text
    assert (tmp_path / "circuit.svg").read_text(encoding="utf-8").startswith("<?xml")
    wet = WIRE(*USUAL, "--cooling", "water", "--json")
    found = json.loads(wet.stdout)
    assert wet.exit_code == 1 and found["cycle"]["current"] > 3.0 * 0.24 and found["faults"]


def test_bad_input_is_answered_with_what_is_meant() -> None:
    assert "Did you mean `gf`?" in WIRE.refused(*USUAL, "--load", "100 g")
    assert "Did you mean `degC`?" in WIRE.refused(*USUAL, "--ambient", "22 C")
    assert "nearest are 0.10 mm and 0.13 mm" in WIRE.refused("--diameter", "0.12 mm", *USUAL[2:])
    assert "`--supply` is needed" in WIRE.refused(*USUAL[:4])
    assert "air" in WIRE.refused(*USUAL, "--cooling", "airr")
    with pytest.raises(ParameterError, match="a weight or pulls a spring"):
        WireInHand(diameter=1e-4, length=0.1, supply=5.0, load=1.0, spring=1.0)
