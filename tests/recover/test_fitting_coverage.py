"""Intervals of fitted parameters hold the truth as often as they say, and whiteness errs as often.

A line is fitted to noise in 400 repetitions. With white noise the share of 95 % intervals that
hold the truth must lie within what a binomial distribution allows (99.99 %); with noise that has
a memory those for independent samples must fall short, and the widened ones must not.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy import signal, stats

from martensite.base.confidence import Interval, interval_contains
from martensite.search.uncertainty import Uncertainty, estimate_uncertainty
from martensite.search.whiteness import assess_whiteness

REPETITIONS = 400
ALLOWED = stats.binom.interval(0.9999, REPETITIONS, 0.95)
TRUTH = (2.0, -1.0)
PHI = 0.7
Judge = Callable[[Uncertainty, str], Interval]


def noise(seed: int, count: int, phi: float) -> np.ndarray:
    """AR(1) noise of unit variance; white for φ = 0."""
    steps = np.random.default_rng(seed).normal(size=count)
    steps[1:] *= math.sqrt(1.0 - phi * phi)
    return np.asarray(signal.lfilter([1.0], [1.0, -phi], steps))


@cache
def fitted(seed: int, count: int, phi: float) -> Uncertainty:
    """A line through two records of different length, and its errors."""
    first = 2 * count // 3
    x = np.concatenate([np.linspace(-1, 1, first), np.linspace(-1, 1, count - first)])
    columns = np.stack([x**0, x], axis=1)
    y = columns @ TRUTH
    y += np.append(noise(seed, first, phi), noise(seed + 10_000, count - first, phi))
    values = np.linalg.lstsq(columns, y, rcond=None)[0]
    return estimate_uncertainty(
        columns @ values - y,
        columns * [5.0, 3.0],
        ["a", "b"],
        values=values.tolist(),
        scales=[5.0, 3.0],
        lengths=[first, count - first],
    )


def held(judge: Judge, place: int, count: int, phi: float) -> int:
    """In how many repetitions the interval holds the truth."""
    name = "ab"[place]
    fits = (fitted(seed, count, phi) for seed in range(REPETITIONS))
    return sum(interval_contains(judge(fit, name), TRUTH[place]) for fit in fits)


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("count", [12, 60])
def test_intervals_hold_the_truth_in_white_noise(place: int, count: int) -> None:
    assert ALLOWED[0] <= held(Uncertainty.interval, place, count, 0.0) <= ALLOWED[1]


@pytest.mark.parametrize("place", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_noise_with_memory_needs_the_widened_intervals(place: int) -> None:
    short = held(Uncertainty.interval, place, 600, PHI)
    wide = held(Uncertainty.widen_interval, place, 600, PHI)
    assert short < 0.75 * REPETITIONS
    assert ALLOWED[0] <= wide <= ALLOWED[1]


def test_widened_intervals_cost_little_in_white_noise() -> None:
    assert ALLOWED[0] <= held(Uncertainty.widen_interval, 1, 60, 0.0)
    factors = [fitted(seed, 600, 0.0).widening for seed in range(50)]
    assert max(factors) < 1.5
    assert np.mean(factors) < 1.1


@pytest.mark.parametrize("count", [60, 500])
def test_white_noise_is_called_white_in_nineteen_of_twenty(count: int) -> None:
    white = sum(assess_whiteness(noise(s, count, 0.0)).white for s in range(REPETITIONS))
    assert ALLOWED[0] <= white <= ALLOWED[1]


def test_noise_with_memory_is_hardly_ever_called_white() -> None:
    white = sum(assess_whiteness(noise(s, 200, PHI)).white for s in range(REPETITIONS))
    assert white == 0
