"""Study `finger`: claims against numbers found apart from the study.

Source of truth: numbers noted for this project from separate code (a stiff ODE solver on the rates
of the law, with the finger solved by bisection), and closed forms written out anew here.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from claim_checks import check_complete, check_decides, check_shipped, numbers_of, verdicts_of

from martensite.kernels.compiler import find_compiler
from martensite.scenario.citations import read_bibliography
from martensite.studies.base import AbstractStudy, Answer, load_study
from martensite.studies.finger import FingerStudy, bench, bending_numbers, crystal_numbers, loop_numbers, wire_numbers
from martensite.studies.tables import printed_numbers

PRINTED = printed_numbers("finger")
PER_KELVIN = 200.0 * math.pi * 0.1e-3 * 0.44

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="slow without a C compiler")


@pytest.fixture(scope="module")
def study() -> AbstractStudy:
    return load_study("finger")


@pytest.fixture(scope="module")
def answer(study: AbstractStudy) -> Answer:
    return study.compute()


@pytest.fixture(scope="module")
def listed(answer: Answer) -> dict[str, float | None]:
    return numbers_of([answer])


def computed(listed: dict[str, float | None], id: str) -> float:
    number = listed[id]
    assert number is not None
    return number


class TestWire:
    def test_heat(self):
        assert bench.steady_temperature(1.4, PRINTED) == pytest.approx(295.0 + 1.4 / PER_KELVIN, abs=1e-3)
        assert wire_numbers.threshold_power(PRINTED) == pytest.approx(PER_KELVIN * 37.75, rel=1e-9)
        assert wire_numbers.free_width(PRINTED) == pytest.approx(PER_KELVIN * 13.0, rel=1e-9)

    @pytest.mark.parametrize(("T", "up", "down"), [(340.0, 79.6, 30.3), (370.0, 199.6, 150.4)])
    def test_plateaus(self, T, up, down):
        found = wire_numbers.plateau_stresses(wire_numbers.load_wire(T))
        assert [s / 1e6 for s in found] == pytest.approx([up, down], abs=0.5)

    @pytest.mark.parametrize("T", [295.0, 310.0])
    def test_twins_turn_at_one_stress_and_stay(self, T):
        path = wire_numbers.stretched_cold(T)
        level = next(s for s, e in zip(path.stress, path.strain, strict=True) if e >= 0.02)
        assert level / 1e6 == pytest.approx(50.7, abs=0.5)
        assert path.strain[-1] == pytest.approx(0.04, abs=2e-4)

    def test_weight_of_a_phalanx(self):
        assert wire_numbers.weight_stress(PRINTED) / 1e6 == pytest.approx(195.0, abs=1.0)


class TestBending:
    @pytest.mark.parametrize(
        ("r", "watts", "angle", "t63", "stress"),
        [
            (1.5e-3, 1.4, 92.75, 4.29, 40.8),
            (1.5e-3, 2.0, 92.75, 2.12, 40.8),
            (3.5e-3, 1.4, 75.44, 3.53, 31.7),
            (5.5e-3, 2.0, 62.19, 2.04, 24.2),
        ],
    )
    def test_angle_time_and_stress(self, r, watts, angle, t63, stress):
        run = bench.run_bending(watts, r, PRINTED)
        assert bench.top_angle(run, PRINTED) == pytest.approx(angle, abs=0.01)
        assert bench.rise_time(run, 0.63, PRINTED) == pytest.approx(t63, abs=0.03)
        assert bench.column_at(run, "stress", 13.0) / 1e6 == pytest.approx(stress, abs=0.1)

    def test_full_stroke_is_the_root_of_its_equation(self):
        angles = [bench.full_stroke(r, 8e-3, PRINTED) for r in PRINTED.offsets]
        assert angles == pytest.approx([92.75, 75.44, 62.19], abs=0.01)

    def test_the_trend_turns_round_far_from_the_hinge(self):
        assert all(bending_numbers.angles_fall(watts, PRINTED) for watts in PRINTED.powers)
        far = bending_numbers.top_angles(2.0, PRINTED, bench.FAR_ARM)
        assert far == pytest.approx([6.0, 18.6, 30.3], abs=0.3)

    def test_force_limited_stress_is_at_its_threshold(self):
        run = bench.run_bending(2.0, 5.5e-3, PRINTED, bench.FAR_ARM)
        threshold = 1.0 + 4.0 * (bench.steady_temperature(2.0, PRINTED) - 320.0) - 52.0
        assert bench.column_at(run, "stress", 13.0) / 1e6 == pytest.approx(threshold + 1.8, abs=1.0)

    def test_halving_the_step_changes_nothing(self):
        coarse, fine = (bench.run_bending(1.4, 1.5e-3, PRINTED, step=s) for s in (0.02, 0.01))
        apart = [abs(a - b) for a, b in zip(coarse["angle"], fine["angle"], strict=True)]
        assert math.degrees(max(apart)) < 0.02

    def test_energy_is_accounted_for(self):
        wire = bench.get_wire()
        values = {"mass": wire.mass(), "heat_capacity": wire.heat_capacity, "latent_heat": wire.latent_heat}
        run = bench.run_bending(2.0, 1.5e-3, PRINTED)
        assert bench.energy_imbalance(run, values) < 1e-4
        half = replace(run, times=run.times[:200], columns={name: column[:200] for name, column in run.columns.items()})
        assert bench.energy_imbalance(half, values) < 1e-3
        assert bench.energy_imbalance(half, {**values, "latent_heat": 0.0}) > 0.03


class TestLoop:
    def test_widths(self):
        assert loop_numbers.loop_widths(PRINTED, None)[:2] == pytest.approx((0.741, 0.433), abs=0.003)
        full, _, static = loop_numbers.loop_widths(PRINTED, None)
        assert full / static == pytest.approx(2.1, rel=0.05)
        full, _, static = loop_numbers.loop_widths(PRINTED, 16e-3)
        assert full / static == pytest.approx(1.46, rel=0.05)

    def test_lag(self):
        assert loop_numbers.temperature_lag(PRINTED, None) == pytest.approx(9.3, abs=0.1)
        assert loop_numbers.temperature_lag(PRINTED, 16e-3) == pytest.approx(4.0, abs=0.1)


@needs_compiler
@pytest.mark.slow
class TestWhole:
    def test_verdicts(self, answer):
        assert verdicts_of(answer.claims) == {
            "misprint": {"cold-threshold", "rest-stress"},
            "self-contradictory": {"latent-heat", "quasi-stationary"},
            "not comparable": {"trend", "measured-error"},
            "recovery": {"residual-strain"},
        }
        check_complete(answer)
        check_decides(answer.claims)
        assert set(FingerStudy.cites) <= set(read_bibliography())

    def test_what_the_text_says_in_kind(self, listed):
        """The trend where the spring is near the hinge, its end far from it; the return; σ_M where the wire stops."""
        assert [computed(listed, id) for id in ("trend", "trend-safe", "trend-far")] == [2.0, 2.0, 0.0]
        assert computed(listed, "return") == pytest.approx(0.0, abs=0.1)
        for watts, threshold in ((1.4, 51.55), (2.0, 138.35)):
            assert computed(listed, f"limited-{watts}W") == pytest.approx(threshold, abs=3.0)
        assert computed(listed, "quasi-stationary-8mm") > 2.0 and computed(listed, "quasi-stationary-16mm") > 1.4

    def test_polycrystal(self, listed):
        assert computed(listed, "polycrystal-1.4W") == pytest.approx(68.0, abs=2.0)
        assert computed(listed, "polycrystal-2.0W") == pytest.approx(75.0, abs=2.0)
        angles = [
            bench.top_angle(bench.run_bending(1.4, r, PRINTED, None, bench.POLYCRYSTAL), PRINTED)
            for r in PRINTED.offsets
        ]
        assert angles == pytest.approx([76.0, 68.0, 59.0], abs=2.0)

    def test_crystals_differ_at_intermediate_powers(self, listed):
        assert computed(listed, "crystals") == pytest.approx(18.5, abs=1.0)
        apart = [crystal_numbers.crystal_difference(watts, PRINTED, 12e-3) for watts in (1.4, 1.6)]
        assert apart == pytest.approx([-1.0, 11.5], abs=1.5)

    def test_readme_has_the_computed_numbers(self, listed):
        text = bench.SCENARIO.with_name("README.md").read_text(encoding="utf-8")
        shown = [f"{crystal_numbers.crystal_difference(w, PRINTED):+.1f}° at {w:.1f} W" for w in (1.0, 1.3)]
        ends = [f"{computed(listed, f'limited-{w:.1f}W'):.1f}" for w in PRINTED.powers]
        angles = [f"{computed(listed, f'angle-{r}mm-2.0W'):.1f}°" for r in (1.5, 3.5, 5.5)]
        lag = f"{computed(listed, 'proportional'):.1f} K off"
        assert [word for word in (*shown, *ends, *angles, lag) if word not in text] == []


def test_what_ships_is_what_is_computed(study: AbstractStudy) -> None:
    check_shipped(study)


def test_redundant_parameters_change_nothing():
    assert bending_numbers.gauge_change(PRINTED) < 1e-3


@needs_compiler
@pytest.mark.slow
def test_figure(tmp_path):
    load_study("finger").figure(tmp_path / "finger.png")
    assert (tmp_path / "finger.png").read_bytes().startswith(b"\x89PNG")
