"""`martensite wire`: what a wire at hand needs and does.

Source of truth: Ohm's law, a heat balance and the formulas of helical springs written here, the maker's cells, and a
run of the same wire or coil.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command import Command

from martensite.base.errors import ParameterError
from martensite.design.sizing.coil_in_hand import CoilInHand, draw_out
from martensite.design.sizing.statics import CoilStrand
from martensite.design.sizing.wire_in_hand import COOLINGS, WireInHand
from martensite.design.sizing.wire_ratings import rate_wire
from martensite.kernels import floats
from martensite.physics.materials.base import load_material
from martensite.physics.materials.wires import load_wires
from martensite.physics.thermal.base import Cylinder
from martensite.scenario.scenario import load

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
        ({"alloy": "70", "ambient": 330.0}, "does not return"),
        ({"load": 3.0}, "above the maker's 172 MPa"),
    ],
)
def test_what_does_not_work_is_said(change: dict[str, float | str], fault: str) -> None:
    found = rate_wire(WireInHand(**({"diameter": 1e-4, "length": 0.1, "supply": 5.0} | change)))  # type: ignore[arg-type]
    assert any(fault in one for one in found.faults)


def test_the_command(tmp_path: Path) -> None:
    text = WIRE.fine(*USUAL, "--current-limit", "2 A", "--figure", str(tmp_path / "circuit.svg"))
    assert "Flexinol 0.10 mm, 90 °C, 100 mm, 12.6 Ω" in text
    assert "drives 8 in parallel" in text
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


# ---------------------------------------------------------------- a coil

BAG = "--coil", "--diameter", "0.5 mm", "--solid", "25 mm", "--resistance", "3 ohm", "--supply", "12 V"
COIL = {"diameter": 5e-4, "solid": 0.025, "resistance": 3.0, "supply": 12.0, "pulse": 5.0}


def make_coil(**changes: float) -> CoilStrand:
    strand = CoilInHand(**(COIL | changes)).make_strand(load_wires())  # type: ignore[arg-type]
    assert isinstance(strand, CoilStrand)
    return strand


def test_a_bag_says_turns_and_width() -> None:
    """N = L_s/d; ohms of a helix of that many turns of pitch d."""
    by_ohms = make_coil()
    assert by_ohms.turns == pytest.approx(50.0)
    ohms_per_metre = load_wires().interpolate(5e-4).resistance.value
    wire = 50.0 * math.hypot(math.pi * by_ohms.coil_diameter, 5e-4)
    assert wire * ohms_per_metre == pytest.approx(3.0) and by_ohms.resistance == pytest.approx(3.0)
    by_width = make_coil(resistance=math.inf, outer=by_ohms.coil_diameter + 5e-4)
    assert by_width.length == pytest.approx(by_ohms.length) and by_width.index == pytest.approx(by_ohms.index)
    both = make_coil(outer=5e-3, turns=49.0)
    assert both.coil_diameter == pytest.approx(4.5e-3) and both.turns == pytest.approx(49.0)
    assert both.resistance == pytest.approx(3.0)


def test_strain_and_pull_of_a_coil_that_is_drawn_out() -> None:
    """gamma = d y/(pi N D^2) and F = G d^4 y/(8 N D^3) of flat turns, which a coil drawn to twice its length has."""
    coil = make_coil()
    drawn, wire, across = draw_out(coil, 0.05), 5e-4, coil.coil_diameter
    assert drawn.shear == pytest.approx(wire * 0.025 / (math.pi * 50.0 * across**2), rel=5e-3)
    shear_modulus = load_material("flexinol-90").values["E_A"].value / 3.0
    assert drawn.hot_force == pytest.approx(shear_modulus * wire**4 * 0.025 / (8.0 * 50.0 * across**3), rel=5e-3)


def test_stroke_starts_where_the_coil_is_held() -> None:
    free, held = (rate_wire(CoilInHand(**(COIL | more))) for more in ({}, {"stretched": 0.1}))  # type: ignore[arg-type]
    shape = free.describe_coil()
    assert shape is not None and free.cycle is not None and held.cycle is not None
    assert free.stroke == pytest.approx(0.98 * (shape["cold_length"] - shape["hot_length"]))
    assert held.stroke == pytest.approx(0.98 * (0.1 - shape["hot_length"]))
    assert held.cycle.current == pytest.approx(free.cycle.current, rel=0.05)
    assert held.cycle.cooling is not None and free.cycle.cooling is not None
    assert held.cycle.cooling < 0.9 * free.cycle.cooling


def test_the_coil_that_is_saved_runs(tmp_path: Path) -> None:
    file, figure = tmp_path / "bag.toml", tmp_path / "bag.svg"
    text = WIRE.fine(*BAG, "--pulse", "5 s", "--out", str(file), "--figure", str(figure))
    assert "50 turns of 4.28 mm mean diameter" in text and figure.is_file()
    found, run = rate_wire(CoilInHand(**COIL)), load(file).run()
    assert max(run["position"]) == pytest.approx(found.stroke, rel=0.02)
    assert max(run["resistance"]) == pytest.approx(3.0)


def test_the_stop_of_a_saved_coil_is_in_the_coil_or_named_as_missing(tmp_path: Path) -> None:
    file = tmp_path / "bag.toml"
    WIRE(*BAG, "--pulse", "5 s", "--stretched", "100 mm", "--out", str(file))
    (coil,) = (one.element for one in load(file).system.actuators().values())
    assert coil.turns * coil.diameter == pytest.approx(0.025)  # type: ignore[attr-defined]
    assert "# It closes at 25 mm" in file.read_text() and "holds it at 100 mm" in file.read_text()


def test_the_time_of_a_weak_supply_is_one_that_does() -> None:
    weak = rate_wire(CoilInHand(**(COIL | {"supply": 5.0, "pulse": 1.0})))  # type: ignore[arg-type]
    assert weak.supply_time is not None and any('--pulse "' in fault for fault in weak.faults)
    longer = math.ceil(10.2 * weak.supply_time) / 10.0
    assert rate_wire(CoilInHand(**(COIL | {"supply": 5.0, "pulse": longer}))).drivable  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"turns": 30.0}, "are 50.0 turns, but `turns` is 30"),
        ({"outer": 9e-3}, "have 5.95 ohm by the maker's table, but `resistance` is 3 ohm"),
        ({"resistance": 0.05}, "which no coil has"),
        ({"resistance": math.inf}, "Say how wide"),
        ({"solid": math.inf}, "Say how many turns"),
        ({"stretched": 0.024}, "not longer than the closed coil"),
        ({"stretched": 0.1, "spring": 100.0}, "a stop"),
        ({"stretched": 0.03}, "hot, it is longer under it"),
        ({"outer": 5e-3, "length": 1.0}, "but `length` is 1000 mm"),
    ],
)
def test_a_bag_that_contradicts_itself_is_refused(change: dict[str, float], words: str) -> None:
    with pytest.raises(ParameterError) as refused:
        rate_wire(CoilInHand(**(COIL | change)))  # type: ignore[arg-type]
    assert words in str(refused.value)


def test_options_of_a_coil_need_one() -> None:
    assert "add --coil" in WIRE.refused(*USUAL, "--turns", "20")
    assert "`--supply` is needed" in WIRE.refused(*BAG[:-2])
    overdrawn = WIRE(*BAG, "--pulse", "5 s", "--stretched", "600 mm")
    assert overdrawn.exit_code == 1 and "above the maker's 5 %" in " ".join(overdrawn.stdout.split())


def test_measured_ohms_are_those_of_the_file(tmp_path: Path) -> None:
    WIRE.fine(*USUAL, "--resistance", "10 ohm", "--out", str(tmp_path / "wire.toml"))
    assert load(tmp_path / "wire.toml").run()["resistance"][0] == pytest.approx(10.0)
