"""Sizing: statics in closed form, cycles that a simulation confirms, honest refusals.

Source of truth: equilibrium and the constitutive equation written out here, and a run of the
scenario that the sizing itself writes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from martensite.base.errors import InputError, ParameterError
from martensite.design.sizing import catalogue_check
from martensite.design.sizing.candidates import Candidate, judge_candidate, size_wire
from martensite.design.sizing.cycle import find_crossing, find_current, simulate_pulse
from martensite.design.sizing.request import WireRequest, choose_wiring
from martensite.design.sizing.scenario import format_scenario
from martensite.design.sizing.statics import Strand, compute_statics
from martensite.physics.materials.base import load_material
from martensite.physics.materials.wires import load_wires
from martensite.scenario.scenario import read_scenario
from martensite.signals.constant import Constant
from martensite.simulate.api import simulate

WIRES = load_wires("flexinol")
THIN, THICK = WIRES["0.10 mm"], WIRES["0.51 mm"]


def asked(**changes: Any) -> WireRequest:
    """0.5 N over 3 mm every 5 s, with changes."""
    usual: dict[str, Any] = {"force": 0.5, "stroke": 3e-3, "rate": 0.2, "supply": 5.0}
    return WireRequest(**(usual | changes))


def run_of(request: WireRequest, candidate: Candidate) -> Any:
    return read_scenario(format_scenario(request, candidate, WIRES)).run(tolerance=1e-3)


# ---------------------------------------------------------------- statics


@pytest.mark.parametrize("force", [0.2, 1.0, 8.0, 40.0])
@pytest.mark.parametrize("size", [*WIRES.sizes.values()][::5], ids=lambda size: size.name)
class TestStatics:
    """The balance of forces and the strain between the phases."""

    def test_spring(self, size: Any, force: float) -> None:
        request = asked(force=force)
        found = compute_statics(request, size, "90")
        area = found.count * 0.25 * math.pi * size.diameter.value**2
        spring_end = found.preload + found.stiffness * request.stroke
        assert found.preload == pytest.approx(69e6 * area, rel=1e-12)
        assert spring_end == pytest.approx(1.25 * found.preload, rel=1e-12)
        assert found.work_force == pytest.approx(force + spring_end, rel=1e-12)
        assert found.hot_stress == pytest.approx(found.work_force / area, rel=1e-12)
        assert found.hot_stress <= 172e6 * (1.0 + 1e-9)
        if found.count > 1:  # one strand less would be too little
            less = area * (found.count - 1) / found.count
            assert force / less + 1.25 * 69e6 > 172e6

    def test_weight(self, size: Any, force: float) -> None:
        found = compute_statics(asked(force=force, bias="weight"), size, "90")
        area = found.count * size.section
        assert found.preload == pytest.approx(max(force, 69e6 * area), rel=1e-12)
        assert found.extra == pytest.approx(found.preload - force, abs=1e-12)
        assert found.work_force == found.preload
        assert found.cold_stress == found.hot_stress <= 172e6 * (1.0 + 1e-9)

    def test_length_follows_from_stroke_and_strain(self, size: Any, force: float) -> None:
        found = compute_statics(asked(force=force, strain=0.08), size, "70")
        values = load_material("flexinol-70").values
        full = values["eps_L"].value + found.cold_stress / values["E_M"].value
        full -= found.hot_stress / values["E_A"].value
        assert found.reachable == pytest.approx(full, rel=1e-12)
        assert found.strain == pytest.approx(0.98 * full, rel=1e-12)
        assert found.strand.length == pytest.approx(3e-3 / (0.98 * full), rel=1e-12)


def test_reachable_strain_is_what_a_heated_wire_does() -> None:
    strand = Strand(THIN, "90", 0.1, 295.15)
    found = compute_statics(asked(bias="weight"), THIN, "90")
    system = strand.system(found.mechanism(3e-3))
    run = simulate(system, Constant(level=0.25), 4.0, step=0.02, samples=101)
    full = strand.reachable_strain(found.cold_stress, found.hot_stress)
    assert run.stroke == pytest.approx(full * strand.length, rel=1e-9)


def test_steady_current_holds_the_temperature() -> None:
    strand = Strand(THIN, "90", 0.1, 295.15)
    current = strand.steady_current(413.15)
    system = strand.system(compute_statics(asked(), THIN, "90").mechanism(3e-3))
    run = simulate(system, Constant(level=current), 60.0, step=0.05, samples=11)
    assert run["temperature"][-1] == pytest.approx(413.15, abs=0.01)


# ---------------------------------------------------------------- cycles


@pytest.mark.parametrize("bias", ["spring", "weight"])
@pytest.mark.parametrize("alloy", ["70", "90"])
def test_written_scenario_reaches_stroke_and_force(bias: str, alloy: str) -> None:
    request = asked(bias=bias, alloy=alloy)
    found = judge_candidate(request, THIN, alloy)
    assert found.feasible
    run = run_of(request, found)
    first = [i for i, time in enumerate(run.times) if time <= request.period]
    assert max(run["position"][i] for i in first) == pytest.approx(3e-3, rel=2e-3)
    assert 3e-3 * 0.999 < run.stroke < 3e-3 / 4.0 * 4.5
    # on the load line of return and load, at every moment
    static = found.statics
    rise = (static.work_force - static.preload) / request.stroke
    for force, position in zip(run["force"], run["position"], strict=True):
        assert force == pytest.approx(static.preload + rise * position, rel=1e-9)
    assert run["force"][0] / static.strand.size.section == pytest.approx(static.cold_stress)


@pytest.mark.parametrize("rate", [0.2, 0.35])
def test_cycle_times_are_those_of_the_run(rate: float) -> None:
    """Every pulse ends at the stroke, and before the next one 98 % of it are given back."""
    request = asked(rate=rate, alloy="90")
    found = judge_candidate(request, THIN, "90")
    assert found.feasible and found.cycle is not None and found.cycle.cooling is not None
    run = run_of(request, found)
    after = found.cycle.heating + found.cycle.cooling
    late = find_crossing(
        [t for t in run.times if found.cycle.heating < t <= request.period],
        [-x for t, x in zip(run.times, run["position"], strict=True) if found.cycle.heating < t <= request.period],
        -0.02 * request.stroke,
    )
    assert late == pytest.approx(after, abs=2e-3 * request.period)


def test_pulse_is_shortened_where_the_rate_asks_for_it() -> None:
    slow, fast = (judge_candidate(asked(rate=rate, supply=12.0), THIN, "90") for rate in (0.2, 0.45))
    assert slow.feasible and fast.feasible
    assert slow.cycle is not None and fast.cycle is not None
    assert slow.cycle.heating == 1.0
    assert fast.cycle.heating < 0.7
    assert fast.cycle.current > slow.cycle.current
    assert fast.cycle.fastest is not None and fast.cycle.fastest >= 0.45


@pytest.mark.parametrize(("rate", "rise"), [(0.2, 5.0), (0.45, 20.0)])
def test_repeated_pulses_get_hotter_as_the_run_says(rate: float, rise: float) -> None:
    request = asked(rate=rate, supply=12.0)
    found = judge_candidate(request, THIN, "90")
    assert found.cycle is not None and found.cycle.running is not None
    run = run_of(request, found)
    first = [i for i, time in enumerate(run.times) if time <= request.period]
    assert max(run["temperature"][i] for i in first) == pytest.approx(found.cycle.hottest, abs=0.5)
    assert max(run["temperature"]) == pytest.approx(found.cycle.running, abs=2.0)
    assert (found.cycle.running - found.cycle.hottest > 10.0) == (rise > 10.0)


def test_strands_wired_both_ways_do_the_same_work() -> None:
    request = asked(force=2.0, supply=24.0, alloy="90", rate=0.1)
    series = judge_candidate(request, THIN, "90")
    parallel = judge_candidate(asked(force=2.0, supply=4.0, alloy="90", rate=0.1), THIN, "90")
    assert series.wiring is not None and parallel.wiring is not None
    assert series.drive is not None and parallel.drive is not None
    assert (series.wiring.kind, parallel.wiring.kind) == ("series", "parallel")
    count = series.statics.count
    assert count == parallel.statics.count > 1
    assert series.drive.voltage == pytest.approx(count * parallel.drive.voltage, rel=1e-9)
    assert parallel.drive.current == pytest.approx(count * series.drive.current, rel=1e-9)
    assert series.drive.energy == pytest.approx(parallel.drive.energy, rel=1e-9)
    for request_, found in ((request, series), (request, parallel)):
        run = run_of(request_, found)
        assert run.stroke == pytest.approx(3e-3, rel=0.05)
        assert max(run["voltage"]) == pytest.approx(found.drive.voltage, rel=1e-6)  # type: ignore[union-attr]
        assert max(run["stress"]) < 172e6 * 1.02


def test_limits_of_the_supply_choose_the_wiring() -> None:
    def kind(**limits: Any) -> str:
        return choose_wiring(asked(**limits), 3, 10.0, 0.2).kind

    assert kind(supply=6.0) == "series"
    assert kind(supply=5.9) == "parallel"
    assert kind(supply=5.9, current_limit=0.3) == "series"  # neither; series drives 0.197 A
    assert choose_wiring(asked(), 1, 10.0, 9.0).kind == "single"


def test_current_is_the_least_that_does_it_in_time() -> None:
    found = compute_statics(asked(), THIN, "90")
    system = found.strand.system(found.mechanism(3e-3, found.count))
    current = find_current(system, 3e-3, 1.0, 0.05)
    assert current is not None
    assert simulate_pulse(system, current, 1.0) >= 3e-3 > simulate_pulse(system, current * (1 - 1e-3), 1.0)
    assert find_current(system, 3e-3, 1.0, 3.0) == pytest.approx(current, rel=2e-3)
    assert find_current(system, 9e-3, 1.0, 0.05) is None


# ---------------------------------------------------------------- refusals and warnings


def test_ranking_puts_the_robust_first_and_the_frugal_before_others() -> None:
    found = size_wire(asked(alloy="90"))
    order = [one.feasible for one in found.candidates]
    assert order == sorted(order, reverse=True)
    assert found.best is found.candidates[0]
    ranks = [(len(one.frail), one.drive.energy) for one in found.candidates if one.feasible and one.drive]
    assert len(ranks) > 1
    assert ranks == sorted(ranks)
    assert all(one.reasons for one in found.candidates if not one.feasible)


@pytest.mark.parametrize(
    ("changes", "size", "reason"),
    [
        ({"force": 100.0}, "0.025 mm", "needs 2302 strands, at most 12 are allowed"),
        ({"rate": 1.0}, "0.51 mm", "too slow: "),
        ({"supply": 0.5}, "0.10 mm", "the supply of 0.5 V drives at most"),
        ({"current_limit": 0.05}, "0.10 mm", "and 0.05 A drives at most 0.05 A"),
        ({"ambient": 353.15}, "0.10 mm", "does not return: the ambient of 80 °C is above M_s = 58.3 °C"),
        ({"ambient": 273.15 + 52.0}, "0.10 mm", "does not return: more than 2 %"),
    ],
)
def test_infeasible_requests_are_explained(changes: dict[str, Any], size: str, reason: str) -> None:
    found = judge_candidate(asked(**changes), WIRES[size], "90")
    assert not found.feasible
    assert any(reason in text for text in found.reasons), found.reasons


def test_a_close_ambient_is_warned_of() -> None:
    """M_f of the 70 °C alloy under 69 MPa is 28.3 °C."""
    finish = 273.15 + 19.1 + 69.0 / 7.5

    def cold(ambient: float) -> list[str]:
        found = judge_candidate(asked(ambient=ambient), THIN, "70")
        return [text for text in found.warnings if "M_f" in text]

    assert "the wire does not return completely" in cold(finish + 0.1)[0]
    assert "is only 0.1 K below M_f = 28.3 °C under 69 MPa" in cold(finish - 0.1)[0]
    assert cold(finish - 9.9)
    assert not cold(finish - 10.1)


def test_limits_are_warned_of_and_life_is_claimed_only_where_a_source_does() -> None:
    usual, high = (judge_candidate(asked(force=1.0, stress=s), THIN, "90") for s in (172e6, 300e6))
    assert "nitinolactuators.com" in usual.life
    assert "not the maker's datasheet" in usual.life
    assert high.statics.hot_stress > 172.4e6
    assert high.life == "no value in the available datasheets"
    bold = judge_candidate(asked(force=1.0, stress=300e6, limits="ignore"), THIN, "90")
    for inside in (high.reasons, bold.warnings):
        assert any("above the maker's 172 MPa for repeated use" in text for text in inside)
    assert not any("for repeated use" in text for text in (*usual.warnings, *usual.reasons, *bold.reasons))


def test_a_warmer_day_is_the_same_pulse_on_that_day() -> None:
    """M_f of the 70 °C alloy under 69 MPa is 28.3 °C, of the 90 °C alloy 20 K more."""
    for alloy, late in (("70", True), ("90", False)):
        found = judge_candidate(asked(), THIN, alloy)
        assert found.feasible
        assert any("on a day 10 K warmer" in text for text in found.frail) == late


def test_more_load_is_said_where_it_exceeds_the_limit() -> None:
    """20 % of the force, over the section, comes to the stress."""
    for force, exceeded in ((0.5, False), (0.65, True)):
        found = judge_candidate(asked(force=force), THIN, "90")
        stress = found.statics.hot_stress + 0.2 * force / (found.statics.count * THIN.section)
        assert (stress > 172e6) == exceeded, stress
        assert any("20% more load it has" in text for text in found.frail) == exceeded


def test_recalled_cells_are_named() -> None:
    assert judge_candidate(asked(), THIN, "90").recalled == ("diameter", "resistance")
    assert judge_candidate(asked(), WIRES["0.25 mm"], "90").recalled == ("diameter",)
    assert judge_candidate(asked(), WIRES["0.025 mm"], "90").recalled == ()


def test_a_return_that_takes_everything_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"must be above the 86\.25 MPa"):
        asked(stress=80e6)
    assert asked(stress=80e6, bias="weight").stress == 80e6


def test_a_wire_without_cycle_has_no_scenario() -> None:
    request = asked(supply=0.5)
    with pytest.raises(InputError, match=r"makes no cycle.*the supply of 0\.5 V"):
        format_scenario(request, judge_candidate(request, THIN, "90"), WIRES)


def test_too_slow_a_wire_is_written_at_its_own_rate() -> None:
    request = asked(force=5.0, rate=1.0)
    found = judge_candidate(request, THICK, "90")
    assert not found.feasible and found.cycle is not None
    text = format_scenario(request, found, WIRES)
    scenario = read_scenario(text)
    assert "# Not met: too slow" in text
    assert "1 Hz are not reached" in text
    assert scenario.duration == pytest.approx(3.0 / found.cycle.fastest)  # type: ignore[operator]


def test_scenario_says_where_each_cell_comes_from() -> None:
    request = asked()
    text = format_scenario(request, judge_candidate(request, WIRES["0.25 mm"], "90"), WIRES)
    lines = text.splitlines()
    assert any("0.254 mm" in line and "recalled, dynalloy-tcf1140" in line for line in lines)
    assert any("resistance]" in line and "datasheet, flexinol-workshop" in line for line in lines)


# ---------------------------------------------------------------- the maker's table


def small(*names: str) -> Any:
    return replace(WIRES, sizes={name: WIRES[name] for name in names})


def test_check_of_the_catalogue_goes_from_loss_to_storage() -> None:
    rows = catalogue_check.check_catalogue(small("0.025 mm", "0.51 mm"), alloys=("90",))
    thin, thick = rows
    assert thin.loss_share > 0.8
    assert thick.loss_share < 0.05
    assert (round(thin.stored_share, 1), round(thick.stored_share, 2)) == (11.2, 0.67)
    for row in rows:
        assert row.current_ratio == pytest.approx(1.2, abs=0.15)
        assert row.cooling_ratio is not None
        assert 0.4 < row.cooling_ratio < 1.7


def test_checked_current_contracts_the_wire_in_a_second() -> None:
    (row,) = catalogue_check.check_catalogue(small("0.15 mm"), alloys=("70",))
    strand = Strand(WIRES["0.15 mm"], "70", 0.1, 295.15)
    request = asked(bias="weight", force=172e6 * strand.size.section)
    system = strand.system(compute_statics(request, strand.size, "70").mechanism(3e-3))
    full = strand.reachable_strain(172e6, 172e6) * strand.length
    assert simulate_pulse(system, row.current, 1.0) == pytest.approx(0.99 * full, rel=2e-3)
    assert simulate_pulse(system, 0.95 * row.current, 1.0) < 0.95 * full


def test_spread_is_that_of_the_ratios_that_exist() -> None:
    found = catalogue_check.summarise_ratios([0.5, None, 2.0])
    assert found is not None
    assert (found.least, found.mean, found.most) == (0.5, pytest.approx(1.0), 2.0)
    assert catalogue_check.summarise_ratios([None]) is None
