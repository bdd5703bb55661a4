"""Fits of h(T): coefficients, intervals and tests against numpy and scipy, which share no code.

Source of truth: numpy.polyfit's covariance, scipy.stats, scipy.optimize, and the numbers found
for the two papers by separate code.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from scipy import optimize, stats

from martensite.base.confidence import student_quantile, two_sided_probability
from martensite.base.errors import DataError, ParameterError, SolveError
from martensite.characterise import film_ambient
from martensite.characterise.film_ambient import fit_free_ambient
from martensite.characterise.film_coefficient import (
    ABSOLUTE_ZERO,
    FORMS,
    FilmPoints,
    compute_film_points,
    fit_film,
    fit_film_points,
    powers_from_voltage,
)
from martensite.characterise.film_report import judge_film
from martensite.characterise.regression import fit_noisy_abscissae, fit_powers, fit_residuals

MIGAONE = FilmPoints((47.65, 57.5, 72.0, 87.0), (47.83, 53.07, 57.28, 64.55), 38.5)
VOLTS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
KOSSOSKI_AT = (33.0, 39.0, 46.0, 58.0, 73.0, 75.0, 80.0, 93.0, 101.0)


def kossoski(ohms: float = 1.3, ambient: float = 22.0) -> FilmPoints:
    powers = powers_from_voltage(VOLTS, ohms)
    return compute_film_points(KOSSOSKI_AT, powers, diameter=375e-6, length=0.1, ambient_degC=ambient)


# ---------------------------------------------------------------- Student's t


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 5, 8, 17, 40, 401])
def test_student(freedom: int) -> None:
    """The level is split between both tails, and the square of t has the F distribution."""
    for level in (0.5, 0.9, 0.95, 0.999):
        expected = float(stats.t.ppf(0.5 + 0.5 * level, freedom))
        assert student_quantile(level, freedom) == pytest.approx(expected, rel=1e-10)
    for t in (0.0, 0.3, -2.2, 9.0):
        expected = float(2.0 * stats.t.sf(abs(t), freedom))
        assert two_sided_probability(t, freedom) == pytest.approx(expected, abs=1e-14)
    assert two_sided_probability(2.2, freedom) == pytest.approx(
        float(stats.f.sf(2.2**2, 1, freedom)), abs=1e-14
    )  # the F-test of one term


def test_student_by_hand_and_its_limits() -> None:
    assert student_quantile(0.95, 2) == pytest.approx(1.9 / math.sqrt(2.0 * 0.975 * 0.025) / 2.0)
    assert student_quantile(0.5, 1) == pytest.approx(1.0)
    with pytest.raises(ParameterError, match="at least 1"):
        two_sided_probability(1.0, 0)
    with pytest.raises(ParameterError, match="between 0 and 1"):
        student_quantile(1.0, 3)


# ---------------------------------------------------------------- linear least squares


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_intervals_are_those_of_numpy_and_scipy(degree: int) -> None:
    at, h = kossoski().temperatures_degC, kossoski().h
    fit = fit_film(at, h, tuple(range(degree + 1)))
    values, covariance = np.polyfit(at, h, degree, cov=True)
    assert fit.coefficients == pytest.approx(values[::-1], rel=1e-9)
    errors = np.sqrt(np.diag(covariance))[::-1]
    assert [fit.error(k) for k in fit.terms] == pytest.approx(errors, rel=1e-8)
    t = stats.t.ppf(0.975, len(h) - degree - 1)
    for k in fit.terms:
        value, error = fit.coefficients[k], errors[k]
        assert fit.interval(k) == pytest.approx((value - t * error, value + t * error), rel=1e-8)
    assert np.asarray(fit.linear.covariance) == pytest.approx(covariance[::-1, ::-1], rel=1e-7)
    powers = np.asarray([60.0**k for k in fit.terms])
    band = t * np.sqrt(powers @ covariance[::-1, ::-1] @ powers)
    assert fit.half_width(60.0) == pytest.approx(band, rel=1e-7)


def test_a_straight_line_agrees_with_scipys_regression() -> None:
    points = kossoski()
    fit = fit_film(points.temperatures_degC, points.h, FORMS["linear"])
    line = stats.linregress(points.temperatures_degC, points.h)
    assert fit.coefficients == pytest.approx((line.intercept, line.slope))  # type: ignore[attr-defined]
    assert fit.linear.p_value(1) == pytest.approx(line.pvalue)  # type: ignore[attr-defined]
    assert fit.error(0) == pytest.approx(line.intercept_stderr)  # type: ignore[attr-defined]


def test_aicc_by_hand() -> None:
    fit = fit_film(KOSSOSKI_AT, kossoski().h, FORMS["linear"])
    left = sum((h - fit.film(t)) ** 2 for t, h in zip(KOSSOSKI_AT, kossoski().h, strict=True))
    assert fit.aicc == pytest.approx(9 * math.log(left / 9) + 2 * 3 + 2 * 3 * 4 / (9 - 3 - 1))
    assert math.isnan(fit_film(*points_of(MIGAONE), (0, 1)).aicc)


def points_of(points: FilmPoints) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return points.temperatures_degC, points.h


def test_without_a_point_to_spare_nothing_is_bounded() -> None:
    fit = fit_film((40.0, 55.0, 70.0), (40.0, 47.0, 52.0))
    assert fit.interval(2) == (-math.inf, math.inf)
    assert math.isnan(fit.error(2)) and math.isnan(fit.deviation) and math.isnan(fit.adjusted)
    assert math.isnan(fit.linear.p_value(2)) and fit.half_width(50.0) == math.inf
    with pytest.raises(ParameterError, match="not fitted"):
        fit.error(3)


# ---------------------------------------------------------------- the two papers


def test_migaone_numbers() -> None:
    """Least squares of h, as the paper has them."""
    expected = {
        "h1=0": ((41.888, 0.0, 0.0030103), 0.98417, 0.976),
        "quadratic": ((30.729, 0.34525, 4.701e-4), 0.98896, 0.967),
        "linear": ((28.692, 0.40871), 0.98879, 0.983),
    }
    for form, (coefficients, r_squared, adjusted) in expected.items():
        fit = fit_film(*points_of(MIGAONE), FORMS[form])
        assert fit.coefficients == pytest.approx(coefficients, rel=3e-5)
        assert fit.r_squared == pytest.approx(r_squared, abs=6e-6)
        assert fit.adjusted == pytest.approx(adjusted, abs=6e-4)
    constant = fit_film(*points_of(MIGAONE), (0,))
    assert constant.coefficients == pytest.approx((sum(MIGAONE.h) / 4,))
    assert constant.r_squared == pytest.approx(0.0, abs=1e-12)


def fit_temperatures(points: FilmPoints, terms: tuple[int, ...], start: list[float]) -> Any:
    """scipy makes the squares of temperatures least, each found by bisection from its flux; the ambient may be free."""

    def residuals(numbers: np.ndarray) -> list[float]:
        ambient = numbers[-1] if len(numbers) > len(terms) else points.ambient
        found = []
        for at, flux in zip(points.temperatures_degC, points.fluxes, strict=True):

            def excess(t: float, flux: float = flux) -> float:
                return sum(c * t**k for k, c in zip(terms, numbers, strict=False)) * (t - ambient) - flux

            root: Any = optimize.brentq(excess, ambient, 400.0, xtol=1e-13)
            found.append(at - root)
        return found

    return optimize.least_squares(residuals, start, x_scale=np.abs(start), xtol=1e-14, ftol=1e-14, gtol=1e-14)


@pytest.mark.parametrize("form", ["constant", "linear", "h1=0"])
def test_a_fit_of_temperatures_is_that_of_scipy(form: str) -> None:
    for points in (MIGAONE, kossoski()):
        start = fit_film(*points_of(points), FORMS[form])
        fit = fit_film_points(points, FORMS[form])
        found = fit_temperatures(points, FORMS[form], [start.coefficients[k] for k in FORMS[form]])
        assert [fit.coefficients[k] for k in FORMS[form]] == pytest.approx(found.x, rel=1e-5)
        assert fit.linear.squares == pytest.approx(2.0 * found.cost, rel=1e-7)
        spread = np.linalg.inv(found.jac.T @ found.jac) * 2.0 * found.cost / fit.linear.freedom
        assert [fit.error(k) for k in FORMS[form]] == pytest.approx(np.sqrt(np.diag(spread)), rel=1e-3)
        constant = fit_film_points(points, FORMS["constant"])
        assert fit.r_squared == pytest.approx(1.0 - fit.linear.squares / constant.linear.squares)


@pytest.mark.parametrize(("ohms", "ambient"), [(1.3, 17.0), (3.8, 22.0), (13.0, 27.0)])
def test_kossoski_identifies_neither_whatever_is_assumed(ohms: float, ambient: float) -> None:
    report = judge_film(kossoski(ohms, ambient))
    assert [verdict.supported for verdict in report.verdicts] == [False] * 3
    assert "none fits best" in report["ambient"].sentence


# ---------------------------------------------------------------- the ambient temperature


def test_sensitivity_to_the_ambient_against_differences() -> None:
    for points in (MIGAONE, kossoski()):
        ambient, step = points.ambient, 1e-4
        above, below = points.at_ambient(ambient + step), points.at_ambient(ambient - step)
        expected = [(a - b) / (2 * step) for a, b in zip(above.h, below.h, strict=True)]
        assert film_ambient.film_per_kelvin(points) == pytest.approx(expected, rel=1e-6)
        slopes = [fit_film_points(p, (0, 1)).coefficients[1] for p in (above, below)]
        found = film_ambient.slope_per_kelvin(points)
        assert found == pytest.approx((slopes[0] - slopes[1]) / (2 * step), rel=1e-4)
        level = points.at_ambient(film_ambient.find_level_ambient(points))
        assert fit_film_points(level, (0, 1)).coefficients[1] == pytest.approx(0.0, abs=1e-6)
        assert level.at_ambient(ambient).h == pytest.approx(points.h)


def test_free_ambient_is_the_nonlinear_fit_of_h_and_ambient() -> None:
    """scipy fits θ of q = (h0 + h1 θ)(θ - a) with three parameters; both minima must agree."""
    found = fit_temperatures(MIGAONE, (0, 1), [30.0, 0.4, 38.0])
    fit = fit_free_ambient(MIGAONE, 1)
    assert fit is not None
    assert fit.ambient == pytest.approx(found.x[2], abs=1e-4)
    assert fit.leading == pytest.approx(found.x[1], rel=1e-3)
    assert fit.flux.squares == pytest.approx(2.0 * found.cost, rel=1e-6)


def test_of_two_parts_of_the_ambient_interval_the_one_about_the_best_is_taken() -> None:
    """q = h1 (θ + 100)(θ - 20) is zero at -100 degC too, which is no ambient."""
    at = np.linspace(30.0, 150.0, 30)
    h = 30.0 + 0.3 * at + np.random.default_rng(2).normal(0.0, 1e-3, 30)
    fit = fit_free_ambient(FilmPoints(tuple(at), tuple(h), 20.0), 1)
    assert fit is not None
    low, high = fit.ambient_interval()
    assert 19.9 < low < fit.ambient < high < 20.1


@pytest.mark.parametrize("degree", [0, 1])
def test_ends_of_the_ambient_interval_have_the_right_f(degree: int) -> None:
    """At an end, holding the ambient there costs t² s², to the accuracy of a linear fit: Fieller's region."""
    at = np.linspace(40.0, 100.0, 12)
    noise = np.random.default_rng(5).normal(0.0, 4.0, 12)
    h = 30.0 + (0.5 * at if degree else 0.0 * at) + noise / (at - 25.0)
    points = FilmPoints(tuple(at), tuple(h), 25.0)
    fit = fit_free_ambient(points, degree)
    assert fit is not None and fit.is_bounded()
    t = stats.t.ppf(0.975, fit.flux.freedom)
    for end in fit.ambient_interval():
        held = fit_noisy_abscissae(points.temperatures_degC, points.fluxes, range(degree + 1), end)
        cost = (held.squares - fit.flux.squares) / fit.flux.deviation**2
        assert cost == pytest.approx(t * t, rel=0.02)
    low, high = fit.ambient_interval()
    assert low < fit.ambient < high
    if degree:
        assert judge_film(points)["ambient"].supported


def test_the_ambient_is_unbounded_where_the_slope_may_be_zero() -> None:
    fit = fit_free_ambient(MIGAONE, 1)
    assert fit is not None
    low, high = fit.leading_interval()
    assert low < 0.0 < high
    assert fit.ambient_interval()[0] == ABSOLUTE_ZERO
    assert not fit.is_bounded()


def test_correlation_and_condition_by_finite_differences() -> None:
    at = np.asarray(MIGAONE.temperatures_degC)
    line = fit_film_points(MIGAONE, (0, 1))

    def flux(level: float, slope: float, ambient: float) -> np.ndarray:
        return (level + slope * (at - at.mean())) * (at - ambient)

    start = np.asarray([line.film(float(at.mean())), line.coefficients[1], 38.5])
    columns = []
    for k in range(3):
        step = np.eye(3)[k] * 1e-5
        columns.append((flux(*(start + step)) - flux(*(start - step))) / 2e-5)
    jacobian = np.stack(columns, axis=1)
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    expected = covariance[1, 2] / np.sqrt(covariance[1, 1] * covariance[2, 2])
    found = film_ambient.find_confounding(MIGAONE)
    assert found.correlation == pytest.approx(expected, rel=1e-5)
    scaled = jacobian / np.linalg.norm(jacobian, axis=0)
    assert found.condition == pytest.approx(np.linalg.cond(scaled), rel=1e-5)


def test_a_clear_case_is_supported() -> None:
    """Enough exact points of a bent film coefficient: every question is answered with yes."""
    at = np.linspace(30.0, 150.0, 30)
    h = 30.0 + 0.3 * at + 2e-3 * at**2 + np.random.default_rng(2).normal(0.0, 1e-3, 30)
    report = judge_film(FilmPoints(tuple(at), tuple(h), 20.0))
    assert all(verdict.supported for verdict in report.verdicts)
    line = 30.0 + 0.3 * at + np.random.default_rng(2).normal(0.0, 1e-3, 30)
    report = judge_film(FilmPoints(tuple(at), tuple(line), 20.0))
    assert report["ambient"].supported and report["slope"].supported
    assert report.ambient is not None
    low, high = report.ambient.free["linear"].ambient_interval()
    assert low < 20.0 < high and high - low < 0.1


# ---------------------------------------------------------------- few points, bad input, JSON


def test_few_points() -> None:
    two = judge_film(FilmPoints((40.0, 60.0), (50.0, 52.0), 20.0))
    assert set(two.fits) == {"constant", "linear", "h1=0"}
    assert not any(verdict.supported for verdict in two.verdicts)
    three = judge_film(FilmPoints((40.0, 60.0, 80.0), (50.0, 52.0, 55.0), 20.0))
    assert "not tested" in three["curvature"].sentence
    assert "not tested" in three["ambient"].sentence
    for report in (two, three):
        text = json.dumps(report.to_dict())
        assert "verdicts" in text


def test_without_an_ambient_nothing_is_supported() -> None:
    report = judge_film(FilmPoints(MIGAONE.temperatures_degC, MIGAONE.h))
    assert report.ambient is None
    assert "supported only if the ambient temperature" in report["slope"].sentence
    assert not report["slope"].supported
    with pytest.raises(DataError, match="not known"):
        _ = report.points.fluxes


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (lambda: FilmPoints((40.0, 50.0), (1.0, 2.0), 45.0), DataError, "below the coldest point"),
        (lambda: FilmPoints((40.0, 50.0), (1.0, 2.0), -300.0), DataError, "below the coldest"),
        (lambda: FilmPoints((40.0, 50.0), (1.0, -2.0)), DataError, "above 0"),
        (lambda: FilmPoints((40.0,), (1.0,)), DataError, "at least 2 points"),
        (lambda: FilmPoints((40.0, 50.0), (1.0, math.nan)), DataError, "finite"),
        (lambda: MIGAONE.at_ambient(47.65), DataError, "below the coldest point"),
        (lambda: powers_from_voltage((1.0, 2.0), (1.0,)), DataError, "one resistance per voltage"),
        (lambda: powers_from_voltage((1.0, 2.0), 0.0), ParameterError, "above 0 ohm"),
        (
            lambda: compute_film_points((40.0, 50.0), (1.0, 2.0), diameter=0.0, length=1.0, ambient_degC=20.0),
            ParameterError,
            "above 0 m",
        ),
        (lambda: fit_powers((1.0, 2.0), (1.0, 2.0), ()), ParameterError, "distinct powers"),
    ],
)
def test_bad_input_is_refused(make, error, sentence: str) -> None:
    with pytest.raises(error, match=sentence):
        make()


def test_points_from_power_by_hand() -> None:
    points = compute_film_points((50.0, 70.0), (0.1, 0.3), diameter=1e-3, length=0.2, ambient_degC=20.0)
    surface = math.pi * 1e-3 * 0.2
    assert points.h == pytest.approx((0.1 / surface / 30.0, 0.3 / surface / 50.0))
    assert points.fluxes == pytest.approx((0.1 / surface, 0.3 / surface))
    assert powers_from_voltage((2.0, 3.0), 4.0) == [1.0, 2.25]


# ---------------------------------------------------------------- nonlinear least squares


def test_a_linear_problem_has_the_errors_of_linear_regression() -> None:
    """Nonlinear least squares of a straight line is the linear fit, standard errors too."""
    x = np.linspace(0.1, 3.0, 15)
    y = 2.0 - 0.7 * x + 0.02 * np.sin(9.0 * x)
    found = fit_residuals(lambda p: p[0] + p[1] * x - y, (1.0, 1.0))
    expected = fit_powers(x.tolist(), y.tolist(), (0, 1))
    assert found.values == pytest.approx(expected.values, rel=1e-9)
    errors = [one.error for one in found.estimates]
    assert errors == pytest.approx([expected.error(k) for k in (0, 1)], rel=1e-8)
    assert found.rms == pytest.approx(math.sqrt(expected.squares / 15))


def test_a_number_that_makes_no_difference_is_refused() -> None:
    with pytest.raises(SolveError, match="one parameter has no effect"):
        fit_residuals(lambda p: [p[0] - 1.0, p[0] + 1.0, p[0]], (0.5, 0.5))
