"""Constants of a DC motor are found again from tests computed in closed form.

Source of truth: the linear equations of motor and winding, solved with eigenvectors, with known
constants, dry friction and noise; the tables of Kossoski (2018) for the doubt about J and R. Over
200 tests the share of 95 % intervals that hold the truth must lie within what a binomial
distribution allows (99.99 %), and intervals of half the width must not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest
from scipy import stats

from martensite.base.confidence import Interval, interval_contains
from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.motor_constants import (
    LONG,
    UNITS,
    MotorConstants,
    SteadyRunning,
    Winding,
    collect_steady_states,
    estimate_motor_constants,
    winding_resistance,
)
from martensite.characterise.time_constant import Rise, fit_rise

R, L, K, B, F_C, J = 6.22, 3.1e-3, 0.0211, 2e-6, 4e-4, 8.68e-5
TRUTH = {"resistance": R, "inductance": L, "constant": K, "friction": B, "dry_friction": F_C, "inertia": J}
REPETITIONS = 200
ALLOWED = stats.binom.interval(0.9999, REPETITIONS, 0.95)
SPEEDS = np.linspace(40.0, 300.0, 8)


def held_rotor(noise: float = 0.0, seed: int = 0, offset: float = 0.0) -> Winding:
    draw = np.random.default_rng([seed, 1])
    currents = np.linspace(0.1, 0.5, 9)
    volts = offset + R * currents + draw.normal(0.0, noise, 9)
    return winding_resistance(volts.tolist(), currents.tolist())


def running(noise: float = 0.0, seed: int = 0) -> SteadyRunning:
    draw = np.random.default_rng([seed, 2])
    currents = (B * SPEEDS + F_C) / K
    volts = R * currents + K * SPEEDS + draw.normal(0.0, 5.0 * noise, 8)
    currents = currents + draw.normal(0.0, 0.1 * noise, 8)
    return collect_steady_states(volts.tolist(), currents.tolist(), SPEEDS.tolist())


def held_current(noise: float = 0.0, seed: int = 0) -> Rise:
    times = np.linspace(0.0, 5.0 * L / R, 200)
    draw = np.random.default_rng([seed, 3]).normal(0.0, noise, 200)
    return fit_rise(times.tolist(), (0.3 * (1.0 - np.exp(-times * R / L)) + draw).tolist())


def speeds_of_a_run_up(times: np.ndarray, coil: float = L, volts: float = 6.0) -> np.ndarray:
    """Speed [rad/s] from the moment at which the current overcomes dry friction."""
    matrix = np.array([[-R / coil, -K / coil], [K / J, -B / J]])
    steady = -np.linalg.solve(matrix, [volts / coil, -F_C / J])
    rates, vectors = np.linalg.eig(matrix)
    parts = np.linalg.solve(vectors, np.array([F_C / K, 0.0]) - steady)
    return np.real(steady[:, None] + vectors @ (parts[:, None] * np.exp(np.outer(rates, times))))[1]


def run_up(noise: float = 0.0, seed: int = 0, *, coil: float = L, start: float = 0.01) -> Rise:
    times = np.linspace(start, 6.0, 600)
    draw = np.random.default_rng([seed, 4]).normal(0.0, noise, 600)
    return fit_rise(times.tolist(), (speeds_of_a_run_up(times, coil) + draw).tolist())


@cache
def made(seed: int) -> MotorConstants:
    """All tests with noise: 10 mV held, 5 mV and 0.1 mA running, 3 mA, 1 rad/s."""
    return estimate_motor_constants(
        running(1e-3, seed), held_rotor(0.01, seed), current_rise=held_current(3e-3, seed), run_up=run_up(1.0, seed)
    )


def held(interval_of: Callable[[MeasuredValue], Interval], name: str) -> int:
    """In how many of the repetitions the interval holds the truth."""
    found = (getattr(made(seed), name) for seed in range(REPETITIONS))
    return sum(interval_contains(interval_of(one), TRUTH[name]) for one in found)


def half_as_wide(found: MeasuredValue) -> Interval:
    low, high = found.interval()
    return found.value - 0.25 * (high - low), found.value + 0.25 * (high - low)


# ---------------------------------------------------------------- the truth again


def test_without_noise_everything_is_exact() -> None:
    found = estimate_motor_constants(running(), held_rotor(), current_rise=held_current(), run_up=run_up(start=0.05))
    assert set(TRUTH) == set(UNITS)
    for name, truth in TRUTH.items():
        assert getattr(found, name).value == pytest.approx(truth, rel=1e-8)
    assert found.run_up_time == pytest.approx(R * J / K**2)
    assert found.remarks == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", TRUTH)
def test_intervals_hold_the_truth(name: str) -> None:
    assert ALLOWED[0] <= held(MeasuredValue.interval, name) <= ALLOWED[1]
    assert held(half_as_wide, name) < ALLOWED[0]


def test_inertia_with_a_slow_winding_needs_the_inductance() -> None:
    """With L/R a tenth of the run-up, J without L is a tenth too small; with L it is exact."""
    coil = 0.12 * R
    late = run_up(coil=coil, start=2.5)
    found = estimate_motor_constants(running(), held_rotor(), inductance=coil, run_up=late).inertia
    assert found is not None
    assert found.value == pytest.approx(J, rel=1e-6)
    without = estimate_motor_constants(running(), held_rotor(), run_up=late).inertia
    assert without is not None
    assert without.value < 0.9 * J


def test_backward_states_are_turned_forward() -> None:
    states = running()
    signs = (1.0, -1.0) * 4
    turned = collect_steady_states(
        *(
            [s * number for s, number in zip(signs, column, strict=True)]
            for column in (states.voltages, states.currents, states.speeds)
        )
    )
    assert turned == states


def test_friction_that_is_dropped_is_missed() -> None:
    """The line of friction does not go through zero: without its intercept b is far off."""
    states = running()
    through_zero = sum(i * w for i, w in zip(states.currents, states.speeds, strict=True)) / sum(
        w * w for w in states.speeds
    )
    assert K * through_zero > 1.5 * B
    found = estimate_motor_constants(states, held_rotor())
    assert found.friction.value == pytest.approx(B, rel=1e-9)
    assert found.dry_friction.value == pytest.approx(F_C, rel=1e-9)


def test_errors_of_the_resistance_are_carried_on() -> None:
    exact = estimate_motor_constants(running(1e-3), Winding(MeasuredValue(R)), run_up=run_up(1.0))
    vague = estimate_motor_constants(running(1e-3), Winding(MeasuredValue(R, 0.3, 9)), run_up=run_up(1.0))
    for name in ("constant", "friction", "dry_friction", "inertia"):
        sure, unsure = getattr(exact, name), getattr(vague, name)
        assert unsure.value == sure.value
        assert unsure.error > 1.2 * sure.error
    assert exact.inertia is not None and vague.inertia is not None
    # J grows as K falls: both by R, in the same direction
    assert vague.inertia.error / vague.inertia.value > 0.3 / R


def test_two_states_leave_the_errors_unknown() -> None:
    states = running(1e-3)
    few = SteadyRunning(states.voltages[:2], states.currents[:2], states.speeds[:2])
    found = estimate_motor_constants(few, held_rotor(0.01))
    assert found.friction.interval() == (-math.inf, math.inf)
    assert sum("is not supported" in remark for remark in found.remarks) == 2
    assert found.to_dict()["inertia"] is None
    assert (found.inductance, found.run_up_time) == (None, None)


# ---------------------------------------------------------------- remarks


def test_doubt_about_published_constants() -> None:
    """R J/K² of Table 3 is more than seven seconds; with R = 6.22 ohm it is one."""
    table = estimate_motor_constants(running(), Winding(MeasuredValue(41.0)), inductance=L, run_up=fit_rise(*rise(7.0)))
    assert any("is long for a small motor" in remark for remark in table.remarks)
    assert 41.0 * 0.82e-4 / 0.0211**2 > 7.0 > LONG > R * 0.82e-4 / 0.0211**2


def rise(tau: float) -> tuple[list[float], list[float]]:
    times = np.linspace(0.0, 4.0 * tau, 100)
    return times.tolist(), (200.0 * (1.0 - np.exp(-times / tau))).tolist()


def test_remarks_on_what_does_not_fit() -> None:
    brushes = estimate_motor_constants(running(), held_rotor(0.01, offset=0.5))
    assert any("V at no current" in remark for remark in brushes.remarks)
    smooth = collect_steady_states((2.0, 4.0, 6.0), (0.02, 0.0199, 0.0201), (90.0, 180.0, 270.0))
    assert any(
        "b above 0 is not supported" in r for r in estimate_motor_constants(smooth, Winding(MeasuredValue(6.0))).remarks
    )
    falling = collect_steady_states((2.0, 4.0, 6.0), (0.03, 0.0199, 0.01), (90.0, 180.0, 270.0))
    assert any("is below 0" in r for r in estimate_motor_constants(falling, Winding(MeasuredValue(6.0))).remarks)
    times = np.linspace(-2.0, 6.0, 800)
    early = fit_rise(times.tolist(), np.where(times > 0, 1 - np.exp(-times / 0.5), 0.0).tolist())
    found = estimate_motor_constants(running(), held_rotor(), run_up=early)
    assert any("speed does not rise as one exponential" in remark for remark in found.remarks)


# ---------------------------------------------------------------- exponentials


def test_rise_does_not_depend_on_where_the_record_begins() -> None:
    times, speeds = rise(1.3)
    whole, late = fit_rise(times, speeds), fit_rise(times[30:], speeds[30:])
    assert whole.tau.value == pytest.approx(1.3, rel=1e-9)
    assert late.tau.value == pytest.approx(1.3, rel=1e-9)
    assert late.change.value < whole.change.value == pytest.approx(200.0)
    assert whole.final.value == pytest.approx(200.0)
    falling = fit_rise(times, [5.0 - speed for speed in speeds])
    assert falling.tau.value == pytest.approx(1.3, rel=1e-9)
    assert falling.change.value == pytest.approx(-200.0)


def test_rise_is_better_than_one_sample() -> None:
    """The time at which a noisy record first passes 63.2 % of its last row, beside the fit."""
    times = np.linspace(0.0, 3.0, 300)
    fits, reads = [], []
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(0.0, 0.03, times.size)
        values = 1.0 - np.exp(-times) + noise
        fits.append(fit_rise(times.tolist(), values.tolist()).tau.value - 1.0)
        reads.append(times[np.argmax(values > (1.0 - math.exp(-1.0)) * values[-1])] - 1.0)
    assert np.sqrt(np.mean(np.square(fits))) < 0.3 * np.sqrt(np.mean(np.square(reads)))


def test_noise_is_told_from_another_curve() -> None:
    times = np.linspace(0.0, 5.0, 400)
    noisy = 1 - np.exp(-times) + np.random.default_rng(1).normal(0.0, 0.05, 400)
    assert fit_rise(times.tolist(), noisy.tolist()).follows
    two = 1 - 0.5 * np.exp(-times) - 0.5 * np.exp(-10.0 * times)
    assert not fit_rise(times.tolist(), two.tolist()).follows


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("times", "values", "sentence"),
    [
        ((0.0, 1.0, 2.0), (0.0, 1.0, 2.0), "at least 6 rows"),
        (range(8), [3.0] * 8, "nothing rises"),
        (range(8), [float(k) for k in range(8)], "fitted time constant"),
        (range(8), range(7), "equal lengths"),
        ([0.0, 1.0, 1.0, 2.0, 3.0, 4.0], range(6), "must increase"),
        (range(6), [0.0, 1.0, math.inf, 1.0, 1.0, 1.0], "finite"),
    ],
)
def test_rises_that_are_refused(times: Sequence[float], values: Sequence[float], sentence: str) -> None:
    with pytest.raises(DataError, match=sentence):
        fit_rise(times, values)


def test_tests_that_are_refused() -> None:
    with pytest.raises(DataError, match="at least 2 states"):
        winding_resistance([1.0], [1.0])
    with pytest.raises(DataError, match="equal lengths"):
        winding_resistance([1.0, 2.0], [1.0])
    with pytest.raises(DataError, match="of the held rotor are 0 A"):
        winding_resistance([1.0, 2.0], [0.0, 0.0])
    with pytest.raises(DataError, match="above 0 ohm"):
        winding_resistance([1.0, 2.0], [-1.0, -2.0])
    with pytest.raises(DataError, match="finite"):
        winding_resistance([1.0, math.nan], [1.0, 2.0])
    with pytest.raises(DataError, match="must not be 0 rad/s"):
        collect_steady_states([1.0, 2.0], [1.0, 2.0], [0.0, 10.0])
    with pytest.raises(DataError, match="at least two speeds"):
        collect_steady_states([1.0, 2.0], [1.0, 2.0], [10.0, 10.0])


def test_tests_that_contradict_each_other() -> None:
    with pytest.raises(DataError, match="motor constant K is"):
        estimate_motor_constants(running(), Winding(MeasuredValue(400.0)))
    with pytest.raises(DataError, match="more slowly than the current"):
        estimate_motor_constants(running(), held_rotor(), current_rise=run_up(), run_up=held_current())
    with pytest.raises(ParameterError, match="not both"):
        estimate_motor_constants(running(), held_rotor(), current_rise=held_current(), inductance=L)
