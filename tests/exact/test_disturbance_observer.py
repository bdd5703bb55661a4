"""A disturbance observer: what its equations say of the plant that it has as a model, and of others.

Sources of truth: the sampled plant y(k+1) = α y(k) + K (1 - α) (u(k-m) + d(k)) written out, on which the estimate is
the disturbance behind the filter, and the final value of a loop without an integral.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.control.controllers.disturbance_observer import DisturbanceObserver
from martensite.control.controllers.pid import PidLaw
from martensite.kernels import floats
from martensite.signals.constant import Constant

DT, K, T, TAU, LATE = 0.1, 0.5, 2.0, 0.4, 3
ALPHA = math.exp(-DT / T)
USUAL: dict[str, Any] = {
    "period": DT,
    "model_gain": K,
    "time_constant": T,
    "dead_time": LATE * DT,
    "filter_time": TAU,
    "Kp": 3.0,
    "law": PidLaw(low=-50.0, high=50.0),
}


def make(**given: Any) -> DisturbanceObserver:
    return DisturbanceObserver(measured="y", reference=Constant(level=0.0), **{**USUAL, **given})


def play(
    one: DisturbanceObserver, disturbance: np.ndarray, wanted: float = 1.0, gain: float = K, origin: float = 20.0
) -> np.ndarray:
    """Readings, signals and estimates under disturbances, one a sample, around an origin."""
    y, memory, past, rows = 0.0, None, [0.0] * (LATE + 1), list[tuple[float, ...]]()
    for k, d in enumerate(disturbance.tolist()):
        reading = {"y": origin + y}
        memory = memory or one.rest(floats, origin + wanted, reading)
        signal, memory = one.answer(floats, memory, origin + wanted, reading, DT if k else 0.0)
        past = [signal, *past[:-1]]
        rows.append((y, signal, *one.observe(floats, memory)))
        y = ALPHA * y + gain * (1.0 - ALPHA) * (past[LATE] + d)
    return np.array(rows).T


def test_the_estimate_is_the_disturbance_behind_its_filter() -> None:
    disturbance = np.random.default_rng(5).normal(size=200).cumsum()
    _, _, found = play(make(), disturbance)
    expected, held = 0.0, math.exp(-DT / TAU)
    for k in range(1, 200):
        expected = held * expected + (1.0 - held) * disturbance[k - 1]
        assert found[k] == pytest.approx(expected, abs=1e-9)


def test_a_constant_disturbance_leaves_no_error() -> None:
    """Without the observer a proportional loop is off by K d/(1 + K Kp)."""
    disturbance = np.where(np.arange(600) < 300, 0.0, -2.0)
    helped, alone = (play(make(filter_time=tau), disturbance)[0] for tau in (TAU, 1e9))
    moved = [y[-1] - y[299] for y in (helped, alone)]
    assert moved[0] == pytest.approx(0.0, abs=1e-6)
    assert moved[1] == pytest.approx(-K * 2.0 / (1.0 + 3.0 * K), rel=1e-4)
    # what an integral would have to work off: exact for the model, 1/0.4 s quick
    assert np.abs(helped[300:] - helped[299]).sum() < 0.25 * np.abs(alone[300:] - alone[299]).sum()


def test_a_plant_of_another_gain_goes_where_the_model_would() -> None:
    none = np.zeros(800)
    model, other = (play(make(), none, gain=gain)[0] for gain in (K, 0.6 * K))
    assert other[-1] == pytest.approx(model[-1], rel=1e-6)
    assert model[-1] == pytest.approx(3.0 * K / (1.0 + 3.0 * K), rel=1e-6)


def test_at_a_limit_nothing_winds_up() -> None:
    """The signal is held at its limit for 20 s; the estimate stays within its range and comes back at once."""
    one = make(law=PidLaw(low=0.0, high=1.0))
    disturbance = np.where(np.arange(600) < 200, -5.0, 0.0)
    _, signal, found = play(one, disturbance)
    assert signal.min() >= 0.0 and signal.max() == 1.0
    assert np.abs(found).max() <= 1.0
    assert abs(found[200 + round(5.0 * TAU / DT)]) < 0.02


def test_a_model_that_does_nothing_is_refused() -> None:
    with pytest.raises(ParameterError, match="must not be 0"):
        make(model_gain=0.0)
