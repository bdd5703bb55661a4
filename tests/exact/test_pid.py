"""PID control: the difference equation, limits, anti-windup, and the same kernel everywhere.

Sources of truth: the z-transform of the controller written as a difference equation, and rules
applied by hand.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builders import ZERO, hanging_wire
from scipy.signal import lfilter

from martensite.base.errors import InputError, ParameterError
from martensite.control.controllers.pid import Gains, Pid, PidLaw, PidMemory, compute_gains_per_sample
from martensite.control.tuning.measures import build_steps, measure_steps
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.signals.constant import Constant
from martensite.signals.step import Step
from martensite.simulate.controlled_run import simulate_controlled

WIDE: dict[str, Any] = {"low": -1e9, "high": 1e9}
GAINS = Gains(1.7, 0.05, 3.0)
DT = 0.1
"""Interval [s] of gains per sample."""


def played(law: PidLaw, gains: Gains, reference: np.ndarray, measured: np.ndarray) -> np.ndarray:
    memory = law.rest(floats, reference[0], measured[0])
    found = []
    for r, y in zip(reference.tolist(), measured.tolist(), strict=True):
        signal, memory = law.answer(floats, gains, memory, r, y, DT, sampled=True)
        found.append(signal)
    return np.array(found)


def walks() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    reference, measured = rng.standard_normal((2, 300)).cumsum(axis=1)
    reference[0] = measured[0] = 0.0
    return reference, measured


# ---------------------------------------------------------------- the law


def test_it_is_the_difference_equation() -> None:
    """(1 - z⁻¹) u = (K_p (1 - z⁻¹) + K_i + K_d (1 - z⁻¹)²) e, from an error of 0."""
    reference, measured = walks()
    Kp, Ki, Kd = GAINS
    b = [Kp + Ki + Kd, -Kp - 2.0 * Kd, Kd]
    expected = lfilter(b, [1.0, -1.0], reference - measured)
    found = played(PidLaw(**WIDE), GAINS, reference, measured)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10)


def test_a_filtered_derivative_is_a_first_order_lag_of_it() -> None:
    reference, measured = walks()
    lag = 4.0
    expected = lfilter([1.0 / (1 + lag), -1.0 / (1 + lag)], [1.0, -lag / (1 + lag)], reference - measured)
    found = played(PidLaw(filter=lag * DT, **WIDE), Gains(0.0, 0.0, 1.0), reference, measured)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)


def test_weights_act_on_the_reference_alone() -> None:
    reference, measured = walks()
    law = PidLaw(weight=0.3, slope_weight=0.0, **WIDE)
    found = played(law, Gains(2.0, 0.0, 5.0), reference, measured)
    expected = 2.0 * (0.3 * reference - measured) - 5.0 * np.diff(measured, prepend=0.0)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_switching_on_gives_no_kick() -> None:
    law = PidLaw(**WIDE)
    signal, _ = law.answer(floats, Gains(0.0, 0.0, 100.0), law.rest(floats, 5.0, 1.0), 5.0, 1.0, 0.0)
    assert signal == 0.0


def test_signals_stay_within_their_limits() -> None:
    reference, measured = walks()
    found = played(PidLaw(low=-2.0, high=3.0), GAINS, reference, measured)
    assert found.min() == -2.0
    assert found.max() == 3.0


@pytest.mark.parametrize(
    ("error", "integral", "expected"),
    [
        (1.0, 0.95, 0.95),  # beyond the upper limit and driven further: it stays
        (-1.0, 1.5, 1.4),  # driven back: it moves
        (-1.0, -0.95, -0.95),  # the same below
        (1.0, -1.5, -1.4),
        (1.0, 0.3, 0.4),  # within the limits
    ],
)
def test_the_integral_moves_unless_it_would_wind_up(error: float, integral: float, expected: float) -> None:
    law = PidLaw(low=-1.0, high=1.0)
    _, memory = law.answer(floats, Gains(0.0, 0.1, 0.0), PidMemory(integral, 0.0, 0.0), error, 0.0, 1.0)
    assert memory.integral == pytest.approx(expected)


def test_negative_gains_do_not_wind_up_either() -> None:
    law = PidLaw(low=0.0, high=1.0)
    _, memory = law.answer(floats, Gains(-1.0, -0.1, 0.0), PidMemory(0.5, 0.0, 0.0), -2.0, 0.0, 1.0)
    assert memory.integral == 0.5


def test_without_windup_it_leaves_the_limit_at_once() -> None:
    """1000 samples at the limit; one after the error has changed sign the signal falls."""
    error = np.concatenate([np.full(1000, 5.0), np.full(3, -0.5)])
    found = played(PidLaw(high=1.0), Gains(0.1, 0.01, 0.0), error, np.zeros_like(error))
    assert found[999] == 1.0
    assert found[1000] < 0.96


def test_back_calculation_takes_a_share_of_what_is_beyond_the_limits() -> None:
    """Held beyond a limit, I settles where it loses what it gains: u_H - K_p e + (N_t - 1) K_i e, T_t = N_t h.

    From there the sample that follows is that of an integral of this height.
    """
    law = PidLaw(low=-10.0, high=1.0, anti_windup="back-calculation", tracking=4.0 * DT)
    error = np.array([1.0] * 80 + [-0.5])
    found = played(law, Gains(2.0, 0.5, 0.0), error, np.zeros_like(error))
    assert found[:80].tolist() == [1.0] * 80
    settled = 1.0 - 2.0 + (4.0 - 1.0) * 0.5
    assert found[80] == pytest.approx(-0.5 * 2.0 + settled - 0.5 * 0.5, rel=1e-8)


def test_back_calculation_in_one_sample_keeps_the_signal_at_its_limit() -> None:
    """T_t = h: I is what makes the signal just reach the limit."""
    law = PidLaw(high=1.0, anti_windup="back-calculation", tracking=DT)
    _, memory = law.answer(floats, Gains(2.0, 0.5, 0.0), PidMemory(3.0, 0.0, 0.0), 1.0, 0.0, DT)
    assert memory.integral == pytest.approx(1.0 - 2.0)


def test_within_the_limits_both_ways_are_one() -> None:
    reference, measured = walks()
    found = [
        played(PidLaw(anti_windup=way, **WIDE), GAINS, reference, measured)
        for way in ("conditional", "back-calculation")
    ]
    np.testing.assert_array_equal(found[0], found[1])


def test_gains_per_sample() -> None:
    assert compute_gains_per_sample(2.0, 3.0, 4.0, 0.5) == Gains(2.0, 1.5, 8.0)


def test_limits_must_leave_room() -> None:
    with pytest.raises(ParameterError, match="must be below"):
        PidLaw(low=1.0, high=1.0)


# ---------------------------------------------------------------- as a drive


def test_a_drive_answers_as_the_law_does() -> None:
    reference, measured = walks()
    law = PidLaw(low=-5.0, high=5.0)
    gains: dict[str, Any] = GAINS._asdict() | {"gains_are": "per-sample"}
    drive = Pid(measured="y", reference=Constant(level=1.0), law=law, **gains)
    memory, found = drive.init(), []
    for k, y in enumerate(measured.tolist()):
        signal, memory = drive(0.1 * k, {"y": y}, memory)
        found.append(signal)
    np.testing.assert_array_equal(found, played(drive.law, GAINS, np.ones_like(reference), measured))


FILTERED: dict[str, Any] = {"Kp": 3.0, "Ki": 5.0, "Kd": 0.4, "law": PidLaw(slope_weight=0.0, weight=0.6, N=2.0, **WIDE)}
LAG = 0.4 / 3.0 / 2.0
"""T_f = T_d/N [s]."""


def test_without_windup_a_step_back_is_at_once() -> None:
    """Limited to 0.6 the plant cannot reach 1: an integral that went on would hold the limit long after."""
    times, left = 0.02 * np.arange(401), []
    for law in ({}, {"anti_windup": "back-calculation"}, {"anti_windup": "back-calculation", "tracking": 1e9}):
        limits: Any = {"high": 0.6, "N": 2.0} | law
        numbers = FILTERED | {"law": PidLaw(**limits)}
        drive = Pid(measured="y", reference=Step(low=1.0, high=0.3, at=3.999), **numbers)
        y, memory, signals = 0.0, drive.init(), []
        for time in times.tolist():
            signal, memory = drive(time, {"y": y}, memory)
            signals.append(signal)
            y += (1.0 - math.exp(-0.02 / 0.5)) * (signal - y)
        left.append(times[np.flatnonzero(np.array(signals) >= 0.6)[-1]] - 4.0)
    assert max(left[:2]) < 0.0, "it leaves the limit with the reference"
    assert left[2] > 1.0, "which an integral that goes on does not"


@pytest.mark.parametrize(("interval", "lag"), [(0.1, 0.1), (0.001, LAG)])
def test_a_derivative_is_never_without_a_filter(interval: float, lag: float) -> None:
    """A step gives K_d/(T_f + h): T_f = T_d/N, and no less than a sample; Kd/h grew with every shorter sample."""
    drive = Pid(measured="y", reference=Constant(level=0.0), **FILTERED | {"Ki": 0.0})
    _, memory = drive(0.0, {"y": 0.0}, drive.init())
    signal, _ = drive(interval, {"y": -1.0}, memory)
    assert signal == pytest.approx(3.0 + 0.4 / (lag + interval))


@pytest.mark.parametrize("interval", [0.02, 0.5])
def test_gains_in_seconds_are_those_per_sample(interval: float) -> None:
    """From an error of 0: a first sample has no time behind it to integrate."""
    _, measured = walks()
    rest = {"measured": "y", "reference": Constant(level=0.0), "law": PidLaw(low=-5.0, high=5.0, filter=2.0 * interval)}
    per_second = Pid(Kp=1.7, Ki=0.4, Kd=0.3, **rest)
    Kp, Ki, Kd = compute_gains_per_sample(1.7, 0.4, 0.3, interval)
    counted = Pid(Kp=Kp, Ki=Ki, Kd=Kd, gains_are="per-sample", **rest)
    signals = []
    for drive in (per_second, counted):
        memory, found = drive.init(), []
        for k, y in enumerate(measured.tolist()):
            signal, memory = drive(k * interval, {"y": y}, memory)
            found.append(signal)
        signals.append(found)
    np.testing.assert_allclose(signals[0], signals[1], rtol=0.0, atol=1e-10)
    assert np.ptp(signals[0]) > 1.0


def test_an_output_that_is_not_there_is_named() -> None:
    drive = Pid(measured="temperatur", reference=Constant(level=1.0), Kp=1.0)
    with pytest.raises(ParameterError, match="temperature"):
        drive(0.0, {"temperature": 0.0}, None)


def test_it_holds_a_wire_at_a_temperature() -> None:
    """No steady error, and the power that the wire loses there."""
    system = hanging_wire(source=PowerSource())
    level = 40.0 + ZERO
    start = system.environment.temperature
    drive = Pid(
        measured="temperature", reference=Step(low=start, high=level, at=0.5), Kp=0.5, Ki=0.25, law=PidLaw(high=20.0)
    )
    result = simulate_controlled(system, {"drive": drive}, 20.0, 0.02)
    assert result["temperature"][-1] == pytest.approx(level, abs=0.01)
    wire: Any = system.element
    surroundings: Any = system.environment
    lost = surroundings.cooling.h * wire.surface() * (level - surroundings.temperature)
    assert result["drive"][-1] == pytest.approx(lost, rel=1e-3)


# ---------------------------------------------------------------- step responses


def test_a_first_order_response_has_its_known_times() -> None:
    interval, tau = 1e-3, 0.5
    reference = build_steps([(1.0, 1.0), (3.0, 5.0), (2.0, 5.0)], interval)
    times = interval * np.arange(5000)
    output = np.concatenate([np.ones(1000), 3.0 - 2.0 * np.exp(-times / tau), 2.0 + np.exp(-times / tau)])
    up, down = measure_steps(reference, output, interval)
    for found, size in ((up, 2.0), (down, -1.0)):
        assert found.after - found.before == size
        assert found.rise == pytest.approx(tau * math.log(10.0), abs=2 * interval)
        assert found.settling == pytest.approx(tau * math.log(20.0), abs=2 * interval)
        assert found.overshoot == 0.0
        assert found.error == pytest.approx(0.0, abs=2.0 * math.exp(-9.0))


def test_overshoot_error_and_what_never_happens() -> None:
    reference = build_steps([(0.0, 1.0), (2.0, 1.0)], 0.1)
    output = np.concatenate([np.zeros(10), [0.0, 2.4, 2.2, *[2.2] * 7]])
    (found,) = measure_steps(reference, output, 0.1)
    assert found.overshoot == pytest.approx(0.2)
    assert found.error == pytest.approx(-0.2)
    assert found.rise == pytest.approx(0.1)
    assert found.settling == math.inf
    (never,) = measure_steps(reference, 0.5 * reference, 0.1)
    assert never.rise == never.settling == math.inf


def test_a_level_shorter_than_a_sample_is_refused() -> None:
    with pytest.raises(InputError, match="at least"):
        build_steps([(0.0, 0.01)], 0.1)
