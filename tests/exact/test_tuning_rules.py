"""Tuning rules, and the models of a step test that they are given.

Sources of truth: margins that the source of SIMC states, the limits of rules for integrating
plants, the product form of a series controller, and plants whose model is known exactly.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from tuning_cases import DELAY, DT, linear_bench

from martensite.base.errors import DataError, ParameterError
from martensite.control.rules.formulas import (
    FORMS,
    RULES,
    FirstOrder,
    IdealGains,
    Integrating,
    convert_series,
    gains_by_rule,
)
from martensite.control.rules.step_test import find_holding_signals, fit_first_order, run_step_test
from martensite.scenario.citations import read_bibliography

LAG = FirstOrder(2.0, 5.0, 1.0)


def loop(model: FirstOrder, gains: IdealGains, w: float) -> complex:
    """C(jw) G(jw)."""
    s = 1j * w
    ahead = gains.Kp * (1.0 + 1.0 / (gains.Ti * s) + gains.Td * s)
    lag = 1.0 + model.time_constant * s
    return ahead * model.gain * np.exp(-model.dead_time * s) / lag


def sensitivity(model: FirstOrder, gains: IdealGains) -> float:
    """Largest |1/(1 + C G)|."""
    frequencies = np.geomspace(1e-3, 1e2, 20_000) / model.dead_time
    return max(float(abs(1.0 / (1.0 + loop(model, gains, w)))) for w in frequencies[::10])


# ---------------------------------------------------------------- rules


@pytest.mark.parametrize("period", [0.0, 0.4])
def test_simc_has_the_margins_that_its_source_states(period: float) -> None:
    """Gain margin 3.14, phase margin 61.4°, sensitivity 1.59 for tau_c = dead time, T_i = T."""
    model = LAG._replace(time_constant=2.0)
    gains = gains_by_rule(model, "simc", "pi", period=period)
    whole = model._replace(dead_time=model.dead_time + 0.5 * period)
    w = 0.5 / whole.dead_time
    assert abs(loop(whole, gains, w)) == pytest.approx(1.0, rel=1e-12)
    margin = 180.0 + math.degrees(np.angle(loop(whole, gains, w)))
    assert margin == pytest.approx(61.4, abs=0.1)
    w = 0.5 * math.pi / whole.dead_time
    assert 1.0 / abs(loop(whole, gains, w)) == pytest.approx(3.14, abs=0.005)
    assert sensitivity(whole, gains) == pytest.approx(1.59, abs=0.005)


@pytest.mark.parametrize("lag", [2.0, 5.0, 20.0])
@pytest.mark.parametrize("form", FORMS)
def test_amigo_is_robust(lag: float, form: str) -> None:
    """Made for a largest sensitivity of about 1.4 over many plants."""
    model = LAG._replace(time_constant=lag)
    assert 1.15 < sensitivity(model, gains_by_rule(model, "amigo", form)) < 1.62


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", [name for name, rule in RULES.items() if rule.integrating])
def test_a_rule_for_integrating_plants_is_its_limit(name: str, form: str) -> None:
    slow = FirstOrder(0.5e6, 1e6, 1.5)
    limit = gains_by_rule(Integrating(0.5, 1.5), name, form)
    np.testing.assert_allclose(gains_by_rule(slow, name, form), limit, rtol=1e-4)


def test_lambda_is_simc_where_both_cancel_the_lag() -> None:
    model = LAG._replace(time_constant=3.0)
    ours = gains_by_rule(model, "lambda", "pi", aim=1.0)
    assert ours == pytest.approx(gains_by_rule(model, "simc", "pi", aim=1.0), rel=1e-12)


def test_cohen_coon_is_ziegler_nichols_without_dead_time() -> None:
    model = FirstOrder(1.0, 1e7, 1.0)
    ours = gains_by_rule(model, "cohen-coon", "pi")
    np.testing.assert_allclose(ours, gains_by_rule(model, "ziegler-nichols", "pi"), rtol=1e-6)


def test_a_series_controller_is_its_product() -> None:
    gains, s = convert_series(2.0, 3.0, 0.5), 0.3 + 0.7j
    product = 2.0 * (1.0 + 1.0 / (3.0 * s)) * (1.0 + 0.5 * s)
    assert gains.Kp * (1.0 + 1.0 / (gains.Ti * s) + gains.Td * s) == pytest.approx(product)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", RULES)
def test_gains_have_the_sign_of_the_plant_and_scale_with_it(name: str, form: str) -> None:
    one, other = (gains_by_rule(LAG._replace(gain=k), name, form) for k in (2.0, -4.0))
    assert one.Kp > 0.0
    assert other == pytest.approx(one._replace(Kp=-0.5 * one.Kp))
    assert set(RULES[name].cites) <= set(read_bibliography())


def test_gains_per_sample() -> None:
    """K_i is what is added in a sample, K_d what counts of a change in a sample."""
    assert IdealGains(3.0, 2.0, 0.5).per_second() == (3.0, 1.5, 1.5)
    assert IdealGains(3.0, 2.0, 0.5).per_sample(0.1) == pytest.approx((3.0, 0.15, 15.0))


@pytest.mark.parametrize(
    ("model", "rule", "form", "aim", "said"),
    [
        (LAG, "sinc", "pi", None, "Did you mean `simc`"),
        (LAG, "simc", "pd", None, "not `pd`"),
        (LAG, "amigo", "pi", 1.0, "is for `simc` and `lambda`"),
        (LAG._replace(dead_time=0.0), "simc", "pi", None, "half of which counts as dead time"),
        (LAG._replace(gain=0.0), "simc", "pi", None, "needs a plant with a gain"),
        (Integrating(1.0, 1.0), "chien-hrones-reswick", "pi", None, "not for an integrating"),
    ],
)
def test_what_no_rule_is_for(
    model: FirstOrder | Integrating, rule: str, form: str, aim: float | None, said: str
) -> None:
    with pytest.raises(ParameterError, match=said):
        gains_by_rule(model, rule, form, aim=aim)


# ---------------------------------------------------------------- fits


def response(model: FirstOrder, step: float, period: float, count: int = 400) -> np.ndarray:
    """Samples of a step response, five of them before the step."""
    t = period * np.arange(-5, count) - model.dead_time
    return 0.3 + model.gain * step * -np.expm1(-np.maximum(t, 0.0) / model.time_constant)


@pytest.mark.parametrize("step", [0.5, -0.2])
@pytest.mark.parametrize("gain", [2.0, -3.0])
def test_a_fit_finds_what_made_the_response(gain: float, step: float) -> None:
    model = FirstOrder(gain, 2.0, 0.43)
    found = fit_first_order(response(model, step, 0.05), 5, 0.05, step)
    np.testing.assert_allclose(found.first_order, model, rtol=1e-4)
    assert found.fit > 99.99


def test_a_fit_stands_noise() -> None:
    model = FirstOrder(2.0, 2.0, 0.5)
    noise = np.random.default_rng(0).normal(0.0, 0.02, 405)
    found = fit_first_order(response(model, 1.0, 0.05) + noise, 5, 0.05, 1.0)
    np.testing.assert_allclose(found.first_order, model, rtol=0.1)
    assert 80.0 < found.fit < 99.9


def test_the_integrating_model_is_the_line_of_an_integrator() -> None:
    t = 0.1 * np.arange(-5, 100) - 0.7
    found = fit_first_order(1.0 + 0.4 * 0.5 * np.maximum(t, 0.0), 5, 0.1, 0.5)
    np.testing.assert_allclose(found.integrating, (0.4, 0.7), rtol=1e-9)


def test_what_does_not_answer() -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.02, 100)
    with pytest.raises(DataError, match="take another bias"):
        fit_first_order(noise, 5, 0.05, 1.0)


# ---------------------------------------------------------------- on a bench


def test_a_step_test_finds_a_linear_plant(c_compiler: str) -> None:
    """Heating and cooling are the same; an input counts from the next sample on."""
    found = run_step_test(linear_bench(), 0.2, 0.3, hold=8.0)
    late = (DELAY - 1.0) * DT
    for one in (found.heating, found.cooling):
        assert one.first_order.gain == pytest.approx(2.0, rel=1e-3)
        assert one.first_order.time_constant == pytest.approx(1.0, rel=2e-3)
        assert one.first_order.dead_time == pytest.approx(late, abs=2e-3)
    np.testing.assert_allclose(found.model(), found.model("heating"), rtol=1e-3)
    assert found.reading[0] == pytest.approx(0.9)


def test_what_holds_a_level(c_compiler: str) -> None:
    found = find_holding_signals(linear_bench(), 1.1, 0.0, 1.0, hold=10.0)
    np.testing.assert_allclose(found, (0.3, 0.3), atol=1e-4)
    assert found.width < 1e-4


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda b: run_step_test(b, 0.0, 0.0), "needs a step"),
        (lambda b: run_step_test(b, 0.0, 1.0, hold=0.1), "ten periods"),
        (lambda b: run_step_test(b, 0.0, 1.0, drive="heater"), "No loop `heater`"),
        (lambda b: find_holding_signals(b, 9.0, 0.0, 1.0, hold=5.0), "No signal from 0 to 1 holds"),
    ],
)
def test_what_is_no_test(call, said: str, c_compiler: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError, match=said):
        call(linear_bench())
