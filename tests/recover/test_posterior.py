"""Posterior samples agree with intervals where the problem is nearly linear, and with closed forms at a bound.

Sources of truth: the intervals of least squares, the quantiles of a half-normal distribution, and the numbers that
records were made with, over repetitions with other noise.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from one_wire import hang, write_wire
from scipy import stats

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.posterior import LONG_ENOUGH, Posterior, sample_posterior
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import read_scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record
from martensite.simulate.api import simulate

SCENARIO = write_wire(
    diameter="0.381 mm",
    length="100 mm",
    cooling="",
    mechanism=hang("1 kg"),
    drive='kind = "temperature"\n'
    'waveform = { kind = "triangle", low = "30 degC", high = "130 degC", frequency = "0.01 Hz" }',
    run='duration = "100 s"\nsamples = 51',
)
NOISE = 2e-4


STRAIN, FINISH = SearchRange("eps_L", 0.03, 0.05), SearchRange("A_f", 340.0, 365.0)


def fit_pull(*free: SearchRange, seed: int = 1) -> Fit:
    """Fit parameters to one noisy record of the scenario."""
    scenario = read_scenario(SCENARIO)
    run = simulate(scenario.system, scenario.waveform, 100.0, step=2.0, samples=51)
    noise = NOISE * np.random.default_rng(seed).standard_normal(51)
    strain = (np.array(run["strain"]) + noise).tolist()
    record = Record("pull", {"time": run.times, "strain": strain}, {"time": "s", "strain": "1"})
    one = Experiment("pull", scenario.system, scenario.waveform, record, {"strain": "strain"})
    return solve_problem(build_problem([one], free))


@pytest.fixture(scope="module")
def fit(c_compiler: str) -> Fit:
    return fit_pull(STRAIN, FINISH)


@pytest.fixture(scope="module")
def sampled(fit: Fit) -> Posterior:
    return sample_posterior(fit, draws=450, warmup=100)


def test_draws_and_intervals_agree(fit: Fit, sampled: Posterior) -> None:
    assert sampled.converged, sampled.sentence
    for name in fit.problem.names:
        low, high = fit.uncertainty.widen_interval(name)
        width = high - low
        assert np.allclose(sampled.interval(name), (low, high), atol=0.1 * width), name


def test_a_bound_at_the_optimum_leaves_half_a_normal_distribution(c_compiler: str) -> None:
    free = fit_pull(STRAIN)
    bound, error = free["eps_L"], free.uncertainty.errors[0] * free.uncertainty.widening
    bounded = sample_posterior(fit_pull(SearchRange("eps_L", 0.03, bound)), draws=200, warmup=100)
    ends = bound - error * stats.halfnorm.ppf([0.975, 0.025])
    assert bounded.samples["eps_L"].max() < bound
    assert np.allclose(bounded.interval("eps_L"), ends, atol=0.15 * error)


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_state(c_compiler: str) -> None:
    system = read_scenario(SCENARIO).system
    count, found = 30, {0.5: 0, 0.95: 0}
    for seed in range(count):
        drawn = sample_posterior(fit_pull(STRAIN, FINISH, seed=seed), draws=150, warmup=100, seed=seed)
        for level in found:
            for name in ("eps_L", "A_f"):
                low, high = drawn.interval(name, level)
                found[level] += low <= system.value_of(system.resolve(name)) <= high
    for level, held in found.items():
        least, most = stats.binom.ppf([0.001, 0.999], 2 * count, level)
        assert least <= held <= most, level


def test_the_same_seed_draws_the_same(fit: Fit) -> None:
    one, two, other = (sample_posterior(fit, draws=4, warmup=4, seed=seed).samples["A_f"] for seed in (1, 1, 2))
    assert (one == two).all()
    assert not (one == other).any()
    assert len(one) == 4 * 32


def test_a_short_chain_has_not_converged(fit: Fit) -> None:
    found = sample_posterior(fit, draws=30, warmup=4)
    assert not found.converged
    assert found.sentence.startswith("Not converged: 32 walkers made 30 steps each")
    longest = max(found.times.values())
    assert f"Take at least {math.ceil(LONG_ENOUGH * longest)} steps" in found.sentence


def test_draws_that_do_not_move_have_not_converged() -> None:
    still = Posterior({"eps_L": np.zeros(4)}, 2, 2, {"eps_L": math.nan})
    assert not still.converged
    assert "`eps_L` did not move" in still.sentence


def test_no_draw_is_refused(fit: Fit) -> None:
    with pytest.raises(ParameterError, match="at least 1"):
        sample_posterior(fit, draws=0)
