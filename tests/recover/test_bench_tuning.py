"""Tuning on the bench: goals, plants that differ, derivatives, and what a search finds.

Sources of truth: differences for derivatives, and hand-made courses for goals and measures.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tuning_cases import linear_bench, wire_bench

from martensite.base.errors import ParameterError, SolveError
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.rules.rule_starts import convert_to_pid, gains_by_tests, run_loop_tests
from martensite.control.tuning.bench_tuning import tune_bench
from martensite.control.tuning.gain_search import TuningSearch, build_free_gains
from martensite.control.tuning.goals import ERRORS, Cost, Course, TuningGoal
from martensite.control.tuning.loop_runs import LoopOutputs, LoopRuns, find_judged_output
from martensite.control.tuning.measures import measure_loop
from martensite.control.tuning.plant_spread import METHODS, OverPlants, compare_over_plants, draw_plants

GAINS = tuple(f"controllers.drive.{name}" for name in ("Kp", "Ki", "Kd"))
SPREADS = {
    "element.diameter": 0.03,
    "environment.temperature": 3.0,
    "source.supply": 0.05,
    "mechanism.stiffness": 0.1,
    "heat_capacity": 0.05,
}


def course_of(reference: Any, output: Any, period: float = 0.5) -> tuple[Course, LoopOutputs]:
    y = np.asarray(output, float)
    seen = LoopOutputs(y, np.asarray(reference, float), np.sin(y), 2.0 + y**2, 300.0 + y)
    return Course(seen, period), seen


# ---------------------------------------------------------------- goals


def test_the_clock_begins_anew_at_a_step_and_overshoot_needs_a_level() -> None:
    """A step up, a ramp, a step down: where the reference moves, nothing is beyond a level."""
    course, _ = course_of([1, 1, 1, 1.04, 1.08, 0.2, 0.2], np.zeros(7))
    assert course.clock.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 0.0, 0.5]
    assert course.way.tolist() == [1.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0]
    assert course.span == pytest.approx(1.08)


def test_measures_of_a_course_made_by_hand() -> None:
    course, seen = course_of([1.0] * 6, [0.0, 0.5, 1.3, 0.9, 1.02, 1.0])
    found = measure_loop(seen, course)
    errors = np.array([1.0, 0.5, 0.3, 0.1, 0.02, 0.0])
    assert found.iae == pytest.approx(0.5 * errors[1:].sum())
    assert found.itae == pytest.approx(0.25 * errors @ np.arange(6))
    assert found.rms == pytest.approx(math.sqrt((errors**2).mean()))
    assert found.overshoot == pytest.approx(0.3)
    assert found.settling == pytest.approx(2.0)
    assert found.energy == pytest.approx(0.5 * seen.power[:-1].sum())
    assert found.hottest == pytest.approx(301.3)


def test_what_never_settles() -> None:
    course, seen = course_of([1.0] * 4, [0.0, 0.5, 1.0, 1.2])
    assert measure_loop(seen, course).settling == math.inf


@pytest.mark.parametrize("error", ERRORS)
def test_a_cost_has_its_derivatives(error: str) -> None:
    rng = np.random.default_rng(1)
    reference = np.repeat([1.0, 0.3, 0.8], 8)
    seen = LoopOutputs(*rng.normal(1.0, 0.5, (5, 24)))._replace(reference=reference)
    cost = Cost(TuningGoal(error=error, overshoot=0.7, energy=0.3, activity=0.4), Course(seen, 0.1))
    moved = LoopOutputs(*rng.normal(0.0, 1.0, (5, 24, 1)))._replace(reference=np.zeros((24, 1)))
    ends = [
        cost(LoopOutputs(*((a + h * b[:, 0])[None] for a, b in zip(seen, moved, strict=True))))[0]
        for h in (1e-6, -1e-6)
    ]
    slope = float(cost.slope(seen, moved)[0])
    assert slope == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-6)
    assert abs(slope) > 1e-3


def test_parts_of_a_cost_count_by_their_weights() -> None:
    course, seen = course_of([1.0] * 6, [0.0, 0.5, 1.3, 0.9, 1.02, 1.0])
    rows = LoopOutputs(*(column[None] for column in seen))
    bare = Cost(TuningGoal(overshoot=0.0, energy=0.0, activity=0.0), course)(rows)[0]
    for name in ("overshoot", "energy", "activity"):
        parts: Any = {"overshoot": 0.0, "energy": 0.0, "activity": 0.0, name: 1.0}
        goal = TuningGoal(**parts)
        assert Cost(goal, course)(rows)[0] > bare + 0.01
    assert Cost(TuningGoal(overshoot=0.0, energy=2.0, activity=0.0), course)(rows)[0] == pytest.approx(bare + 2.0)


def test_the_worst_share_of_a_batch() -> None:
    cost, weights = TuningGoal(worst=0.5).over_plants(np.array([1.0, 4.0, 2.0, 3.0]))
    assert (cost, weights.tolist()) == (3.5, [0.0, 0.5, 0.0, 0.5])
    assert TuningGoal().over_plants(np.array([1.0, 4.0]))[0] == 2.5


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"error": "itea"}, "Did you mean `itae`"),
        ({"energy": -1.0}, "at least 0"),
        ({"worst": 0.0}, "above 0 and at most 1"),
    ],
)
def test_what_is_no_goal(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        TuningGoal(**wrong)


def test_a_reference_that_asks_for_nothing() -> None:
    with pytest.raises(ParameterError, match="nothing to tune"):
        course_of(np.ones(4), np.ones(4))


# ---------------------------------------------------------------- plants


@pytest.mark.parametrize("method", METHODS)
def test_plants_lie_evenly_within_their_spreads(method: str) -> None:
    bench = wire_bench()
    found = draw_plants(bench, SPREADS, 64, seed=3, method=method)
    nominal = {path: bench.value_of(path) for path in found.values}
    d = found.values["plant.element.diameter"] / nominal["plant.element.diameter"] - 1.0
    warm = found.values["plant.environment.temperature"]
    assert 0.027 < d.max() <= 0.03
    assert -0.03 <= d.min() < -0.027
    assert abs(d.mean()) < 0.001
    assert 2.7 < np.abs(warm - nominal["plant.environment.temperature"]).max() <= 3.0
    path = "plant.element.diameter"
    again, other = (draw_plants(bench, SPREADS, 64, seed=k, method=method) for k in (3, 4))
    assert np.array_equal(again.values[path], found.values[path])
    assert not np.array_equal(other.values[path], found.values[path])


def test_only_the_plant_is_drawn() -> None:
    bench = wire_bench()
    plants = draw_plants(bench, SPREADS, 4)
    one = plants.bench(bench, 2)
    assert one.controllers == bench.controllers
    assert one.sensors == bench.sensors
    path = "plant.source.supply"
    assert one.value_of(path) == plants.values[path][2] != bench.value_of(path)
    with pytest.raises(ParameterError, match="there is no 4"):
        plants.bench(bench, 4)


@pytest.mark.parametrize(
    ("spreads", "count", "said"),
    [
        ({"diamter": 0.1}, 4, "There is no parameter `diamter`"),
        ({"diameter": -0.1}, 4, "must be above 0"),
        ({"diameter": 1.5}, 4, "must be"),
        ({"Kp": 0.1}, 4, "There is no parameter `Kp`"),
        ({"diameter": 0.1}, 0, "at least 1"),
        ({}, 4, "need a spread"),
    ],
)
def test_what_cannot_be_drawn(spreads: dict[str, float], count: int, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        draw_plants(wire_bench(), spreads, count)


# ---------------------------------------------------------------- runs


@pytest.fixture(scope="module")
def ideal(c_compiler: str) -> LoopRuns:
    """The wire without a sensor in between: its derivatives are those of differences."""
    calm = {GAINS[0]: 100.0, GAINS[1]: 50.0, GAINS[2]: 5.0}
    return LoopRuns(wire_bench(sensed=False).with_values(calm), 8.0)


@pytest.fixture(scope="module")
def sensed(c_compiler: str) -> LoopRuns:
    return LoopRuns(wire_bench(), 8.0)


def cost_of(runs: LoopRuns) -> Cost:
    nominal = runs.run(runs.table({}, 1))
    return Cost(TuningGoal(), Course(LoopOutputs(*(column[0] for column in nominal)), runs.bench.period))


def test_derivatives_through_the_loop_are_those_of_differences(ideal: LoopRuns) -> None:
    cost = cost_of(ideal)
    found = ideal.slopes(ideal.base, GAINS)
    assert found is not None
    exact = cost.slope(*found)
    for path, slope in zip(GAINS, exact, strict=True):
        step = 1e-5 * ideal.base[ideal.place(path)]
        ends = [ideal.base[ideal.place(path)] + s * step for s in (1.0, -1.0)]
        values = cost(ideal.run(ideal.table({path: ends}, 2)))
        assert slope == pytest.approx((values[0] - values[1]) / (2.0 * step), rel=2e-3)


def test_lanes_single_runs_and_floats_agree(ideal: LoopRuns) -> None:
    plants = draw_plants(ideal.bench, SPREADS, 2, seed=5)
    rows = ideal.run(ideal.table(plants.values, 2))
    plain = LoopRuns(ideal.bench, 8.0, native=False)
    alone = plain.run(plain.table({p: v[1:] for p, v in plants.values.items()}, 1))
    np.testing.assert_allclose(rows.output[1], alone.output[0], rtol=0.0, atol=1e-9)
    found = ideal.slopes(ideal.table(plants.values, 2)[1], GAINS)
    assert found is not None
    np.testing.assert_allclose(found[0].output, rows.output[1], rtol=0.0, atol=1e-9)


def test_what_is_judged_is_the_truth(sensed: LoopRuns) -> None:
    """Not what an encoder says late and rounded."""
    assert find_judged_output(sensed.bench, "drive") == "position"
    with pytest.raises(ParameterError, match="No loop `heater`"):
        LoopRuns(sensed.bench, 8.0, drive="heater")


# ---------------------------------------------------------------- searches

QUICK = TuningSearch(random_starts=8, searches=1, iterations=8, clouds=0, slopes=4)


def test_tuning_lowers_the_cost_over_plants(sensed: LoopRuns) -> None:
    plants = draw_plants(sensed.bench, SPREADS, 8, seed=1)
    told: list[float] = []
    found = tune_bench(
        sensed.bench,
        8.0,
        ("Kp", "drive.Ki", "Kd"),
        plants=plants,
        search=QUICK,
        watch=lambda text, share: told.append(share),
    )
    assert found.cost < 0.9 * found.cost_before
    assert found.cost <= min(found.ends)
    assert tuple(found.after) == GAINS
    assert found.bench.value_of("controllers.drive.Kp") == found.after[GAINS[0]]
    assert found.evaluations > 0 < found.gradients
    assert told == sorted(told)
    assert [row[0] for row in found.rows()][:4] == [*GAINS, "cost"]


def test_a_bound_that_is_hit_is_said(sensed: LoopRuns) -> None:
    found = tune_bench(sensed.bench, 8.0, ["Kp=20..200"], search=QUICK)
    assert found.after[GAINS[0]] == pytest.approx(200.0, rel=2e-3)
    assert "ended at its bound 200" in found.notes[0]
    free = tune_bench(sensed.bench, 8.0, ["Kp=10..1e5"], search=QUICK)
    assert not free.notes


def test_a_number_that_does_not_matter_is_left_alone(sensed: LoopRuns) -> None:
    """The time constant of an anti-windup that is not in use."""
    bench = sensed.bench.with_values({"law.tracking": 2.0})
    found = tune_bench(bench, 8.0, ["law.tracking"], search=QUICK)
    assert found.after == pytest.approx(found.before, rel=1e-12)
    assert found.cost == pytest.approx(found.cost_before, rel=1e-9)


def test_signs_are_kept_and_starts_without_one_begin_at_a_bound() -> None:
    bench = linear_bench(-2.0)
    (one,) = build_free_gains(bench, ["Kp"], [{_path(bench, "Kp"): -4.0}])
    assert one.logarithmic
    assert one.low < one.high < 0.0
    assert one.value(one.share(-3.0)) == pytest.approx(-3.0)
    assert one.value(one.share(0.0)) == pytest.approx(one.high)


@pytest.mark.parametrize(
    ("free", "said"),
    [
        ([], "Nothing is free"),
        (["Kq"], "There is no parameter `Kq`"),
        (["Kd"], "sets no bounds"),
        (["Kp=2..1"], "must rise"),
        (["Kp=-1..1 log"], "on one side of 0"),
    ],
)
def test_what_cannot_be_free(free: list[str], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        build_free_gains(linear_bench(), free, [])


def _path(bench: Bench, name: str) -> str:
    return f"controllers.{bench.controllers.resolve(name)}"


def test_without_a_compiler_the_search_has_no_derivatives() -> None:
    bench = linear_bench().with_values({_path(linear_bench(), "Kp"): 0.3})
    found = tune_bench(bench, 3.0, ["Kp"], search=QUICK, native=False)
    assert found.gradients == 0
    assert found.cost < found.cost_before


def test_a_loop_that_cannot_be_run_is_an_error(sensed: LoopRuns, monkeypatch: pytest.MonkeyPatch) -> None:
    failed = lambda self, table: LoopOutputs(*(np.full((len(table), 161), np.nan),) * 5)  # noqa: E731
    monkeypatch.setattr(LoopRuns, "run", failed)
    with pytest.raises(SolveError, match="fails with its present parameters"):
        tune_bench(sensed.bench, 8.0, ["Kp"], starts=[{GAINS[0]: 80.0}], search=QUICK)


def test_a_plant_that_fails_costs_more_than_any_loop_that_works(sensed: LoopRuns) -> None:
    row = sensed.run(sensed.table({}, 2))
    row.output[1] = np.nan
    costs = cost_of(sensed)(row)
    assert costs[0] < 1.0
    assert costs[1] == math.inf


# ---------------------------------------------------------------- against rules


def test_ratios_of_plants() -> None:
    both = OverPlants({"a": np.array([1.0, 2.0, 9.0]), "b": np.array([2.0, 2.0, 3.0])})
    found = both.ratio("a", "b")
    assert (found.median, found.worst, found.won) == (1.0, 3.0, pytest.approx(1.0 / 3.0))
    assert both.best() == "a"
    with pytest.raises(ParameterError, match="There is no set"):
        both.ratio("a", "c")


@pytest.mark.slow
def test_tuned_gains_beat_the_best_rule_on_plants_they_have_not_seen(sensed: LoopRuns) -> None:
    """The rule that is best on those very plants, of all step and relay rules."""
    bench = sensed.bench
    tests = run_loop_tests(bench, 0.004)
    assert tests.cycle is not None
    assert tests.holding.heating > tests.holding.cooling + 0.1
    rules = {name: convert_to_pid(bench, gains) for name, gains in gains_by_tests(tests, bench.period).items()}
    seen, unseen = (draw_plants(bench, SPREADS, 64, seed=seed) for seed in (1, 2))
    start = compare_over_plants(sensed, rules, seen).best()
    tuned = tune_bench(bench, 8.0, plants=seen, starts=[rules[start]], search=TuningSearch(searches=1))
    found = compare_over_plants(sensed, {**rules, "tuned": tuned.after}, unseen)
    best = OverPlants({name: v for name, v in found.itae.items() if name != "tuned"}).best()
    ratio = found.ratio("tuned", best)
    assert ratio.median < 0.8
    assert ratio.won > 0.9
    lost = found.ratio(best, "tuned")
    assert lost.won < 0.1


def test_rules_are_for_a_pid(sensed: LoopRuns) -> None:
    from martensite.control.controllers.relay import OnOff
    from martensite.signals.constant import Constant

    switch = OnOff(measured="position", reference=Constant(level=1e-3), high=1.0)
    bench = sensed.bench.with_parts(controllers=Controllers(drive=switch))
    with pytest.raises(ParameterError, match="controller of `drive` is `on-off`"):
        run_loop_tests(bench, 0.004)
