"""Scores and robust losses, against their definitions, SciPy's losses and normal statistics."""

import math

import numpy as np
import pytest
from scipy import integrate, optimize, stats

from martensite.base.errors import DataError, ParameterError, UnknownNameError
from martensite.fit.losses import LOSSES, estimate_scale, find_loss
from martensite.search.model_score import score_model

TIMES = np.linspace(0.0, 2.0, 5)
MEASURED = np.asarray([0.0, 1.0, 2.0, 1.0, 0.0])


def scored(modelled, measured=MEASURED, **changes):
    given = {"record": "sine", "output": "angle", "unit": "rad"} | changes
    return score_model(TIMES, measured, modelled, **given)


# ---------------------------------------------------------------- scores


def test_a_score_by_hand():
    found = scored([0.0, 1.0, 1.5, 1.0, 0.25])
    assert found.rms == pytest.approx(math.sqrt((0.25 + 0.0625) / 5))
    assert found.fit_percent == pytest.approx(100.0 * (1.0 - math.sqrt(0.3125 / 2.8)))
    assert (found.maximum, found.maximum_at) == (0.5, 1.0)
    assert found.bias == pytest.approx(-0.05)
    assert (found.samples, found.part) == (5, "training")


def test_the_fit_in_its_limits():
    assert scored(MEASURED).fit_percent == 100.0
    assert scored(np.full(5, MEASURED.mean())).fit_percent == pytest.approx(0.0)
    assert scored(5.0 - MEASURED).fit_percent < 0.0
    level = scored(np.zeros(5), measured=np.ones(5))
    assert math.isnan(level.fit_percent)
    assert "does not vary" in level.sentence


def test_the_sentence_is_in_everyday_units():
    found = scored(MEASURED + np.radians([0, 0, 0, 3.0, 0]), part="held-out")
    assert found.sentence == (
        "`sine`, `angle` (held-out): fit 96.9 %, rms error 1.34 deg, at most 3 deg at 1.5 s, bias 0.6 deg."
    )
    assert "at most 3 K" in scored(MEASURED + 3.0, unit="K").sentence


def test_scores_refuse_what_cannot_be_compared():
    for bad in ([1.0], np.full(5, math.nan)):
        with pytest.raises(DataError, match="`angle`"):
            scored(bad)
    with pytest.raises(DataError):
        score_model([], [], [], record="a", output="b")


# ---------------------------------------------------------------- losses


@pytest.mark.parametrize("name", LOSSES)
def test_weights_are_the_slope_of_the_cost_of_scipy(name: str):
    loss = find_loss(name)

    def cost(r: float) -> float:
        found = optimize.least_squares(
            lambda p: np.asarray([r]) + 0.0 * p, [0.0], loss=loss.scipy_name, f_scale=loss.tuning * 0.8
        )
        return found.cost

    for r in (-7.0, -1.0, 1e-3, 0.4, 3.0):
        slope = (cost(r + 1e-5) - cost(r - 1e-5)) / 2e-5
        assert slope == pytest.approx(float(loss.weights([r], 0.8)[0]) * r, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", LOSSES)
def test_tunings_are_95_percent_as_efficient_in_normal_noise(name: str):
    """Efficiency of an M-estimate of a mean: E[ψ']²/E[ψ²], and E[ψ'] = E[r ψ]."""
    loss = find_loss(name)

    def psi(r: float) -> float:
        return float(loss.weights([r])[0]) * r

    def mean(function) -> float:
        edges = [-loss.tuning, loss.tuning]
        return integrate.quad(lambda r: function(r) * stats.norm.pdf(r), -10, 10, points=edges)[0]

    efficiency = mean(lambda r: r * psi(r)) ** 2 / mean(lambda r: psi(r) ** 2)
    assert efficiency == pytest.approx(1.0 if name == "linear" else 0.95, abs=1e-6)


@pytest.mark.parametrize(("name", "robust"), [(n, n != "linear") for n in LOSSES])
def test_outliers_move_only_the_linear_loss(name: str, robust: bool):
    """Reweighted means of 100 numbers about 5, a tenth of them 1000."""
    y = np.random.default_rng(0).normal(5.0, 1.0, 100)
    y[::10] = 1000.0
    loss, mean = find_loss(name), float(np.median(y))
    for _ in range(100):
        weights = loss.weights(y - mean, estimate_scale(y - mean))
        mean = float(np.sum(weights * y) / np.sum(weights))
    assert (abs(mean - 5.0) < 0.5) is robust


def test_the_scale_is_that_of_normal_noise_whatever_the_outliers():
    r = np.random.default_rng(1).normal(3.0, 2.0, 20_001)
    assert estimate_scale(r) == pytest.approx(2.0, rel=0.03)
    assert estimate_scale([1.0, 2.0, 3.0, 4.0, 1e9]) == pytest.approx(1.4826, rel=1e-4)
    assert pytest.approx(1.0 / stats.norm.ppf(0.75), rel=1e-12) == estimate_scale([-1.0, 0.0, 1.0])
    r[::4] = 1e6
    assert estimate_scale(r) < 4.0
    assert np.std(r) > 1e5


def test_losses_refuse_bad_input():
    with pytest.raises(UnknownNameError, match="`huber`"):
        find_loss("Hubert")
    with pytest.raises(ParameterError, match="scale"):
        find_loss("huber").weights([1.0], 0.0)
    for bad in ([], [math.nan]):
        with pytest.raises(DataError):
            estimate_scale(bad)
