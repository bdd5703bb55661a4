"""Lanes: they go the way of a march, whoever pushes them, in C and on floats.

Source of truth: `simulate`, the march on floats in the same steps, and lanes of systems whose
parameters have been set one by one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import InputError
from martensite.base.status import Status
from martensite.kernels.compiler import find_compiler
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.held import Held
from martensite.simulate.api import simulate
from martensite.simulate.lanes import Lanes
from martensite.simulate.march import SOLVED

DT, COUNT = 0.04, 5
PATH = "environment.temperature"
SYSTEM = problem_a().with_parts(source=PwmVoltage(supply=6.0))
WARMER = SYSTEM.value_of(PATH) + np.arange(COUNT, dtype=float)
NATIVE = [pytest.param(True, marks=pytest.mark.skipif(find_compiler() is None, reason="no C compiler")), False]


def signals(steps: int, seed: int = 0, most: float = 0.6) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.0, most, (steps, 1, COUNT))


def lanes(native: bool | None = None, **values: Any) -> Lanes:
    found = Lanes(SYSTEM, COUNT, values or None, native)
    found.reset()
    return found


def agree(one: np.ndarray, other: np.ndarray) -> None:
    """Raise unless numbers are the same but for rounding."""
    assert one.shape == other.shape
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


# ---------------------------------------------------------------- the same way


@pytest.mark.parametrize("native", NATIVE)
def test_they_go_the_way_of_a_march(native: bool) -> None:
    given = signals(60)
    found = lanes(native)
    rows = found.advance(given, DT)
    for lane in (0, COUNT - 1):
        played = Held(values=tuple(given[:, 0, lane].tolist()), frequency=1.0 / DT)
        run = simulate(SYSTEM, played, 60 * DT, samples=61, step=DT, runtime="floats")
        for name in ("position", "temperature", "martensite_fraction"):
            seen = rows[:, found.names.index(name), lane]
            np.testing.assert_allclose(seen, run[name][1:], rtol=1e-9, atol=1e-12)
    moved = rows[:, found.names.index("position")]
    assert np.all(np.ptp(moved, axis=0) > 1e-3)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_c_and_floats_agree_with_parameters_by_lane() -> None:
    native, plain = (lanes(n, **{PATH: WARMER}) for n in (True, False))
    agree(native.advance(signals(40), DT), plain.advance(signals(40), DT))
    agree(native.state, plain.state)
    agree(native.observe(0.3), plain.observe(0.3))
    agree(native.worst, plain.worst)


def test_parameters_by_lane_are_those_of_systems_of_their_own() -> None:
    warmer: Any = {PATH: WARMER}
    rows = lanes(**warmer).advance(signals(30), DT)
    for lane in (0, 3):
        alone = Lanes(SYSTEM.with_values({PATH: WARMER[lane]}), 1)
        alone.reset()
        agree(alone.advance(signals(30)[:, :, lane : lane + 1], DT), rows[:, :, lane : lane + 1])
    assert not np.allclose(rows[:, :, 0], rows[:, :, 3])


def test_one_step_at_a_time_and_many_at_once_are_the_same() -> None:
    given, many, single = signals(20), lanes(), lanes()
    rows = many.advance(given, DT)
    steps = np.concatenate([single.advance(one[None], DT) for one in given])
    assert np.array_equal(rows, steps)
    assert np.array_equal(many.state, single.state)


def test_one_signal_is_for_all_lanes() -> None:
    one, all_of_them = lanes(), lanes()
    rows = one.advance(np.full((3, 1, 1), 0.4), DT)
    assert np.array_equal(rows, all_of_them.advance(np.full((3, 1, COUNT), 0.4), DT))
    assert np.array_equal(one.advance([[[0.4]]], DT), all_of_them.advance([[[0.4] * COUNT]], DT))


@pytest.mark.parametrize("steps", [1, 4])
def test_outputs_are_shown_only_if_wanted(steps: int) -> None:
    quiet, shown = lanes(), lanes()
    assert quiet.advance(signals(steps), DT, shown=False).shape == (0, len(quiet.names), COUNT)
    rows = shown.advance(signals(steps), DT)
    assert np.array_equal(quiet.state, shown.state)
    agree(rows[-1], shown.observe(signals(steps)[-1]))


# ---------------------------------------------------------------- states


@pytest.mark.parametrize("native", NATIVE)
def test_a_state_can_be_kept_and_gone_on_from(native: bool) -> None:
    found = lanes(native)
    found.advance(signals(10), DT)
    kept = found.state
    before = found.advance(signals(6, seed=1), DT)
    assert not np.array_equal(found.state, kept)
    found.state = kept
    assert np.array_equal(found.advance(signals(6, seed=1), DT), before)


def test_all_lanes_go_on_from_one_of_others() -> None:
    some, others = lanes(), lanes()
    others.advance(signals(25), DT)
    some.copy_from(others, lane=2)
    assert np.array_equal(some.state, np.repeat(others.state[:, 2:3], COUNT, axis=1))


def test_reset_forgets() -> None:
    found = lanes()
    first = found.advance(signals(8), DT)
    found.reset()
    assert np.array_equal(found.advance(signals(8), DT), first)


# ---------------------------------------------------------------- other parameters


@pytest.mark.parametrize("native", NATIVE)
def test_other_values_are_those_of_new_lanes(native: bool) -> None:
    """Steps that are hard included, whose constants are kept apart."""
    new, found = lanes(native, **{PATH: WARMER}), lanes(native)
    found.advance(hard(), 0.3)
    found.set_values({PATH: WARMER})
    found.reset()
    for dt, given in ((DT, signals(10)), (0.3, hard())):
        rows = new.advance(given, dt)
        assert np.array_equal(found.advance(given, dt), rows)
    assert np.array_equal(found.observe(0.2), new.observe(0.2))
    assert np.array_equal(found.worst, new.worst)
    assert not np.allclose(rows, lanes(native).advance(given, dt))


@pytest.mark.parametrize("native", NATIVE)
def test_values_that_are_not_named_and_states_stay(native: bool) -> None:
    found, both = lanes(native, **{PATH: WARMER}), {PATH: WARMER, "source.supply": 5.0}
    found.advance(signals(5), DT)
    state, worst = found.state.copy(), found.worst.copy()
    found.set_values({"source.supply": 5.0})
    assert np.array_equal(found.state, state)
    assert np.array_equal(found.worst, worst)
    found.reset()
    new = lanes(native, **both)
    assert np.array_equal(found.advance(signals(5), DT), new.advance(signals(5), DT))


def test_values_that_do_not_fit_are_refused_and_change_nothing() -> None:
    found, same = lanes(), lanes()
    with pytest.raises(InputError, match=r"no parameter `source.suply`.*`source.supply`"):
        found.set_values({PATH: 250.0, "source.suply": 5.0})
    with pytest.raises(InputError, match=r"one number or of shape \(5,\), but their shape is \(3,"):
        found.set_values({PATH: [300.0, 301.0, 302.0]})
    assert np.array_equal(found.advance(signals(3), DT), same.advance(signals(3), DT))


# ---------------------------------------------------------------- steps that are hard


def hard() -> np.ndarray:
    return signals(12, seed=3, most=1.0)


@pytest.mark.parametrize("native", NATIVE)
def test_hard_steps_are_solved(native: bool) -> None:
    found = lanes(native)
    found.advance(hard(), 0.3)
    assert np.all(found.worst[0] <= SOLVED)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_hard_steps_are_the_same_in_c_and_on_floats() -> None:
    native, plain = lanes(True), lanes(False)
    np.testing.assert_allclose(native.advance(hard(), 0.3), plain.advance(hard(), 0.3), rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("native", NATIVE)
def test_status_says_which_lane_took_too_long_a_step(native: bool) -> None:
    found = lanes(native)
    assert found.status == [Status.OK] * COUNT
    given = np.zeros((4, 1, COUNT))
    given[:, 0, 2] = 1.0
    found.advance(given, 0.3)
    assert [s > Status.OK for s in found.status] == [lane == 2 for lane in range(COUNT)]
    found.reset()
    assert found.status == [Status.OK] * COUNT


@pytest.mark.parametrize("native", NATIVE)
def test_what_is_no_number_is_a_status_of_its_lane(native: bool) -> None:
    found = lanes(native)
    state = found.state
    state[:, 1] = np.nan
    found.state = state
    found.advance(signals(2), DT)
    assert [s is Status.NOT_FINITE for s in found.status] == [n == 1 for n in range(COUNT)]


# ---------------------------------------------------------------- errors


def test_an_unknown_parameter_is_named_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"environment\.temperature"):
        Lanes(SYSTEM, 2, {"environment.temprature": [290.0, 300.0]})


@pytest.mark.parametrize("shape", [(), (3,), (3, COUNT), (3, 2, COUNT), (3, 1, COUNT + 1)])
def test_signals_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match=r"\(steps, drives, batch\)"):
        lanes().advance(np.zeros(shape), DT)


def test_signals_of_a_moment_must_spread() -> None:
    with pytest.raises(InputError, match=r"\(drives, batch\)"):
        lanes().observe(np.zeros(COUNT + 1))
