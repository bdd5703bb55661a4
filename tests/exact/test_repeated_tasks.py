"""Iterative learning and repetitive control: what their equations say.

Sources of truth: the equations written over all samples at once, on a lag y(k+1) = a y(k) + b u(k) with numbers of its
own, and the factor by which theory says that an error of one frequency shrinks in a repetition.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.base.errors import ParameterError
from martensite.control.controllers.iterative_learning import AbstractLearning, IterativeLearning
from martensite.control.controllers.pid import PidLaw
from martensite.control.controllers.repeated_task import find_weights
from martensite.control.controllers.repetitive import Repetitive
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import simulate_bench
from martensite.kernels import floats
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.signals.sine import Sine

DT, N, A, B, KP = 0.1, 20, 0.8, 0.1, 2.0
TURN = 2.0 * math.pi / N
WIDE = PidLaw(low=-1e9, high=1e9)
Rows = np.ndarray


def make(cls: type[AbstractLearning], **given: Any) -> Any:
    """A controller of `y`; a task of 20 samples, one point for each."""
    usual: dict[str, Any] = {"period": DT, "task": N * DT, "points": N, "smoothing": 0, "Kp": KP, "law": WIDE}
    return cls(measured="y", reference=Constant(level=0.0), **{**usual, **given})


def play(
    controller: AbstractLearning,
    repetitions: int,
    gain: Callable[[int], float] = lambda k: B,
    again: bool = False,
    a: float = A,
) -> tuple[Rows, Rows, Rows]:
    """Errors, signals, and what the controller says of itself, of a lag asked for sin(2πk/N)."""
    y, memory, rows = 0.0, None, list[tuple[float, float]]()
    said = list[list[float]]()
    for k in range(repetitions * N):
        y = 0.0 if again and k % N == 0 else y
        wanted, dt = math.sin(TURN * k), DT if k else 0.0
        memory = memory or controller.rest(floats, wanted, {"y": y})
        signal, memory = controller.answer(floats, memory, wanted, {"y": y}, dt)
        rows.append((wanted - y, signal))
        said.append(list(controller.observe(floats, memory)))
        y = a * y + gain(k) * signal
    errors, signals = np.array(rows).T
    return errors, signals, np.array(said)


def sizes(errors: Rows) -> Rows:
    """Rms of every repetition."""
    return np.sqrt((errors.reshape(-1, N) ** 2).mean(axis=1))


def test_iterative_learning_is_its_equation() -> None:
    g, lead, half, forgotten, count = 3.0, 2, 1, 0.05, 4 * N
    learning = make(
        IterativeLearning, learning_gain=g, lead=lead * DT, smoothing=half, forgetting=forgotten, growth=1e9
    )
    errors, signals, _ = play(learning, 4)
    e, v, w, y = np.zeros(count), np.zeros(count), dict[int, float](), 0.0
    for k in range(count):
        e[k] = math.sin(TURN * k) - y
        if k >= lead:
            w[k - lead] = v[k - lead] + g * e[k]
        if k >= N - half:
            near = [w.get(k - N + i, 0.0) for i in (-1, 0, 1)]
            v[k] = (1.0 - forgotten) * (0.25 * near[0] + 0.5 * near[1] + 0.25 * near[2])
        y = A * y + B * (v[k] + KP * e[k])
    np.testing.assert_allclose(errors, e, atol=1e-12)
    np.testing.assert_allclose(signals, v + KP * e, atol=1e-12)
    assert find_weights(2) == [1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16]


@pytest.mark.parametrize(
    ("cls", "gain", "share"), [(IterativeLearning, 2.0, 1.0), (Repetitive, 0.5, KP), (Repetitive, 2.0, KP)]
)
def test_an_error_shrinks_by_the_factor_of_theory(cls: type[AbstractLearning], gain: float, share: float) -> None:
    """1 - g z^λ G/(1 + C G) or 1 - g z^λ C G/(1 + C G), of a closed loop that is a delay by the lead: a = b K_p."""
    errors, _, said = play(make(cls, learning_gain=gain, lead=DT), 12, a=B * KP)
    found = sizes(errors)
    np.testing.assert_allclose(found[2:] / found[1:-1], 1.0 - gain * share * B, rtol=1e-6)
    shifted = sizes(np.append(errors[1:], 0.0))  # a repetition ends with the first sample of the next
    np.testing.assert_allclose(said[N::N, 1], shifted[:-1], rtol=1e-9)
    assert said[-1, 0] == 11 and said[-1, 2] == 1.0


def test_between_resets_each_repetition_begins_like_the_first() -> None:
    g, lead, Ki = 3.0, 1, 0.3
    learning = make(IterativeLearning, learning_gain=g, lead=lead * DT, Ki=Ki / DT, between="reset")
    errors, _, _ = play(learning, 6, again=True)
    v = np.zeros(N)
    for j in range(6):
        e, y, total = np.zeros(N), 0.0, 0.0
        for k in range(N):
            e[k] = math.sin(TURN * k) - y
            total += Ki * e[k]
            y = A * y + B * (v[k] + KP * e[k] + total)
        np.testing.assert_allclose(errors[j * N : (j + 1) * N], e, atol=1e-12, err_msg=f"repetition {j}")
        v = v + g * np.append(e[lead:], np.zeros(lead))


@pytest.mark.parametrize(("cls", "gain"), [(IterativeLearning, 22.0), (Repetitive, 3.5)])
def test_what_diverges_stops_and_leaves_the_pid_alone(cls: type[AbstractLearning], gain: float) -> None:
    errors, _, said = play(make(cls, learning_gain=gain), 40)
    alone, _, _ = play(make(cls, learning_gain=0.0), 40)
    found, learning = sizes(errors), said[:, 2]
    stopped = int(np.argmin(learning)) // N
    assert learning[0] == 1.0 and learning[-1] == 0.0
    assert found[stopped - 1] > 2.0 * found[:stopped].min()
    assert found[-1] == pytest.approx(sizes(alone)[-1], rel=1e-6)


def test_a_plant_that_changes_is_learned_anew() -> None:
    """Its gain falls to a third in the tenth repetition: the error jumps, and shrinks again."""
    errors, _, said = play(
        make(IterativeLearning, learning_gain=4.0, lead=DT), 40, lambda k: B if k < 10 * N else B / 3.0
    )
    found = sizes(errors)
    assert found[10] > 5.0 * found[9]
    assert found[-1] < 0.02 * found[10]
    assert said[-1, 2] == 1.0


def test_a_signal_at_its_limit_learns_nothing_that_pushes_further() -> None:
    law = PidLaw(low=-0.5, high=0.5)
    _, signals, said = play(make(IterativeLearning, learning_gain=4.0, law=law, growth=1e9), 60)
    assert np.abs(signals).max() == 0.5
    assert np.abs(said[:, 3]).max() < 4.0
    np.testing.assert_allclose(said[-N:, 3], said[-2 * N : -N, 3], atol=0.05)


def test_between_points_the_learned_signal_is_straight() -> None:
    errors, _, said = play(make(IterativeLearning, learning_gain=1.0, points=N // 4, lead=4 * DT), 12)
    bends = np.abs(np.diff(said[2 * N :, 3], 2)) > 1e-9
    assert set(np.flatnonzero(bends) % 4) == {3}
    assert sizes(errors)[-1] < 0.5 * sizes(errors)[1]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"points": N + 1}, "has 20 samples of 0.1 s"),
        ({"points": 2.5}, "whole number from 4 on"),
        ({"smoothing": -1}, "whole number from 0 on"),
        ({"lead": 1.9}, "do not fit into a task"),
    ],
)
def test_a_task_that_cannot_be_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        make(Repetitive, **given)


def test_a_bench_of_another_period_is_refused() -> None:
    controller = make(Repetitive).with_parts(measured="position")
    plant = problem_a(source=PwmVoltage(supply=6.0))
    with pytest.raises(ParameterError, match=r"`period` of 0.1 s, but the bench one of 0.05 s"):
        Bench(plant=plant, period=0.05, controllers=Controllers(drive=controller))


def test_a_run_says_that_learning_has_stopped() -> None:
    controller = IterativeLearning(
        measured="position",
        reference=Sine(low=1e-3, high=3e-3, frequency=2.0),
        Kp=20.0,
        learning_gain=2e4,
        period=0.02,
        task=0.5,
        points=25,
    )
    bench = Bench(
        plant=problem_a(source=PwmVoltage(supply=6.0)), period=0.02, controllers=Controllers(drive=controller)
    )
    run = simulate_bench(bench, 10.0)
    assert run["controller.learning"][-1] == 0.0
    assert any("Learning has stopped" in sentence for sentence in run.warnings)
    assert not any("Learning" in sentence for sentence in simulate_bench(bench, 1.0).warnings)
