"""Posterior samples agree with intervals where the problem is nearly linear."""

from __future__ import annotations

import math

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.posterior import SPLIT, Posterior, sample_posterior
from martensite.fit.problem import build_problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import read_scenario
from martensite.search.free_numbers import SearchRange
from martensite.signals.records import Record
from martensite.simulate.api import simulate

SCENARIO = """
[element]
kind = "wire"
material = "flexinol-90"
law = { kind = "liang-rogers", modulus = "mixture" }
diameter = "0.381 mm"
length = "100 mm"

[mechanism]
kind = "dead-weight"
mass = "1 kg"

[drive]
kind = "temperature"
waveform = { kind = "triangle", low = "30 degC", high = "130 degC", frequency = "0.01 Hz" }

[run]
duration = "100 s"
samples = 51
"""
NOISE = 2e-4


@pytest.fixture(scope="module")
def fit(c_compiler: str) -> Fit:
    scenario = read_scenario(SCENARIO)
    run = simulate(scenario.system, scenario.waveform, 100.0, step=2.0, samples=51)
    noise = NOISE * np.random.default_rng(1).standard_normal(51)
    strain = (np.array(run["strain"]) + noise).tolist()
    record = Record("pull", {"time": run.times, "strain": strain}, {"time": "s", "strain": "1"})
    one = Experiment("pull", scenario.system, scenario.waveform, record, {"strain": "strain"})
    return solve_problem(build_problem([one], [SearchRange("eps_L", 0.03, 0.05), SearchRange("A_f", 340.0, 365.0)]))


@pytest.fixture(scope="module")
def sampled(fit: Fit) -> Posterior:
    return sample_posterior(fit, draws=150, warmup=100, chains=2)


@pytest.mark.slow
def test_draws_and_intervals_agree(fit: Fit, sampled: Posterior) -> None:
    assert sampled.settled, sampled.sentence
    for name in fit.problem.names:
        low, high = fit.uncertainty.widened(name)
        width = high - low
        assert np.allclose(sampled.interval(name), (low, high), atol=0.2 * width), name


@pytest.mark.slow
def test_half_the_interval_would_not_agree(fit: Fit, sampled: Posterior) -> None:
    low, high = fit.uncertainty.widened("eps_L")
    middle, quarter = 0.5 * (low + high), 0.25 * (high - low)
    half = (middle - quarter, middle + quarter)
    assert not np.allclose(sampled.interval("eps_L"), half, atol=0.15 * (high - low))


def test_a_few_draws_are_drawn(fit: Fit) -> None:
    found = sample_posterior(fit, draws=4, warmup=4, chains=1)
    assert all(len(draws) == 4 for draws in found.samples.values())
    low, high = fit.problem.free[0].low, fit.problem.free[0].high
    assert all(low < value < high for value in found.samples["eps_L"])


def test_chains_that_have_not_met_are_told() -> None:
    apart = Posterior({"eps_L": np.zeros(4)}, 2, {"eps_L": SPLIT + 0.1}, {"eps_L": 3.0}, 0)
    assert not apart.settled
    assert "Not settled" in apart.sentence


def test_no_draw_is_refused(fit: Fit) -> None:
    with pytest.raises(ParameterError, match="at least 1"):
        sample_posterior(fit, draws=0)
    assert math.isfinite(fit.cost)
