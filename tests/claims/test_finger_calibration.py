"""Study `finger-calibration`: fits of synthetic records against numbers found apart from it.

Source of truth: numbers noted for this project from separate code (a stiff ODE solver on the rates
of the law with the finger solved by bisection, derivatives by differences), which had the same
noise; Table 1, from which the records were made; and gauges that follow from the equations.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from claim_checks import check_complete, check_decides, check_shipped, numbers_of, verdicts_of

from martensite.kernels.compiler import find_compiler
from martensite.scenario.citations import read_bibliography
from martensite.studies.base import load_study
from martensite.studies.finger_calibration import FingerCalibration, bench, gauge_numbers, record_numbers
from martensite.studies.finger_calibration.bench import EVERY, FAR, JOINT, NEAR
from martensite.studies.finger_calibration.searches import (
    ALL,
    COORDINATE,
    FEW,
    SQUARES,
    STILL,
    best_fit,
    moving_starts,
    run_search,
)
from martensite.studies.tables import printed_numbers

PRINTED = printed_numbers("finger_calibration")
TABLE = record_numbers.table_numbers(PRINTED)

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def study():
    return FingerCalibration()


@pytest.fixture(scope="module")
def answer(study):
    return study.compute()


@pytest.fixture(scope="module")
def listed(answer):
    return numbers_of([answer])


def computed(listed, id: str) -> float:
    return listed[id]


@needs_compiler
class TestRecords:
    def test_steps_of_the_fit_change_little(self):
        for data in (NEAR, FAR):
            coarse = bench.at_table(data, PRINTED).fitted_records[0].model[:, 0]
            fine = bench.clean_angle(data.arm, PRINTED.offsets[0], PRINTED)
            apart = np.degrees(coarse - fine)
            assert 0.0 < math.sqrt(np.mean(apart**2)) < 0.02

    def test_noise_is_white_and_the_same_again(self):
        rows = bench.draw_noise()
        again = np.random.default_rng(bench.SEED).standard_normal(rows.size).reshape(rows.shape)
        assert np.array_equal(rows, again)
        assert rows.std() == pytest.approx(1.0, abs=0.05)
        neighbours = np.mean(rows[:, 1:] * rows[:, :-1])
        assert abs(neighbours) < 3.0 / math.sqrt(rows.size)

    def test_every_record_has_its_own_noise(self):
        rows = [k for data in EVERY for k in range(data.first, data.first + data.count)]
        assert sorted(rows) == list(range(len(bench.draw_noise())))

    def test_scenario_has_the_numbers_of_the_paper(self):
        system = bench.build_finger(NEAR.arm, PRINTED.offsets[0])
        for name, value in (*TABLE.items(), *((one.name, one.value) for one in PRINTED.fixed)):
            assert system.value_of(name) == pytest.approx(value, rel=1e-12)
        assert bench.load_scenario().single_waveform.value_of("frequency") == PRINTED.frequency
        assert bench.load_scenario().duration == pytest.approx(1.0 / PRINTED.frequency, abs=1e-3)


@needs_compiler
class TestData:
    @pytest.mark.parametrize(
        ("data", "slope", "E_M", "ratio"),
        [(NEAR, 0.175, 4.0, 0.10), (FAR, 0.036, 17.5, None), (JOINT, 0.011, 4.8, 0.06)],
        ids=("8mm", "16mm", "joint"),
    )
    def test_smallest_errors(self, data, slope, E_M, ratio):
        found = record_numbers.parameter_errors(data, PRINTED)
        assert found.numbers["dsigma_dT"] / 1e6 == pytest.approx(slope, rel=0.06)
        assert found.numbers["E_M"] / 1e9 == pytest.approx(E_M, rel=0.04)
        if ratio is not None:
            assert found.ratio == pytest.approx(ratio, abs=0.007)

    def test_correlations(self):
        near = record_numbers.parameter_errors(NEAR, PRINTED).correlation
        assert near["T_L", "dsigma_dT"] == pytest.approx(0.996, abs=0.001)
        assert near["Delta_sigma", "dsigma_dT"] == pytest.approx(0.994, abs=0.002)

    def test_errors_are_those_of_the_normal_equations(self):
        begin = bench.table_problem(NEAR, PRINTED)
        places = [begin.names.index(name) for name in record_numbers.CHOSEN_ELSE]
        scales = [begin.free[i].slope(float(begin.start[i])) for i in places]
        jacobian = bench.at_table(NEAR, PRINTED).jacobian[:, places] / scales
        size = np.linalg.norm(jacobian, axis=0)
        spread = np.linalg.inv((jacobian / size).T @ (jacobian / size)) / np.outer(size, size)
        found = record_numbers.parameter_errors(NEAR, PRINTED)
        assert np.sqrt(np.diag(spread)) == pytest.approx(list(found.numbers.values()), rel=1e-6)
        step = 1e-4 * TABLE["dsigma_dT"]
        width, slope = TABLE["Delta_sigma"], TABLE["dsigma_dT"]
        turn = np.zeros(len(places))
        turn[record_numbers.CHOSEN_ELSE.index("Delta_sigma")] = 1.0 / slope
        turn[record_numbers.CHOSEN_ELSE.index("dsigma_dT")] = (width / (slope + step) - width / (slope - step)) / (
            2.0 * step
        )
        assert math.sqrt(turn @ spread @ turn) == pytest.approx(found.ratio, rel=1e-5)

    @pytest.mark.parametrize("data", EVERY, ids=lambda data: data.key)
    def test_five_parameters_hold_one_exact_redundancy(self, data):
        (lost,) = record_numbers.assess_records(data, PRINTED).weak
        assert lost.exact
        assert set(lost.names) == {"T_L", "sigma_L"}
        change = dict(zip(lost.names, lost.changes, strict=True))
        assert change["sigma_L"] / change["T_L"] == pytest.approx(TABLE["dsigma_dT"], rel=1e-6)

    def test_four_parameters_hold_none(self):
        found = record_numbers.of_columns(NEAR, record_numbers.CHOSEN_ELSE, PRINTED)
        assert found.rank == len(record_numbers.CHOSEN_ELSE)
        assert all(map(math.isfinite, found.errors))
        five = record_numbers.of_columns(NEAR, PRINTED.searched.column("name"), PRINTED)
        assert five.rank == 4
        assert [math.isinf(e) for e in five.errors] == [False, True, False, True, False]


@needs_compiler
class TestLeastSquares:
    @pytest.mark.parametrize(
        ("data", "rms"),
        [
            pytest.param(NEAR, 0.954, id="8mm", marks=pytest.mark.slow),
            pytest.param(FAR, 1.016, id="16mm"),
            pytest.param(JOINT, 0.963, id="joint", marks=pytest.mark.slow),
        ],
    )
    def test_ends_in_one_minimum_from_every_start_that_moves(self, data, rms):
        found = [run_search(data, start, SQUARES, PRINTED) for start in moving_starts()]
        assert [one.rms for one in found] == pytest.approx([rms] * len(found), abs=0.001)
        ends = [one.fit["dsigma_dT"] for one in found]
        assert max(ends) - min(ends) < 100.0
        assert all(one.runs < 100 * len(one.fit.problem.experiments) for one in found)

    @pytest.mark.slow
    def test_joint_fit_finds_the_table_again(self):
        fit = best_fit(JOINT, PRINTED).fit
        assert fit["dsigma_dT"] / 1e6 == pytest.approx(4.01, abs=0.01)
        assert fit["E_M"] / 1e9 == pytest.approx(30.9, abs=0.1)
        assert record_numbers.cold_temperature(fit.numbers) == pytest.approx(319.75, abs=0.3)
        assert record_numbers.temperature_width(fit.numbers) == pytest.approx(13.0, abs=0.3)

    @pytest.mark.slow
    def test_a_start_where_nothing_moves_is_left_for_others(self):
        found = run_search(FAR, STILL, SQUARES, PRINTED)
        assert found.rms == pytest.approx(best_fit(FAR, PRINTED).rms, abs=1e-6)

    def test_another_noise_ends_elsewhere(self):
        """The minimum is that of the record: with another noise it is another one."""
        (record,) = bench.build_experiments(NEAR, PRINTED)
        angles = np.asarray(record.record["angle"]) + bench.NOISE * bench.draw_noise()[4]
        columns = {**record.record.columns, "angle": angles.tolist()}
        other = replace(record, record=replace(record.record, columns=columns))
        begin = bench.build_calibration((other,), PRINTED, PRINTED.searched.column("value"))
        found = begin.evaluate(begin.start)
        assert found is not None
        assert found.cost == pytest.approx(2.0, abs=0.4)


@needs_compiler
@pytest.mark.slow
class TestGauges:
    def test_force(self):
        found = [one for one in gauge_numbers.assess_test(gauge_numbers.FORCE, PRINTED).weak if one.exact]
        assert len(found) == 1
        assert found[0].gauge
        assert set(found[0].names) == set(gauge_numbers.FORCE)
        moved = dict(zip(found[0].names, found[0].relative, strict=True))
        volume = moved.pop("layer_volume")
        assert list(moved.values()) == pytest.approx([-volume] * len(moved), rel=1e-6)
        same = gauge_numbers.scale_gauge(gauge_numbers.FORCE, 1.3, PRINTED)
        assert gauge_numbers.largest_change(same, PRINTED) < 1e-9
        less = ("stiffness", "dsigma_dT", "Delta_sigma", "sigma_L")
        assert gauge_numbers.largest_change(gauge_numbers.scale_gauge(less, 1.3, PRINTED), PRINTED) == (
            pytest.approx(0.44, abs=0.02)
        )
        assert not any(one.exact for one in gauge_numbers.assess_test(less, PRINTED).weak)

    def test_thermal(self):
        (found,) = gauge_numbers.assess_test(gauge_numbers.THERMAL, PRINTED).weak
        assert not found.exact
        assert set(found.names) == set(gauge_numbers.THERMAL)
        warmed = gauge_numbers.scale_thermal_gauge(1.2, PRINTED)
        assert gauge_numbers.largest_change(warmed, PRINTED) == pytest.approx(0.04, abs=0.005)
        assert gauge_numbers.largest_change({**warmed, "T_L": TABLE["T_L"]}, PRINTED) > 5.0

    def test_redundancy(self):
        moved = {"T_L": TABLE["T_L"] + 10.0, "sigma_L": TABLE["sigma_L"] + 40e6}
        assert gauge_numbers.largest_change(moved, PRINTED) < 1e-9

    def test_effects(self):
        found = gauge_numbers.single_effects(PRINTED)
        assert len(found) == 10
        assert next(iter(found)) == "T_L"
        assert list(found)[-1] == "E_M"
        ranges = {one.name: (one.high - one.low) / (0.1 * one.value) for one in PRINTED.searched}
        over = {name: found[name] * times for name, times in ranges.items()}
        expected = {"T_L": 265.0, "Delta_sigma": 46.0, "sigma_L": 33.0, "dsigma_dT": 29.0}
        assert over == pytest.approx({**expected, "E_M": 0.4}, rel=0.1)


@needs_compiler
@pytest.mark.slow
class TestWhole:
    def test_coordinate_search_stalls(self, listed):
        for data in (NEAR, FAR):
            assert computed(listed, f"minimum-{data.key}") > 0.02  # a fiftieth of the noise: there a search has arrived
            for start in FEW:
                found = run_search(data, start, COORDINATE, PRINTED)
                assert found.rms > best_fit(data, PRINTED).rms
                assert found.fit.simulations > 8 * best_fit(data, PRINTED).runs
                assert found.fit.reason == "stalled"
        assert run_search(NEAR, STILL, COORDINATE, PRINTED).fit["dsigma_dT"] > 5e6

    def test_paths_begin_at_the_start_and_end_at_the_fit(self, listed):
        for data in (NEAR, FAR):
            for method in (COORDINATE, SQUARES):
                found = run_search(data, FEW[0], method, PRINTED)
                costs = [point.rms for point in found.path]
                assert costs == sorted(costs, reverse=True)
                assert found.path[-1].numbers == pytest.approx(found.fit.numbers, rel=1e-9)
                assert found.path[0].runs == 1

    def test_verdicts(self, answer):
        sets = ("8mm", "16mm", "joint")
        assert verdicts_of(answer.claims) == {
            "self-contradictory": {"count", "no-latent-heat"},
            "not comparable": {"chosen"},
            "recovery": {f"{id}-{data}" for id in ("slope", "ratio", "T", "E_M") for data in sets},
        }
        check_complete(answer)
        check_decides(answer.claims)

    def test_least_squares_find_table_1_again(self):
        """Within two standard errors, from each set of records."""
        rows = [row for data in EVERY for row in record_numbers.list_again(data, PRINTED)]
        assert [row["name"] for row in rows if abs(row["found"] - row["true"]) > row["sure"]] == []

    def test_latent_heat_goes_into_the_hysteresis(self, listed):
        assert computed(listed, "no-latent-heat") == pytest.approx(96.0, abs=5.0)

    def test_readme_has_the_computed_numbers(self, listed):
        text = bench.SCENARIO.with_name("README.md").read_text(encoding="utf-8")
        errors = [record_numbers.parameter_errors(data, PRINTED) for data in EVERY]
        rows = [f"{found.numbers['dsigma_dT'] / 1e6:.3f} (0." for found in errors]
        rows += [f"| {found.numbers['E_M'] / 1e9:.1f} (" for found in errors]
        rows += [f"| {found.ratio:.3f} " for found in errors]
        rows += [f"| {found.numbers['T_L']:.2f} " for found in errors]
        rows += [f" / {best_fit(data, PRINTED).rms:.3f} (" for data in EVERY]
        rows += [f"left: {run_search(d, STILL, SQUARES, PRINTED).runs} / " for d in (NEAR, FAR)]
        rows += [f"{computed(listed, 'wrong-arm'):.2f} MPa/K"]
        assert [row for row in rows if row not in text] == []

    def test_figure(self, tmp_path, listed):
        load_study("finger-calibration").figure(tmp_path / "calibration.png")
        assert (tmp_path / "calibration.png").read_bytes().startswith(b"\x89PNG")


@needs_compiler
def test_what_ships_is_what_is_computed(study):
    check_shipped(study)


def test_sources_are_known():
    assert set(FingerCalibration.cites) <= set(read_bibliography())
    assert set(FEW) < set(ALL)


def test_without_a_compiler_it_says_so(monkeypatch, tmp_path):
    for module in ("martensite.kernels.compiler", "martensite.studies.finger_calibration.figure"):
        monkeypatch.setattr(f"{module}.find_compiler", lambda: None)
    (claim,) = FingerCalibration().claims()
    assert (claim.verdict, claim.differs) == ("not comparable", "this machine has no C compiler")
    assert "C compiler" in claim.why
    assert FingerCalibration().load_shipped_answer() is not None
    FingerCalibration().figure(tmp_path / "empty.png")
    assert (tmp_path / "empty.png").stat().st_size > 0
