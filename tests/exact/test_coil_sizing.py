"""Coils of a sizing: index, turns and lengths by the formulas of helical springs; a run of what is written.

Source of truth: shear stress with Wahl's factor and the elementary spring rate written out here, the rod of the
element at a load, and a run of the scenario that the sizing writes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from martensite.design.sizing.candidates import Candidate, judge_candidate, size_wire
from martensite.design.sizing.request import WireRequest
from martensite.design.sizing.scenario import format_scenario
from martensite.design.sizing.statics import INDICES, CoilStrand, Statics, compute_statics
from martensite.physics.materials.base import load_material
from martensite.physics.materials.wires import load_wires
from martensite.scenario.scenario import read_scenario

WIRES = load_wires("flexinol")
SIZE = WIRES["0.38 mm"]
VALUES = {name: number.value for name, number in load_material("flexinol-90").values.items()}


def ask_coil(**changes: Any) -> WireRequest:
    """1 N over 30 mm every 100 s, with changes."""
    usual: dict[str, Any] = {"force": 1.0, "stroke": 0.03, "rate": 0.01, "supply": 5.0, "element": "coil"}
    return WireRequest(**(usual | changes))


def wahl(index: float) -> float:
    return (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index


def shear(force: float, index: float, wire: float) -> float:
    """8 F D K/(π d³) [Pa]."""
    return 8.0 * force * index * wahl(index) / (math.pi * wire**2)


def statics(**changes: Any) -> tuple[Statics, CoilStrand, dict[str, float]]:
    static = compute_statics(ask_coil(**changes), SIZE, "90")
    shape = static.strand.describe_shape(static.cold_stress, static.hot_stress)
    assert isinstance(static.strand, CoilStrand) and shape is not None
    return static, static.strand, shape


@pytest.mark.parametrize("force", [0.3, 1.0, 3.0])
def test_shear_stress_is_that_of_wahl(force: float) -> None:
    static, strand, _ = statics(force=force)
    wire = SIZE.diameter.value
    for stress, total in ((static.cold_stress, static.preload), (static.hot_stress, static.work_force)):
        assert stress == pytest.approx(math.sqrt(3.0) * shear(total / static.count, strand.index, wire), rel=1e-9)
    assert static.cold_stress == pytest.approx(69e6, rel=1e-9)
    heavier = static.work_force + 0.2 * force
    assert math.sqrt(3.0) * shear(heavier / static.count, strand.index, wire) <= 172e6 * (1.0 + 1e-9)
    if strand.index < max(INDICES):  # a wider coil would need more of them
        worse = math.sqrt(3.0) * shear(heavier / static.count, strand.index + 1.0, wire)
        assert worse > 172e6


def test_rates_and_lengths_of_a_gently_loaded_coil() -> None:
    """G d⁴/(8 N D³), G = E/3; lengths by strain and rate, where the coil is flat."""
    wire, index, turns = SIZE.diameter.value, 5.0, 40.0
    length = turns * wire * math.hypot(math.pi * index, 1.0)
    coil = CoilStrand(SIZE, "90", length, 295.15, index=index)
    assert coil.turns == pytest.approx(turns) and coil.solid == pytest.approx(40.0 * wire)
    rate = VALUES["E_A"] / 3.0 * wire / (8.0 * turns * index**3)
    assert 1.0 / coil.spring(0.0, 1e-6).compliance == pytest.approx(rate, rel=5e-3)
    force = 0.2 * rate * wire * turns
    assert coil.elongation(0.0, force) == pytest.approx(force / rate, rel=5e-3)
    # the angle of twist of the whole wire: gamma = sqrt(3) strain, y = gamma pi N D^2 / d
    assert coil.reach == pytest.approx(math.sqrt(3.0) * math.pi * turns * index**2 * wire, rel=5e-3)
    assert coil.resistance == pytest.approx(SIZE.resistance.value * math.pi * turns * index * wire, rel=3e-3)


def test_turns_make_the_stroke_and_one_less_does_not() -> None:
    static, strand, shape = statics()
    assert strand.turns == pytest.approx(round(strand.turns))
    assert shape["solid_length"] == pytest.approx(strand.turns * SIZE.diameter.value)
    drawn = shape["cold_length"] - shape["hot_length"]
    assert 0.03 <= 0.98 * drawn * (1.0 + 1e-9)
    assert 0.98 * drawn * (1.0 - 1.0 / strand.turns) < 0.03
    assert drawn == pytest.approx(static.reachable * strand.reach)


@pytest.fixture(scope="module")
def judged() -> Candidate:
    return judge_candidate(ask_coil(), SIZE, "90")


def test_scenario_that_is_written_makes_the_stroke(judged: Candidate) -> None:
    cycle, request = judged.cycle, ask_coil()
    assert judged.feasible and cycle is not None
    run = read_scenario(format_scenario(request, judged, WIRES)).run(tolerance=1e-3)
    heated = [x for t, x in zip(run.times, run["position"], strict=True) if t <= cycle.heating * 1.001]
    assert max(heated) == pytest.approx(0.03, rel=0.02)
    assert max(run["stress"]) == pytest.approx(judged.statics.hot_stress, rel=0.03)
    assert run["position"][-1] < 0.05 * 0.03


def test_thick_wire_is_interpolated_and_said() -> None:
    between = WIRES.interpolate(math.sqrt(WIRES["0.38 mm"].diameter.value * WIRES["0.51 mm"].diameter.value))
    cells = [WIRES[name].resistance.value for name in ("0.38 mm", "0.51 mm")]
    assert between.resistance.value == pytest.approx(math.sqrt(cells[0] * cells[1]))
    assert WIRES.interpolate(WIRES["0.10 mm"].diameter.value).current.value == pytest.approx(
        WIRES["0.10 mm"].current.value
    )
    found = judge_candidate(ask_coil(rate=1e-3), WIRES.interpolate(1e-3), "90")
    assert found.feasible and "resistance" in found.recalled


def test_too_much_is_refused_with_what_would_do() -> None:
    sizing = size_wire(ask_coil(force=8.0, strands=4.0, alloy="90"), replace(WIRES, sizes={SIZE.name: SIZE}))
    assert sizing.best is None and len(sizing.candidates) == 1
    assert sizing.changes and all("--" in change for change in sizing.changes)
