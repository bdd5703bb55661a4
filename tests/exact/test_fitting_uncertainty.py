"""Errors of fitted parameters, whiteness and effective samples, against closed forms.

Sources of truth: NumPy's covariance of linear least squares; the fit of powers of this project;
the autocorrelation and the number of independent samples of an AR(1) series; χ² by SciPy.
"""

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

from martensite.base.confidence import EVERYTHING
from martensite.base.errors import DataError, ParameterError, UnknownNameError
from martensite.characterise.regression import fit_powers
from martensite.search.uncertainty import estimate_uncertainty
from martensite.search.whiteness import assess_whiteness, compute_autocorrelation, count_effective_samples

X = np.linspace(0.0, 3.0, 25)
SCALES = [4.0, -2.0, 0.5]
NAMES = ["a", "b", "c"]


def parabola(seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns, values and residuals of a parabola fitted to noise."""
    y = 1.0 + 2.0 * X - 0.5 * X**2 + np.random.default_rng(seed).normal(0.0, 0.3, X.size)
    columns = np.stack([X**0, X, X**2], axis=1)
    values = np.linalg.lstsq(columns, y, rcond=None)[0]
    return columns, values, columns @ values - y


def judged(**changes):
    columns, values, residuals = parabola()
    given: dict[str, Any] = {"values": values.tolist(), "scales": SCALES}
    given |= changes
    return estimate_uncertainty(residuals, columns * given["scales"], NAMES, **given)


# ---------------------------------------------------------------- linear models


def test_covariance_is_that_of_linear_least_squares():
    columns, _, residuals = parabola()
    found = judged()
    s2 = residuals @ residuals / (X.size - 3)
    expected = s2 * np.linalg.inv(columns.T @ columns)
    assert np.asarray(found.covariance) == pytest.approx(expected, rel=1e-9)
    assert found.noise == pytest.approx(math.sqrt(s2))
    assert found.freedom == X.size - 3


def test_intervals_are_those_of_the_fit_of_powers():
    y = parabola()[0] @ parabola()[1] - parabola()[2]
    other, found = fit_powers(X.tolist(), y.tolist(), (0, 1, 2)), judged()
    for k, name in enumerate(NAMES):
        assert found.interval(name, 0.9) == pytest.approx(other.interval(k, 0.9), rel=1e-9)
        assert found.errors[k] == pytest.approx(other.error(k), rel=1e-9)


def test_a_logarithmic_scale_gives_the_same_errors():
    """dx/dz of another scale at the optimum: the Jacobian per range is another, not the errors."""
    scales = [parabola()[1][0] * math.log(100.0), 7.0, 1e-3]
    found, other = judged(scales=scales), judged()
    assert found.errors == pytest.approx(other.errors, rel=1e-9)
    assert np.asarray(found.correlation) == pytest.approx(np.asarray(other.correlation), rel=1e-9)


def test_strong_correlations_are_named():
    found = judged()
    correlation = np.asarray(found.correlation)
    assert np.diag(correlation) == pytest.approx(1.0)
    assert [pair[:2] for pair in found.list_confounded()] == [("b", "c")]
    assert found.list_confounded()[0][2] == pytest.approx(correlation[1, 2])
    assert any("`b` and `c` compensate each other (correlation -0.9" in s for s in found.sentences)
    assert len(found.list_confounded(0.5)) > 1
    assert not found.list_confounded(0.999)


def test_a_redundant_parameter_has_an_infinite_error_and_the_others_keep_theirs():
    """b and c act only through their sum; a is as certain as in the fit without c."""
    y = 1.0 + 2.0 * X + np.random.default_rng(2).normal(0.0, 0.3, X.size)
    line = fit_powers(X.tolist(), y.tolist(), (0, 1))
    residuals = line.values[0] + line.values[1] * X - y
    columns = np.stack([X**0, X, X * 3.0], axis=1)
    found = estimate_uncertainty(residuals, columns, NAMES, values=[1.0, 2.0, 0.0], scales=[1, 1, 1])
    assert found.errors[1:] == (math.inf, math.inf)
    assert found.interval("b") == found.widen_interval("c") == EVERYTHING
    assert found.errors[0] == pytest.approx(line.error(0), rel=1e-9)
    assert found.rank == 2
    assert found.freedom == X.size - 2
    assert "The data do not determine `b` and `c`." in found.sentences
    assert math.isnan(found.correlation[0][1])
    assert found.covariance[1][1] == math.inf


@pytest.mark.parametrize("share", [1e-9, 1e-6, 1e-3, 1.0])
def test_no_undetermined_parameter_gets_a_small_error(share: float):
    """However little of the redundancy it takes: b = share × what makes up for a."""
    columns = np.stack([X, -X / share, X**2], axis=1)
    found = estimate_uncertainty(0.1 * np.cos(9.0 * X), columns, NAMES, values=[1, 1, 1], scales=[1, 1, 1])
    assert found.errors[0] == math.inf
    assert not found.errors[1] < 1e-3
    nearly = columns + 1e-5 * np.stack([np.sin(X), 0 * X, 0 * X], axis=1)
    assert (
        estimate_uncertainty(0.1 * np.cos(9.0 * X), nearly, NAMES, values=[1, 1, 1], scales=[1, 1, 1]).errors[0] > 1e2
    )


def test_no_sample_to_spare_and_no_effect_at_all():
    found = estimate_uncertainty([0.1, 0.2], [[1.0, 0.0], [0.0, 1.0]], ["a", "b"], values=[1, 1], scales=[1, 1])
    assert math.isnan(found.errors[0])
    assert found.interval("a") == found.widen_interval("a") == EVERYTHING
    nothing = estimate_uncertainty([0.1] * 5, np.zeros((5, 2)), ["a", "b"], values=[1, 1], scales=[1, 1])
    assert nothing.errors == (math.inf, math.inf)


def test_bad_input_is_refused():
    with pytest.raises(DataError, match="rows"):
        estimate_uncertainty([0.1], [[1.0], [2.0]], ["a"], values=[1], scales=[1])
    with pytest.raises(DataError, match="finite"):
        estimate_uncertainty([math.nan, 1.0], [[1.0], [2.0]], ["a"], values=[1], scales=[1])
    with pytest.raises(UnknownNameError, match="`a`"):
        judged().interval("A")


# ---------------------------------------------------------------- autocorrelation


def test_autocorrelation_is_the_sum_over_products():
    r = np.random.default_rng(0).normal(size=37)
    found = compute_autocorrelation(r)
    expected = [float(r[: 37 - k] @ r[k:] / (r @ r)) for k in range(37)]
    assert found == pytest.approx(expected, abs=1e-13)
    parts = compute_autocorrelation(r, [20, 17])
    across = float(r[:19] @ r[1:20] + r[20:36] @ r[21:37]) / float(r @ r)
    assert parts[1] == pytest.approx(across)
    assert len(parts) == 20
    assert compute_autocorrelation([0.0, 0.0]).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9])
def test_effective_samples_of_a_long_series_with_memory(phi: float):
    """AR(1): n (1 - φ)/(1 + φ)."""
    n = 200_000
    found = count_effective_samples(remembering(n, phi, seed=4)) / n
    assert found == pytest.approx((1.0 - phi) / (1.0 + phi), rel=0.15)


def test_effective_samples_in_their_limits():
    alternating = np.tile([1.0, -1.0], 50)
    assert count_effective_samples(alternating) == 100.0
    assert count_effective_samples(np.ones(100)) < 2.0
    assert count_effective_samples(np.zeros(10)) == 10.0
    assert count_effective_samples([0.3]) == 1.0
    tiny, huge = (count_effective_samples(f * remembering(500, 0.8)) for f in (1e-200, 1e200))
    assert tiny == pytest.approx(huge)


def test_lengths_must_add_up():
    for lengths in ([3], [5, 0], []):
        with pytest.raises(DataError, match="records"):
            compute_autocorrelation(np.ones(5), lengths)


def remembering(n: int, phi: float, seed: int = 0) -> np.ndarray:
    """AR(1) noise of unit variance."""
    steps = np.random.default_rng(seed).normal(size=n) * math.sqrt(1.0 - phi * phi)
    steps[0] /= math.sqrt(1.0 - phi * phi)
    for t in range(1, n):
        steps[t] += phi * steps[t - 1]
    return steps


# ---------------------------------------------------------------- whiteness


def test_the_statistic_of_ljung_and_box_by_its_formula():
    r = np.random.default_rng(5).normal(size=60)
    found = assess_whiteness(r, "bench")
    rho = np.asarray(found.autocorrelation)
    assert len(rho) == 12
    q = 60 * 62 * sum(rho[k - 1] ** 2 / (60 - k) for k in range(1, 13))
    assert found.statistic == pytest.approx(q)
    assert found.p_value == pytest.approx(stats.chi2(12).sf(q))
    assert found.band == pytest.approx(1.959964 / math.sqrt(60), rel=1e-6)


def test_noise_with_memory_is_not_white_and_its_memory_is_told():
    found = assess_whiteness(remembering(2000, 0.6), "bench")
    assert not found.white
    assert found.p_value < 1e-100
    assert found.autocorrelation[:2] == pytest.approx((0.6, 0.36), abs=0.06)
    assert "`bench`: residuals are not white (Ljung–Box p < 0.0001" in found.sentence
    assert f"until lag {found.memory}" in found.sentence
    assert 4 <= (found.memory or 0) <= 15


def test_an_error_that_is_everywhere_alike_is_not_white():
    found = assess_whiteness(np.random.default_rng(6).normal(1.0, 1.0, 500), "bench")
    assert not found.white
    assert found.memory is None
    assert "past lag 20" in found.sentence


def test_white_noise_is_called_white():
    found = assess_whiteness(np.random.default_rng(7).normal(size=500), "bench")
    assert found.white
    assert found.sentence.endswith("nothing is left to explain.")
    assert assess_whiteness(np.zeros(20)).white


def test_whiteness_refuses_short_records_and_odd_lags():
    with pytest.raises(DataError, match="at least 10"):
        assess_whiteness(np.ones(9))
    for lags, level in ((0, 0.95), (20, 0.95), (None, 1.0)):
        with pytest.raises(ParameterError):
            assess_whiteness(np.ones(20), lags=lags, level=level)
