"""The ladder of structures finds what records were made with, and says when they cannot tell.

Source of truth: the systems of `ladder_cases`, none of which is computed by a block of ours.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from ladder_cases import SYSTEMS, excite, linear, low_pass, noise, record
from scipy.signal import lfilter

from martensite.base.errors import InputError
from martensite.identify.ladder.blocked_records import BlockErrors, compare_errors, divide_records
from martensite.identify.ladder.climb import climb_ladder
from martensite.identify.ladder.ladder_rivals import find_period, score_rivals
from martensite.identify.ladder.record_tests import find_delay, measure_coherence
from martensite.identify.ladder.regimes import set_apart
from martensite.signals.sampling.sampled import Sampled


@pytest.fixture(scope="module")
def climbed():
    return climb_ladder(linear(102, 1000))


class TestClimb:
    def test_a_linear_record_ends_at_the_linear_rung(self, climbed):
        assert climbed.chosen_trial.structure == "oe(2,2,1) | poly1"
        assert climbed.predicts
        assert climbed.held_out.fit > 98.0
        assert climbed.held_out.fit < 99.5  # the noise leaves 99 %
        assert climbed.doubts == ()
        assert any("nothing to find" in text for text in climbed.tests)
        assert climbed.rungs[0].name == "linear"

    def test_what_is_held_out_changes_nothing_before(self, climbed):
        record = linear(102, 1000)
        y = record.outputs.copy()
        y[800:] = y[:800].mean() + np.random.default_rng(1).normal(size=(200, 1))
        other = climb_ladder(record.with_outputs(y))
        assert other.chosen_trial.structure == climbed.chosen_trial.structure
        assert np.array_equal(other.model.theta, climbed.model.theta)
        assert not other.predicts
        assert "does not predict better than the mean" in other.verdict

    def test_a_lag_predicts_no_better_than_itself(self):
        """The system is a first-order lag: arithmetic does as well."""
        rng = np.random.default_rng(8)
        u = excite(rng, 800)
        y: Any = lfilter([0.1], [1.0, -0.9], u)
        found = climb_ladder(record("lag", u, y, rng), time_box=20.0)
        assert found.rivals["first-order lag"] > 95.0
        assert not found.predicts
        assert "first-order lag" in found.verdict

    def test_a_periodic_record_has_a_last_cycle(self):
        u = np.tile(np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.0, 50)]), 8)
        blocked = divide_records([record("waves", u, u, np.random.default_rng(1))])
        assert find_period(u) == 100
        assert score_rivals(blocked, True)["last cycle"] > 95.0

    def test_a_single_step_is_said_to_tell_too_little(self):
        u = np.concatenate([np.zeros(50), np.ones(550)])
        found = climb_ladder(record("step", u, low_pass(u), np.random.default_rng(3)))
        assert len(found.rungs) == 1
        assert any("moves once" in text for text in found.doubts)

    def test_a_still_end_cannot_judge(self):
        rng = np.random.default_rng(4)
        u = np.concatenate([excite(rng, 700), np.zeros(300)])
        u[690:] = 0.0
        found = climb_ladder(record("still", u, low_pass(u), rng), time_box=5.0)
        assert any("blocks held out" in text for text in found.doubts)

    def test_a_time_box_keeps_what_was_found(self):
        found = climb_ladder(noise(105, 800), time_box=3.0)
        assert found.stop_reason == "time box"
        assert found.rungs[0].name == "linear"
        assert not found.predicts

    def test_an_input_that_never_moves_is_refused(self):
        with pytest.raises(InputError, match="never changes"):
            climb_ladder(record("still", np.zeros(200), np.arange(200.0), np.random.default_rng(1)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "inside", "least"),
    [
        ("linear", "oe(2,2,", 98.5),
        ("hammerstein", " | oe(2,2,", 98.0),
        ("wiener", "oe(", 98.0),
        ("bouc-wen", "< boucwen]", 97.0),
    ],
)
def test_the_structure_is_that_of_the_system(name, inside, least):
    found = climb_ladder(SYSTEMS[name](201))
    assert inside in found.chosen_trial.structure
    assert found.held_out.fit > least
    assert found.predicts


@pytest.mark.slow
def test_nothing_predicts_noise():
    found = climb_ladder(noise(201))
    assert not found.predicts
    assert not any(rung.is_accepted for rung in found.rungs)


class TestTests:
    def test_the_delay_is_found_with_its_interval(self):
        rng = np.random.default_rng(7)
        u = excite(rng, 1500)
        late = np.concatenate([np.zeros(7), low_pass(u)[:-7]])
        found = find_delay([record("late", u, late, rng)])
        assert found.low <= 9 <= found.high  # seven and the two of the system
        assert found.high - found.low <= 2

    def test_coherence_is_one_of_a_linear_system_and_none_of_noise(self):
        assert measure_coherence(linear(8)) > 0.95
        assert measure_coherence(noise(8)) < 0.3

    def test_errors_that_differ_by_chance_are_no_gain(self):
        rng = np.random.default_rng(9)
        one, other = (BlockErrors(0.0, rng.uniform(0.5, 1.5, 15)) for _ in range(2))
        assert not compare_errors(one, other).certain
        smaller = BlockErrors(0.0, 0.8 * one.pieces)
        assert compare_errors(one, smaller).certain
        assert compare_errors(one, smaller).share == pytest.approx(0.2)
        assert not compare_errors(smaller, one).certain

    def test_blocks_are_apart(self):
        (one,) = divide_records([linear(10, 1000)])
        for whole in (False, True):
            hidden = np.isnan(one.hide(whole).outputs[:, 0])
            assert hidden[800:].all()
            assert hidden[:800].any() is not np.bool_(whole)
        assert sum(block.stop - block.start for block in one.chosen_by) == pytest.approx(800 / 3, abs=10)


class TestRegimes:
    def test_other_regimes_are_set_apart_and_named(self):
        first = linear(11, 800)
        louder = linear(12, 800)
        louder = Sampled("louder", 0.1, 3.0 * louder.inputs, 3.0 * louder.outputs, ("u",), ("y",))
        rng = np.random.default_rng(13)
        u = excite(rng, 800)
        cases = {
            "alike": linear(14, 800),
            "louder": louder,
            "shifted": Sampled("shifted", 0.1, first.inputs, first.outputs + 20.0, ("u",), ("y",)),
            "slower": Sampled("slower", 0.2, first.inputs, first.outputs, ("u",), ("y",)),
            "foreign": record("foreign", u, 2.0 - 3.0 * low_pass(low_pass(u)), rng),
        }
        kept, apart = set_apart([first, *cases.values()])
        assert len(kept) == 2
        for place, words in ((2, "amplitude of `u`"), (3, "level of `y`"), (4, "sample time"), (5, "dynamics")):
            assert words in apart[place]
