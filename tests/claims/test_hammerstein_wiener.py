"""Study `hammerstein-wiener`: models of the bench against numbers found apart from the study.

Source of truth: a prototype of bench and models, written separately for this project, and what a
model must do to be worth its name: repeat records that it has not seen, and rest at rest.
"""

from __future__ import annotations

import numpy as np
import pytest
from claim_checks import check_complete

from martensite.kernels.compiler import find_compiler
from martensite.studies.base import Answer, load_study
from martensite.studies.hammerstein_wiener import HammersteinWiener, comparisons, loop, loops
from martensite.studies.hammerstein_wiener.bench import INTERVAL
from martensite.studies.hammerstein_wiener.fit_numbers import BETTER, PAPER, WHOLE

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="needs a C compiler")


def test_stage_1_as_in_the_paper() -> None:
    assert comparisons.compare_position("stage 1", "validation").fit >= 89.0
    assert comparisons.compare_position("stage 1", "slow").fit == pytest.approx(82.0, abs=2.5)


def test_the_one_model_holds_at_every_rate_and_at_rest() -> None:
    assert comparisons.compare_position(WHOLE, "validation").fit >= 96.0
    assert comparisons.compare_position(WHOLE, "slow").fit >= 92.0
    assert comparisons.rest_position(WHOLE) <= 0.05e-3


def test_heating_and_cooling_share_a_record() -> None:
    rng = np.random.default_rng(0)
    measured, hot = rng.normal(size=1000), rng.random(1000) < 0.3
    computed = measured + np.where(hot, 0.5, 0.1)
    found = comparisons.score_record(measured, computed, hot)
    assert found.heating < found.fit < found.cooling
    assert (found.worst_heating, found.worst_cooling) == pytest.approx((0.5, 0.1))
    assert found.worst == found.worst_heating


def test_ramps_heat_where_they_go_up() -> None:
    up, down = np.linspace(0.05, 0.1, 5000), np.linspace(0.1, 0.06, 5000)
    found = comparisons.heating_rows(np.concatenate([up, down]))
    assert found[:4400].all() and not found[5000:9400].any()


@pytest.fixture(scope="module")
def answer() -> Answer:
    return HammersteinWiener(full=True).compute()


@pytest.mark.slow
class TestEverything:
    def test_nothing_is_comparable(self, answer: Answer) -> None:
        check_complete(answer)
        assert {claim.verdict for claim in answer.claims} == {"not comparable"}

    def test_the_paper_s_stages_repeat_their_cadence_and_no_other(self) -> None:
        assert comparisons.compare_position(PAPER, "validation").fit >= 90.0
        assert comparisons.in_series(PAPER, "validation").fit >= 88.0
        assert comparisons.compare_position(PAPER, "slow").fit < 60.0
        assert comparisons.in_series(PAPER, "slow").fit < 60.0

    def test_plays_hold_at_every_rate(self) -> None:
        validation, slow = (
            comparisons.compare_position(BETTER, "validation"),
            comparisons.compare_position(BETTER, "slow"),
        )
        assert validation.fit >= 96.5 and slow.fit >= 95.5
        assert validation.cooling >= validation.heating - 1.0
        assert max(validation.worst, slow.worst) <= 0.6e-3
        assert comparisons.rest_position(f"series {BETTER}") <= 0.05e-3

    def test_what_is_tuned_on_the_model_holds_on_the_bench(self) -> None:
        both = loops.compare_steps(WHOLE)
        assert both.likeness >= 95.0
        for model, bench in both.responses():
            assert bench.rise == pytest.approx(model.rise, rel=0.1)
            assert 100.0 * bench.overshoot == pytest.approx(100.0 * model.overshoot, abs=2.0)
            assert bench.settling == pytest.approx(model.settling, abs=0.2)
        assert loops.compare_sines(WHOLE).apart <= 0.25e-3
        heating, cooling = loops.compare_sines(WHOLE).branches
        assert heating < 0.1e-3 < cooling < 0.5e-3

        sine = loops.compare_sines(WHOLE)
        assert sine.apart_heated < sine.apart < sine.apart_unheated

    def test_the_figure(self, tmp_path) -> None:
        load_study("hammerstein-wiener").figure(tmp_path / "figure.png")
        assert (tmp_path / "figure.png").stat().st_size > 30_000


def test_the_staircase_is_the_one_of_the_tuning() -> None:
    wanted = loop.step_reference()
    assert len(wanted) * INTERVAL == pytest.approx(30.0)
    assert sorted(set(wanted.tolist())) == [0.0, 3e-3, 6e-3]
