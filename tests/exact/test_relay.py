"""Relay autotuning.

Sources of truth: the exact limit cycle of a lag with dead time under a relay, and its exact gain
and frequency at the limit of stability.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tuning_cases import DELAY, DT, linear_bench

from martensite.base.errors import DataError, ParameterError
from martensite.control.rules.relay import RELAY_CITES, RELAY_RULES, LimitCycle, gains_by_relay, run_relay_test
from martensite.scenario.citations import read_bibliography

LATE = (DELAY - 1.0) * DT
SWING = 0.25


def cycle(gain: float = 2.0, bias: float = 0.4, hysteresis: float = 0.0) -> LimitCycle:
    """Around the output that a bias of 0.4 holds, or off its middle."""
    level = 0.5 + 0.4 * gain
    return run_relay_test(linear_bench(gain), level, bias, SWING, hysteresis, reverse=gain < 0.0, duration=12.0)


def test_the_cycle_is_the_exact_one(c_compiler: str) -> None:
    """a = K d (1 - e^(-L/T)), P = 2 T ln(2 e^(L/T) - 1); a sample is lost at each switching."""
    found = cycle()
    early, late = (
        (2.0 * SWING * -math.expm1(-L), 2.0 * math.log(2.0 * math.exp(L) - 1.0)) for L in (LATE, LATE + 2.0 * DT)
    )
    assert early[0] < found.amplitude < late[0]
    assert early[1] < found.period < late[1]
    assert found.on == pytest.approx(found.off, abs=DT)
    assert found.phase == pytest.approx(-math.pi)
    assert found.steady


@pytest.mark.parametrize("gain", [2.0, -2.0])
def test_the_ultimate_gain_is_near_the_exact_one(gain: float, c_compiler: str) -> None:
    """The describing function is within a fifth for a lag with dead time."""
    found, late = cycle(gain), LATE + 0.75 * DT
    w: Any = brentq(lambda w: w * late + math.atan(w) - math.pi, 0.1, 0.999 * math.pi / late)
    exact = math.sqrt(1.0 + w**2) / gain
    assert found.gain == pytest.approx(exact, rel=0.2)
    assert found.period == pytest.approx(2.0 * math.pi / w, rel=0.2)


def test_hysteresis_widens_the_cycle_and_shifts_its_phase(c_compiler: str) -> None:
    found, bare = cycle(hysteresis=0.1), cycle()
    assert found.amplitude > bare.amplitude + 0.05
    assert found.period > bare.period
    assert found.phase == pytest.approx(-math.pi + math.asin(0.1 / found.amplitude))
    expected = 4.0 * SWING / (math.pi * math.sqrt(found.amplitude**2 - 0.01))
    assert found.gain == pytest.approx(expected)


def test_a_bias_beside_the_middle_shows_as_asymmetry(c_compiler: str) -> None:
    """The mean signal is about what holds the level, whatever the bias."""
    found = cycle(bias=0.5)
    assert found.asymmetry > 1.5
    assert found.mean == pytest.approx(0.4, abs=0.03)
    assert cycle().asymmetry < 1.2


@pytest.mark.parametrize("rule", RELAY_RULES)
def test_rules_scale_with_the_cycle(rule: str) -> None:
    one = LimitCycle(3.0, 2.0, 1.0, 1.0, 1.0, 0.5, -3.0, 0.0, *(np.zeros(0),) * 3)
    other = one._replace(gain=-6.0, period=1.0)
    a, b = (gains_by_relay(which, rule, "pid") for which in (one, other))
    assert b.Kp == pytest.approx(-2.0 * a.Kp)
    assert (b.Ti, b.Td) == pytest.approx((0.5 * a.Ti, 0.5 * a.Td))
    assert set(RELAY_CITES[rule]) <= set(read_bibliography())


def test_ziegler_nichols_halves_the_ultimate_gain() -> None:
    one = LimitCycle(3.0, 2.0, 1.0, 1.0, 1.0, 0.5, -3.0, 0.0, *(np.zeros(0),) * 3)
    assert gains_by_relay(one, "ziegler-nichols", "pid") == pytest.approx((1.8, 1.0, 0.25))
    assert gains_by_relay(one, "ziegler-nichols", "pi") == pytest.approx((1.35, 2.0 / 1.2, 0.0))


@pytest.mark.parametrize(
    ("rule", "form", "said"),
    [
        ("tyreus", "pi", "There is no relay rule"),
        ("no-overshoot", "pi", "for pid only"),
        ("tyreus-luyben", "p", "`pi` or `pid`"),
    ],
)
def test_what_no_relay_rule_is_for(rule: str, form: str, said: str) -> None:
    one = LimitCycle(3.0, 2.0, 1.0, 1.0, 1.0, 0.5, -3.0, 0.0, *(np.zeros(0),) * 3)
    with pytest.raises(ParameterError, match=said):
        gains_by_relay(one, rule, form)


def test_a_relay_that_never_switches_is_reported(c_compiler: str) -> None:
    with pytest.raises(DataError, match="no limit cycle"):
        run_relay_test(linear_bench(), 5.0, 0.4, SWING, 0.0, duration=2.0)


def test_no_relay() -> None:
    with pytest.raises(ParameterError, match="amplitude above 0"):
        run_relay_test(linear_bench(), 1.0, 0.4, 0.0, 0.0)
