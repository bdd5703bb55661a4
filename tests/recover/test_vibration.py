"""Free vibration: frequency, damping and their intervals are found again; filters and formulas.

Source of truth: records in closed form with known frequency, damping, offset and noise. Over 200
of them the share of 95 % intervals that hold the truth must lie within what a binomial
distribution allows (99.99 %), and intervals of half the width must not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy import stats

from martensite.base.confidence import Interval, interval_contains
from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.free_vibration import (
    LogDecrement,
    compute_natural_frequency,
    damping_ratio,
    log_decrement,
    moving_mass,
)
from martensite.characterise.spectrum import natural_frequency

Rows = tuple[list[float], list[float]]
F, ZETA, OFFSET = 8.42, 0.02, 0.3
REPETITIONS, FEW = 200, 50
ALLOWED, OF_FEW = (stats.binom.interval(0.9999, count, 0.95) for count in (REPETITIONS, FEW))


def released(
    *,
    f: float = F,
    zeta: float = ZETA,
    offset: float = OFFSET,
    noise: float = 0.0,
    rate: float = 500.0,
    length: float = 4.0,
    held: float = 0.0,
    seed: int = 0,
) -> Rows:
    """A beam that is let go from 1 beside its rest, after it was held for some time."""
    times = np.arange(round(length * rate)) / rate
    free = np.maximum(times - held, 0.0)
    omega, root = 2.0 * math.pi * f, math.sqrt(1.0 - zeta**2)
    turn = omega * root * free
    x = np.exp(-zeta * omega * free) * (np.cos(turn) + zeta / root * np.sin(turn))
    x = offset + x + np.random.default_rng(seed).normal(0.0, noise, times.size)
    return times.tolist(), x.tolist()


@cache
def noisy(seed: int) -> LogDecrement:
    return log_decrement(*released(noise=0.02, seed=seed))


def half_as_wide(found: MeasuredValue) -> Interval:
    low, high = found.interval()
    return found.value - 0.25 * (high - low), found.value + 0.25 * (high - low)


def held(interval_of: Callable[[LogDecrement], Interval], truth: float, count: int = REPETITIONS) -> int:
    """In how many of the repetitions the interval holds the truth."""
    return sum(interval_contains(interval_of(noisy(seed)), truth) for seed in range(count))


# ---------------------------------------------------------------- spectrum


@pytest.mark.parametrize("f", [3.3, 8.42, 20.01])
def test_frequency_of_a_sine_lies_between_the_bins(f: float) -> None:
    times = np.arange(1000) / 250.0
    peak = natural_frequency(times.tolist(), (5.0 + 2.0 * np.sin(2 * np.pi * f * times)).tolist(), steady=True)
    assert peak.resolution == pytest.approx(0.25)
    assert peak.frequency == pytest.approx(f, abs=1e-3 * peak.resolution)
    assert peak.amplitude == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("zeta", [0.002, 0.01, 0.05, 0.1])
def test_frequency_of_a_decay(zeta: float) -> None:
    peak = natural_frequency(*released(zeta=zeta, noise=0.01))
    assert peak.frequency == pytest.approx(F, rel=zeta**2 + 1e-3)


def test_a_band_chooses_the_weaker_of_two() -> None:
    times = np.arange(2000) / 500.0
    both = np.sin(2 * np.pi * 8.0 * times) + 0.2 * np.sin(2 * np.pi * 50.0 * times)
    rows = times.tolist(), both.tolist()
    assert natural_frequency(*rows).frequency == pytest.approx(8.0, abs=0.01)
    assert natural_frequency(*rows, low=30.0).frequency == pytest.approx(50.0, abs=0.01)
    assert natural_frequency(*rows, high=30.0).frequency == pytest.approx(8.0, abs=0.01)


def test_records_without_a_vibration_are_refused() -> None:
    times = (np.arange(1000) / 100.0).tolist()
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0.0, 1.0, 1000).tolist()
        with pytest.raises(DataError, match="No vibration stands out"):
            natural_frequency(times, noise)
    for drift in ([0.0] * 1000, list(times), [math.exp(-time) for time in times]):
        with pytest.raises(DataError, match="No vibration stands out"):
            natural_frequency(times, drift)


def test_unequal_times_are_refused() -> None:
    times, values = released()
    with pytest.raises(DataError, match="equally spaced"):
        natural_frequency(times[:900] + times[910:], values[:900] + values[910:])
    with pytest.raises(DataError, match="at least 16 rows"):
        natural_frequency(times[:15], values[:15])
    with pytest.raises(DataError, match="equal lengths"):
        natural_frequency(times[1:], values)
    with pytest.raises(DataError, match="finite"):
        natural_frequency(times, [*values[1:], math.nan])
    with pytest.raises(ParameterError, match="half the sampling rate"):
        natural_frequency(times, values, low=300.0)
    with pytest.raises(ParameterError, match="narrower"):
        natural_frequency(times, values, low=8.0, high=8.1)
    jitter = np.random.default_rng(0).uniform(-0.2, 0.2, len(times)) / 500.0
    shaken = sorted((np.array(times) + jitter).tolist())
    assert natural_frequency(shaken, values).frequency == pytest.approx(F, abs=0.02)


# ---------------------------------------------------------------- decrement


@pytest.mark.parametrize("zeta", [0.001, 0.02, 0.1])
@pytest.mark.parametrize("rate", [110.0, 1000.0])
def test_decay_without_noise(zeta: float, rate: float) -> None:
    found = log_decrement(*released(zeta=zeta, rate=rate))
    assert found.zeta.value == pytest.approx(zeta, rel=1e-5)
    assert found.frequency.value == pytest.approx(F, rel=1e-5)
    assert found.damped_frequency.value == pytest.approx(F * math.sqrt(1.0 - zeta**2), rel=1e-5)
    assert found.decrement.value == pytest.approx(2.0 * math.pi * zeta / math.sqrt(1.0 - zeta**2), rel=1e-5)
    assert found.offset.value == pytest.approx(OFFSET, abs=1e-5)


@pytest.mark.slow
def test_intervals_hold_the_truth() -> None:
    assert ALLOWED[0] <= held(lambda fit: fit.zeta.interval(), ZETA) <= ALLOWED[1]
    assert ALLOWED[0] <= held(lambda fit: fit.frequency.interval(), F) <= ALLOWED[1]
    assert ALLOWED[0] <= held(lambda fit: fit.offset.interval(), OFFSET) <= ALLOWED[1]


def test_intervals_that_are_too_short_are_noticed() -> None:
    assert (
        held(lambda fit: half_as_wide(fit.zeta), ZETA, FEW)
        < OF_FEW[0]
        <= held(lambda fit: fit.zeta.interval(), ZETA, FEW)
    )
    assert held(lambda fit: half_as_wide(fit.frequency), F, FEW) < OF_FEW[0]


def test_noise_is_found_and_ends_the_use_of_extremes() -> None:
    quiet, loud = noisy(0), log_decrement(*released(noise=0.1))
    assert quiet.extremes.noise == pytest.approx(0.02, rel=0.1)
    assert loud.extremes.noise == pytest.approx(0.1, rel=0.1)
    assert loud.cycles < quiet.cycles
    assert quiet.zeta.error < loud.zeta.error < 0.1 * ZETA


def test_offset_and_unit_do_not_matter() -> None:
    times, values = released(noise=0.01)
    moved = [3.0 - 1e-6 * value for value in values]
    first, second = log_decrement(times, values), log_decrement(times, moved)
    assert second.zeta.value == pytest.approx(first.zeta.value, rel=1e-6)
    assert second.amplitude.value == pytest.approx(1e-6 * first.amplitude.value, rel=1e-6)
    assert second.offset.value == pytest.approx(3.0 - 1e-6 * first.offset.value, rel=1e-9)
    assert (first.extremes.first_sign, second.extremes.first_sign) == (-1.0, 1.0)


def test_a_hold_before_the_release_is_passed_over() -> None:
    for seed in range(20):
        found = log_decrement(*released(noise=0.02, held=0.7, seed=seed), frequency=8.5)
        assert found.zeta.value == pytest.approx(ZETA, rel=0.03)
        assert found.extremes.times[0] > 0.7


def test_cycles_and_least() -> None:
    rows = released()
    assert log_decrement(*rows, cycles=5).cycles == 5.0
    assert log_decrement(*rows, least=0.5).cycles < log_decrement(*rows).cycles
    with pytest.raises(ParameterError, match="`cycles`"):
        log_decrement(*rows, cycles=1)
    with pytest.raises(ParameterError, match="`least`"):
        log_decrement(*rows, least=1.0)
    with pytest.raises(ParameterError, match="`frequency`"):
        log_decrement(*rows, frequency=-1.0)


def test_too_few_peaks_or_rows() -> None:
    times, values = released(zeta=0.4, rate=2000.0, length=1.0)
    with pytest.raises(DataError, match="at least 3 peaks"):
        log_decrement(times, values, frequency=F)
    with pytest.raises(DataError, match="rows per cycle"):
        log_decrement(*released(rate=60.0))
    short = released(length=0.3)
    with pytest.raises(DataError, match="at least 3 peaks, but 2 were found"):
        log_decrement(*short, frequency=F)


def test_dry_friction_is_no_exponential() -> None:
    """Peaks on a straight line: the scatter about the exponential is far above the noise."""
    times = np.arange(2000) / 500.0
    x = np.maximum(1.0 - 0.2 * times, 0.0) * np.cos(2 * np.pi * F * times)
    dry = log_decrement(times.tolist(), x.tolist())
    free = log_decrement(*released(zeta=0.005))
    assert dry.zeta.error / dry.zeta.value > 10.0 * free.zeta.error / free.zeta.value


def test_numbers_by_name() -> None:
    numbers = noisy(0).to_dict()
    assert numbers["zeta"]["interval"][0] < ZETA < numbers["zeta"]["interval"][1]
    assert len(numbers["extreme_times"]) == 2 * numbers["cycles"] + 1


# ---------------------------------------------------------------- a mass on a spring


def test_published_frequency_belongs_to_neither_published_mass() -> None:
    """8.42 Hz with k = 541 N/m; the masses are those of Tables 3 and 5 of Kossoski (2018)."""
    assert compute_natural_frequency(541.0, 0.25) == pytest.approx(7.404, abs=1e-3)
    assert compute_natural_frequency(541.0, 0.19) == pytest.approx(8.493, abs=1e-3)
    for mass in (0.25, 0.19):
        for stiffness in (540.1, 541.0):
            assert abs(compute_natural_frequency(stiffness, mass) - 8.42) > 0.05
    assert moving_mass(541.0, 8.42) == pytest.approx(0.1933, abs=1e-4)
    assert compute_natural_frequency(541.0, moving_mass(541.0, 8.42)) == pytest.approx(8.42)


def test_damping() -> None:
    assert damping_ratio(2.0 * math.pi * 0.3 / math.sqrt(1.0 - 0.09)) == pytest.approx(0.3)
