"""A model under PID control in C, and gains tuned on it.

Sources of truth: the transfer function of a linear loop, the same loop run sample by sample with
the controller on plain floats, and differences.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from martensite.base.errors import ParameterError
from martensite.control.controllers.pid import Gains, PidLaw
from martensite.control.tuning.closed_loop import ControlledModel, Trajectory, compute_logarithms
from martensite.control.tuning.measures import StepResponse, build_steps
from martensite.control.tuning.tuning import ModelTuning, compute_cost, tune_model
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.chain import Chain
from martensite.kernels import floats

DT = 0.05
WIDE = PidLaw(low=-1e6, high=1e6)
GAINS = Gains(1.5, 0.05, 2.0)
REFERENCE = build_steps([(0.0, 1.0), (1.0, 8.0), (-0.5, 8.0)], DT)


def model(gain: float = 2.0, offset: float = 0.0, tau: float = 1.0) -> Chain:
    """y = offset + gain x, x following u with a lag, a sample later."""
    line = Polynomial(degree=1.0, low=-1.0, high=1.0)
    blocks = (TransferFunction(nb=1.0, nf=1.0, nk=1.0), line)
    return Chain(blocks, np.concatenate([[math.log(tau)], line.line(gain, offset)]), DT)


@cache
def loop(law: PidLaw, gain: float = 2.0, offset: float = 0.0, tau: float = 1.0) -> ControlledModel:
    return ControlledModel(model(gain, offset, tau), law, reverse=gain < 0.0)


# ---------------------------------------------------------------- the loop


def test_a_linear_loop_has_its_transfer_function(c_compiler: str) -> None:
    """L = C G with G = 2 p z⁻¹/(1 - (1 - p) z⁻¹); y = L/(1 + L) r, from an error of 0."""
    Kp, Ki, Kd = GAINS
    p = -math.expm1(-DT)
    controller, integrator = [Kp + Ki + Kd, -Kp - 2.0 * Kd, Kd], [1.0, -1.0]
    ahead = np.convolve(controller, [0.0, 2.0 * p])
    around = np.polyadd(ahead, np.pad(np.convolve(integrator, [1.0, p - 1.0]), (0, 1)))
    found = loop(WIDE).run(GAINS, REFERENCE)
    expected = lfilter(ahead, around, REFERENCE)
    np.testing.assert_allclose(found.output, expected, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("gain", [2.0, -2.0])
def test_with_limits_it_is_the_loop_sample_by_sample(gain: float, c_compiler: str) -> None:
    law = PidLaw(low=-0.2, high=0.6, weight=0.7, filter=2.0 * DT)
    gains = Gains(*(math.copysign(g, gain) for g in GAINS))
    found = loop(law, gain, 0.3).run(gains, REFERENCE)
    chain = model(gain, 0.3)
    state, signal, memory = chain.engine.rest(chain.theta, np.zeros(1)).state, 0.0, None
    rest = chain.simulate(np.zeros((1, 1)))[0, 0]
    for k, wanted in enumerate(REFERENCE.tolist()):
        seen = chain.engine.simulate(chain.theta, np.array([[signal]]), state.copy())[0, 0] - rest
        memory = memory or law.rest(floats, wanted, seen)
        signal, memory = law.answer(floats, gains, memory, wanted, seen, DT, sampled=True)
        chain.engine.simulate(chain.theta, np.array([[signal]]), state)
        assert found.output[k] == pytest.approx(seen, abs=1e-12)
        assert found.signal[k] == pytest.approx(signal, abs=1e-12)
    assert (found.signal.min(), found.signal.max()) == (-0.2, 0.6)


def test_floats_and_c_agree(c_compiler: str) -> None:
    law = PidLaw(low=-0.2, high=0.6)
    fast = loop(law).run(GAINS, REFERENCE)
    plain = ControlledModel(model(), law, compiled=False).run(GAINS, REFERENCE)
    np.testing.assert_allclose(fast.output, plain.output, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(fast.signal, plain.signal, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("compiled", [True, False])
def test_derivatives_with_respect_to_gains(compiled: bool, c_compiler: str) -> None:
    held = loop(WIDE) if compiled else ControlledModel(model(), WIDE, compiled=False)
    found = held.slopes(GAINS, REFERENCE)[1]
    h = 1e-5
    for k, change in enumerate(h * np.eye(3)):
        up, down = (held.run(Gains(*np.exp(compute_logarithms(GAINS) + sign * change)), REFERENCE) for sign in (1, -1))
        for row, (a, b) in enumerate(((up.output, down.output), (up.signal, down.signal))):
            expected = (a - b) / (2.0 * h)
            scale = np.abs(expected).max()
            assert scale > 1e-3
            np.testing.assert_allclose(found[:, row, k], expected, rtol=0.0, atol=1e-7 * scale)


def test_other_numbers_need_no_other_program(c_compiler: str) -> None:
    assert loop(WIDE).engine.plan is loop(WIDE, 3.0, 0.1, 2.0).engine.plan
    assert loop(WIDE).engine.plan is not loop(PidLaw()).engine.plan


def test_the_position_at_rest_counts_as_zero_unless_told(c_compiler: str) -> None:
    raw = ControlledModel(model(2.0, 0.3), WIDE, zeroed=False)
    assert loop(WIDE, 2.0, 0.3).run(GAINS, REFERENCE).output[0] == pytest.approx(0.0, abs=1e-9)
    assert raw.run(GAINS, REFERENCE).output[0] == pytest.approx(0.3)


def test_a_model_that_cannot_be_controlled_is_refused() -> None:
    with pytest.raises(ParameterError, match="there is no 1"):
        ControlledModel(model(), measured=1)


# ---------------------------------------------------------------- tuning

TASK = ModelTuning(levels=((0.0, 1.0), (1e-3, 6.0)), starts=((5.0, 0.01, 0.1), (20.0, 0.1, 10.0)), evaluations=80)


@cache
def millimetres() -> ControlledModel:
    """A model of 20 mm per unit of duty."""
    return ControlledModel(model(0.02), PidLaw())


def test_the_cost_by_hand() -> None:
    reference = np.array([0.0, 0.0, 1e-3, 1e-3, 1e-3])
    output = np.array([0.0, 0.0, 0.0, 1.2e-3, 1e-3])
    signal = np.array([0.0, 0.0, 0.5, 0.5, 0.1])
    gains = Gains(1000.0, 1.0, 1e5)
    found = compute_cost(Trajectory(reference, output, signal, DT), gains, TASK)
    error, overshoot, activity = 1.2 / 5, 0.2, 2.0 * (50.0 + 40.0) / 4
    assert found == pytest.approx(error + overshoot + activity + 1e-4 * 100.0 + 1e-6 * 1e4)
    broken = Trajectory(reference, np.full(5, np.nan), signal, DT)
    assert compute_cost(broken, gains, TASK) == math.inf


def test_tuning_finds_gains_that_follow(c_compiler: str) -> None:
    told: list[float] = []
    found = tune_model(millimetres(), TASK, lambda text, share: told.append(share))
    reference = build_steps(TASK.levels, DT)
    for start in TASK.starts:
        gains = Gains(*(10.0 * g for g in start))
        begun = compute_cost(millimetres().run(gains, reference), gains, TASK)
        assert found.cost < begun
    assert found.cost == compute_cost(millimetres().run(found.gains, reference), found.gains, TASK)
    assert found.evaluations <= 90
    assert told == [0.5, 1.0]
    (answer,) = found.responses
    assert isinstance(answer, StepResponse)
    assert answer.rise < 3.0
    assert abs(answer.error) < 5e-5
    assert {n: v for n, v, _ in found.rows()}["step 1 rise"] == answer.rise
    assert found.scale_gains().Kp == pytest.approx(0.1 * found.gains.Kp)


def test_tuning_repeats(c_compiler: str) -> None:
    assert tune_model(millimetres(), TASK).gains == tune_model(millimetres(), TASK).gains


def test_a_tuning_without_starts_is_refused() -> None:
    with pytest.raises(ParameterError, match="No start"):
        tune_model(millimetres(), ModelTuning(TASK.levels, starts=()))
