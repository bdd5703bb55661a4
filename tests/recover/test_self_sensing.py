"""Self-sensing: a wire in a loop without a position sensor, and filters that know their errors.

Sources of truth: the simulated plant itself, whose position no controller sees; the chi-square
distribution. All readings of the resistance have a noise of 1 %.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from rphase_cases import rphase_system, two_phase_model
from sensing_cases import SINE, STEPS, STROKE, rms, run, sensing_bench, sensing_plant, shaken

from martensite.control.loop.consistency import Consistency, check_consistency
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.observers.inverse import InverseModel
from martensite.control.observers.unscented import UnscentedKalman
from martensite.signals.sine import Sine

PLANT = sensing_plant()
QUIET: dict[str, Any] = {"model": PLANT, "temperature_noise": 0.3, "fraction_noise": 0.01}
EXTENDED, UNSCENTED = ExtendedKalman(**QUIET), UnscentedKalman(**QUIET)
DIAMETER = ExtendedKalman(
    **QUIET, drifting=("element.diameter",), first_drift=0.03, drift_noise=1e-4, first_fraction=0.002
)
SETTLED = 7.5
"""Of the 15 s of a step, those in which it may move [s]."""


def shares(observer: Any, reference: Any, **changed: float) -> tuple[float, float]:
    """Rms errors of the estimate and of the tracking in a sensorless loop, shares of the stroke."""
    values = {name: factor * PLANT.value_of(name) for name, factor in changed.items()}
    found = run(sensing_bench(PLANT.with_values(values), observer, reference))
    counts = found["times"] > 5.0
    if reference is STEPS:
        counts &= found["times"] % 15.0 > SETTLED
    error = found["estimated.position"] - found["position"]
    off = found["position"] - found["reference"]
    return rms(error[counts]) / STROKE, rms(off[counts]) / STROKE


# ---------------------------------------------------------------- without a position sensor


@pytest.mark.parametrize("reference", [SINE, STEPS], ids=["sine", "steps"])
def test_it_tracks_by_its_resistance(reference: Any) -> None:
    estimate, tracking = shares(EXTENDED, reference)
    assert estimate < 0.01
    assert tracking < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("reference", [SINE, STEPS], ids=["sine", "steps"])
@pytest.mark.parametrize("observer", [UNSCENTED, InverseModel(model=PLANT, lag=0.3)], ids=["unscented", "inverse"])
def test_so_do_the_other_observers(observer: Any, reference: Any) -> None:
    estimate, tracking = shares(observer, reference)
    assert estimate < 0.015
    assert tracking < 0.02


@pytest.mark.slow
def test_an_inverse_model_alone_passes_the_noise_on() -> None:
    """1 % of noise over a sensitivity of about 7 % to 18 %."""
    estimate, _ = shares(InverseModel(model=PLANT), SINE)
    assert 0.03 < estimate < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_another_film_coefficient_hardly_matters(factor: float) -> None:
    _, tracking = shares(EXTENDED, SINE, h0=factor)
    assert tracking < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_another_diameter_must_be_estimated(factor: float) -> None:
    """It changes the resistance by 6 %, about as much as all of a transformation."""
    believed, _ = shares(EXTENDED, SINE, diameter=factor)
    assert believed > 0.2
    estimate, tracking = shares(DIAMETER, SINE, diameter=factor)
    assert estimate < 0.015
    assert tracking < 0.03


# ---------------------------------------------------------------- a wire with an R-phase

LAGGED: dict[str, Any] = {"lag": 0.3}
NOISE: dict[str, Any] = {"temperature_noise": 0.3, "fraction_noise": 0.01}
THREE: dict[type, float] = {ExtendedKalman: 0.01, UnscentedKalman: 0.015, InverseModel: 0.1}
"""Largest rms error of the position with three phases, as a share of the stroke of 10 mm."""


@pytest.mark.parametrize("cls", [ExtendedKalman, *(pytest.param(c, marks=pytest.mark.slow) for c in list(THREE)[1:])])
def test_an_observer_that_knows_the_r_phase_errs_at_most_half_as_much(cls: Any) -> None:
    """Both know every number that they have; the other one takes the bump of the resistance for martensite."""
    plant, errors = rphase_system(), list[float]()
    for model in (plant, two_phase_model()):
        observer = cls(model=model, **(LAGGED if cls is InverseModel else NOISE))
        wave = {"drive": Sine(low=0.02, high=0.2, frequency=0.05)}
        found = run(sensing_bench(plant, observer), waveforms=wave, seed=1)
        assert found["rphase_fraction"].max() > 0.9
        errors.append(rms((found["estimated.position"] - found["position"])[found["times"] > 3.0]))
    assert errors[0] < THREE[cls] * 10e-3
    assert errors[0] <= 0.5 * errors[1]


# ---------------------------------------------------------------- how wrong a filter says it is

PARTIAL, WIDE = (Sine(low=0.03, high=high, frequency=0.1) for high in (0.25, 0.4))


@cache
def judged(cls: type, wave: Sine, trust: float = 1.0) -> Consistency:
    """50 runs on a plant with the noise a filter reckons with, or 1/trust of it."""
    noise = {"temperature_noise": 0.5 / trust, "fraction_noise": 0.02 / trust}
    bench = sensing_bench(shaken(PLANT), cls(model=PLANT, **noise))
    return check_consistency(bench, 30.0, waveforms={"drive": wave}, runs=50)


def check_consistent(found: Consistency) -> None:
    """In the mean over time, and in most samples."""
    late = found.times > 5.0
    assert found.degrees - 0.4 < found.nees[late].mean() < found.degrees + 0.4
    assert found.nis[late].mean() == pytest.approx(1.0, abs=0.03)
    assert found.inside(0.95) > 0.75


@pytest.mark.slow
@pytest.mark.parametrize("cls", [ExtendedKalman, UnscentedKalman])
def test_errors_are_as_large_as_the_filter_says(cls: type) -> None:
    check_consistent(judged(cls, PARTIAL))


@pytest.mark.slow
def test_a_filter_that_trusts_its_model_too_much_is_found_out() -> None:
    found = judged(ExtendedKalman, PARTIAL, trust=3.0)
    assert found.nees.mean() > 2.0 * found.degrees
    assert found.inside(0.95) < 0.3
    with pytest.raises(AssertionError):
        check_consistent(found)


@pytest.mark.slow
def test_through_whole_loops_it_is_overconfident_for_a_while() -> None:
    """Where a process begins anew, its history is unknown, and no state of the filter."""
    found = judged(ExtendedKalman, WIDE)
    mean = found.nees.mean(axis=1)
    assert mean.max() > 3.0 * found.degrees
    assert np.median(mean) == pytest.approx(found.degrees, abs=0.4)


@pytest.mark.slow
def test_bands_are_those_of_the_chi_square_distribution() -> None:
    found = judged(ExtendedKalman, PARTIAL)
    draw = np.random.default_rng(0).chisquare(2, (20000, 50)).mean(axis=1)
    low, high = found.band(0.9)
    assert np.mean((draw > low) & (draw < high)) == pytest.approx(0.9, abs=0.01)
    assert found.runs == 50
