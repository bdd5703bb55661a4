"""Noise in a column that drives counts: intervals hold the truth as often as they say, loops stay steep.

Source of truth: the numbers that were put in, over repetitions with other noise.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from input_noise_cases import FREE, build_loops, draw_problem, fit_loops, judge_fits
from scipy import stats

from martensite.fit.column_noise import estimate_column_noise
from martensite.fit.solve import solve_problem

FEW, MANY = 3, 20


def test_noise_of_a_column_is_told_from_its_signal() -> None:
    chance = np.random.default_rng(1)
    times = np.cumsum(chance.uniform(0.5, 1.5, 400))
    noise = 0.3 * chance.standard_normal(400)
    for signal in (
        0.0 * times,
        300.0 + np.abs(times - 200.0),
        300.0 + 40.0 * np.sin(times / 20.0),
        5.0 * (times > 99.0),
    ):
        assert estimate_column_noise(times, signal + noise) == pytest.approx(0.3, rel=0.12)
        assert estimate_column_noise(times, signal) < 1e-3
    assert estimate_column_noise(times[:8], noise[:8]) == 0.0


def test_intervals_hold_the_truth_with_a_noisy_temperature() -> None:
    """Those that ignore the noise hold it in about half of the cases, which must fail this test."""
    held, apart = judge_fits([fit_loops(seed, 0.3) for seed in range(FEW)])
    ignored, _ = judge_fits([fit_loops(seed, 0.3, inputs=False) for seed in range(FEW)])
    allowed = stats.binom.ppf(0.001, held.size, 0.95)
    assert held.sum() >= allowed
    assert ignored.sum() < allowed
    assert np.sqrt(np.mean(apart**2)) < 1.6


def test_noise_is_said_and_a_clean_column_has_none() -> None:
    noisy, clean = fit_loops(0, 0.3), fit_loops(0, 0.0)
    assert [one.column for one in noisy.input_noise] == ["temperature"]
    assert noisy.input_noise[0].sigma == pytest.approx(0.3, rel=0.15)
    assert not clean.input_noise
    assert clean.values == fit_loops(0, 0.0, inputs=False).values


def test_costs_of_many_points_count_the_noise_as_one_evaluation_does() -> None:
    fit = fit_loops(0, 0.3)
    points = np.array(fit.values) + np.array([[0.0], [0.01]])
    alone = [fit.problem.evaluate(u) for u in points]
    assert fit.problem.corrections
    assert fit.problem.costs(points) == pytest.approx([one.cost for one in alone if one is not None], rel=1e-9)


def test_declared_noise_is_taken_as_it_is() -> None:
    problem = replace(draw_problem(0, 0.3), input_noise={"temperature": 0.6})
    twice, once = solve_problem(problem), fit_loops(0, 0.3)
    assert twice.input_noise[0] == ("drive", "temperature", 0.6, True)
    ratio = np.array(twice.uncertainty.errors[:4]) / once.uncertainty.errors[:4]
    assert np.all(ratio > 1.3)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3, 1.0])
def test_coverage_at_every_level_of_noise(noise: float) -> None:
    held, apart = judge_fits([fit_loops(seed, noise) for seed in range(MANY)])
    low, high = stats.binom.ppf([0.001, 0.9999], held.size, 0.95)
    assert low <= held.sum() <= high
    assert np.all(np.abs(apart.mean(axis=0)) < 3.5 / math.sqrt(MANY))
    assert set(build_loops()[2]) == set(FREE)
