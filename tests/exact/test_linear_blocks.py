"""Linear blocks: stable whatever their numbers are, exact, well conditioned; and their starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from martensite.base.errors import DataError, InputError, ParameterError
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import fit_linear_model, linear_start
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.goals import noise_model
from martensite.identify.chains.impulse_response import impulse_response, match_poles, realise_responses
from martensite.identify.chains.linear_system import build_state_space, find_poles, find_zeros
from martensite.identify.chains.scores import fit_percent
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Sampled

DT = 0.1
WILD = st.floats(-1e3, 1e3)
BLOCKS = [
    TransferFunction(nb=3, nf=3, nk=1),
    StateSpace(order=3, ins=2, outs=2, nk=0, offset="yes"),
    StateSpace(order=4, ins=3, outs=1, nk=2),
    StateSpace(order=1),
]


def _numbers(block: TransferFunction | StateSpace, seed: int = 0) -> np.ndarray:
    return block.sample_parameters(np.random.default_rng(seed), 20.0, DT)


def _record(u: np.ndarray, y: np.ndarray, dt: float = DT) -> Sampled:
    names = tuple(f"u{i}" for i in range(u.shape[1])), tuple(f"y{i}" for i in range(y.shape[1]))
    return Sampled("made", dt, u, y, *names)


@given(st.lists(WILD, min_size=5, max_size=5), st.sampled_from([1e-5, 2e-3, 1.0]))
def test_no_numbers_make_an_unstable_model(theta: list[float], dt: float) -> None:
    for order in (1, 2, 3, 4, 5):
        z = sections.find_poles(order, np.array(theta[:order]), dt)
        assert len(z) == order and np.all(np.abs(z) < 1.0)


@settings(max_examples=30)
@given(st.lists(st.floats(-20.0, 20.0), min_size=3, max_size=3))
def test_a_step_through_any_sections_stays_bounded(theta: list[float]) -> None:
    state = sections.rest_cascade(3, 0.0)
    for _ in range(200):
        state = sections.step_cascade(floats, 3, theta, state, 1.0, 2e-3).state
    # a damping ratio of e^-9 rings to at most twice the step, in its change by as much again
    assert np.all(np.isfinite(state)) and max(map(abs, state)) < 10.0


@pytest.mark.parametrize("block", BLOCKS, ids=lambda b: b.text())
def test_matrices_run_like_the_kernel(block: TransferFunction | StateSpace) -> None:
    theta = _numbers(block)
    rng = np.random.default_rng(1)
    u = rng.normal(size=(40, block.inputs))
    u[0] = 0.0
    y = ChainEngine([block], DT, compiled=False).simulate(theta, u)
    system, s = build_state_space(block, theta, DT), np.zeros(block.states())
    free = theta[len(theta) - block.outputs :] if getattr(block, "offset", "no") == "yes" else 0.0
    for x, expected in zip(u, y, strict=True):
        np.testing.assert_allclose(system.c @ s + system.d @ x + free, expected, atol=1e-10)
        s = system.a @ s + system.b @ x


@pytest.mark.parametrize("block", BLOCKS, ids=lambda b: b.text())
def test_rest_is_rest(block: TransferFunction | StateSpace) -> None:
    u = np.tile(np.random.default_rng(2).normal(size=block.inputs), (100, 1))
    y = ChainEngine([block], DT, compiled=False).simulate(_numbers(block), u)
    assert np.ptp(y, axis=0).max() < 1e-9 * (1.0 + np.abs(y).max())


def test_poles_are_those_of_the_matrices() -> None:
    block = TransferFunction(nb=3, nf=3, nk=1)
    theta = np.array([np.log(2.0), np.log(3.0), np.log(0.4), 0.2, -0.1])
    of_matrix = np.linalg.eigvals(build_state_space(block, theta, DT).a)
    for z in find_poles(block, theta, DT):
        assert np.abs(of_matrix - z).min() < 1e-9


def test_frequency_response_has_unit_gain_at_rest_and_vanishes_at_zeros() -> None:
    block = TransferFunction(nb=3, nf=3, nk=1)
    theta = _numbers(block)
    assert build_state_space(block, theta, DT).frequency_response(0.0)[0, 0, 0] == pytest.approx(1.0)
    for z in find_zeros(block, theta, DT):
        made = build_state_space(block, theta, DT)
        left = made.c @ np.linalg.solve(z * np.eye(len(made.a)) - made.a, made.b + 0j) + made.d
        assert np.abs(left).max() < 1e-6


def test_blocks_that_are_not_linear_have_no_poles() -> None:
    with pytest.raises(ParameterError, match="not linear"):
        build_state_space(Polynomial(), np.zeros(3), DT)
    with pytest.raises(ParameterError, match="several inputs"):
        find_zeros(StateSpace(ins=2), np.zeros(6), DT)
    with pytest.raises(InputError, match="no start"):
        linear_start(Polynomial(), np.zeros(3), np.zeros(3), DT)


def test_single_precision_keeps_the_step_response() -> None:
    numbers = [np.log(15.0), np.log(0.25), np.log(1.2)]
    dt, state, exact = 2e-3, [np.float32(0.0)] * 3, [0.0] * 3
    p = np.float32(sections.first_order(floats, numbers[0], dt))
    d = [np.float32(x) for x in sections.second_order(floats, numbers[1], numbers[2], dt)]
    away = 0.0
    for _ in range(60_000):
        exact = sections.step_cascade(floats, 3, numbers, exact, 1.0, dt).state
        v = state[0] + p * (np.float32(1.0) - state[0])
        change = state[2] + d[1] * (v - (state[1] - state[2])) - d[0] * state[2]
        state = [v, state[1] + change, change]
        away = max(away, abs(float(state[1]) - exact[1]))
    assert exact[1] > 0.99
    assert away < 1e-3


@pytest.mark.usefixtures("c_compiler")
@pytest.mark.parametrize("tau", [2.0, 20.0])
def test_derivatives_stay_well_conditioned_for_slow_systems(tau: float) -> None:
    dt = 2e-3  # τ up to 10⁴ samples
    block = TransferFunction(nb=3, nf=3, nk=1)
    theta = np.array([np.log(tau), np.log(4.0 / tau), np.log(1.2), 0.2, 0.3])
    rng = np.random.default_rng(0)
    u = np.repeat(rng.uniform(-1.0, 1.0, 200), 200)[:, None]
    _, slopes = ChainEngine([block], dt).jacobian(theta, u)
    columns = slopes[:, 0] / np.linalg.norm(slopes[:, 0], axis=0)
    assert np.linalg.cond(columns) <= 1e3


@pytest.mark.usefixtures("c_compiler")
def test_poles_next_to_one_are_recovered_from_fast_data() -> None:
    dt, slow = 2e-3, 0.9999
    block = TransferFunction(nb=2, nf=2, nk=1)
    wanted = match_poles(np.array([slow, 0.995]), dt).numbers
    theta = np.append(wanted, 0.3)
    rng = np.random.default_rng(3)
    u = np.repeat(rng.uniform(-1.0, 1.0, 20), 1000)[:, None]
    y = ChainEngine([block], dt).simulate(theta, u)
    y += 0.002 * rng.normal(size=y.shape)
    chain = fit_linear_model(_record(u, y, dt), 2)
    found: Any = find_poles(chain.blocks[0], chain.split()[0], dt)
    np.testing.assert_allclose(np.log(np.sort(found.real)), np.log([0.995, slow]), rtol=0.02)
    assert np.all(found.imag == 0.0)


def test_poles_that_no_section_has_become_the_nearest_it_has() -> None:
    kept = match_poles(np.array([0.9, 0.5 + 0.3j, 0.5 - 0.3j]), DT)
    back = sections.find_poles(3, kept.numbers, DT)
    np.testing.assert_allclose(back, np.array([0.9, 0.5 + 0.3j, 0.5 - 0.3j])[kept.places])
    mirrored = sections.find_poles(1, match_poles(np.array([1.25]), DT).numbers, DT)
    assert mirrored[0] == pytest.approx(0.8)
    together = sections.find_poles(2, match_poles(np.array([-0.5, -0.5]), DT).numbers, DT)
    np.testing.assert_allclose(together, [-0.5, -0.5], atol=1e-8)
    alone = sections.find_poles(1, match_poles(np.array([-0.5]), DT).numbers, DT)
    assert 0.0 < alone[0].real < 1e-3


def test_realisation_of_an_impulse_response_is_exact() -> None:
    a, b, c = np.diag([0.9, 0.5]), np.array([[1.0, 0.3], [0.2, 1.0]]), np.array([[1.0, -0.4]])
    g = np.array([c @ np.linalg.matrix_power(a, k) @ b for k in range(20)])
    found = realise_responses(g, 2)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(found.a)), [0.5, 0.9], rtol=1e-8)
    np.testing.assert_allclose(found.c @ found.b, c @ b, atol=1e-10)


def test_impulse_response_of_a_record_with_gaps() -> None:
    rng = np.random.default_rng(4)
    u = rng.normal(size=(3000, 1))
    g = 0.8 ** np.arange(30)
    y = np.convolve(u[:, 0], np.append(0.0, g))[:3000, None] + 2.0
    y += 0.05 * rng.normal(size=y.shape)
    y[rng.random(3000) < 0.2] = np.nan
    found = impulse_response([(u, y)], 30, 1)
    assert found.shape == (30, 1, 1)
    np.testing.assert_allclose(found[:, 0, 0], g, atol=0.01)
    with pytest.raises(DataError, match="at least 4"):
        impulse_response([(u, np.full_like(y, np.nan))], 30, 1)


@pytest.mark.usefixtures("c_compiler")
def test_several_inputs_and_outputs_are_reproduced_with_gaps_and_records() -> None:
    rng = np.random.default_rng(5)
    truth = StateSpace(order=3, ins=2, outs=2, nk=1, offset="yes")
    theta = truth.sample_parameters(rng, 20.0, DT)
    theta[:3] = [np.log(1.5), np.log(2.0), np.log(0.5)]
    engine, records = ChainEngine([truth], DT), list[Sampled]()
    for _ in range(2):
        u = np.repeat(rng.uniform(-1.0, 1.0, (80, 2)), 8, axis=0)
        y = engine.simulate(theta, u)
        y += 0.01 * np.std(y, axis=0) * rng.normal(size=y.shape)
        y[rng.random(len(y)) < 0.1] = np.nan
        records.append(_record(u, y))
    u = rng.uniform(-1.0, 1.0, (500, 2))
    clean = engine.simulate(theta, u)
    chain = fit_linear_model(records, 3)
    assert np.min(fit_percent(clean, chain.simulate(u))) > 99.0
    # and antagonists, whose inputs cancel in a plain sum
    theta[3:6] = [1.0 / (1.0 - 0.5), 0.0, 0.0]
    y = engine.simulate(theta, records[0].inputs)
    start = linear_start(truth, records[0].inputs, y, DT)
    assert np.min(fit_percent(engine.simulate(theta, u), engine.simulate(start.theta, u))) > 98.0


def test_drawn_zeros_lead_and_lag() -> None:
    rng = np.random.default_rng(8)
    block = TransferFunction(nb=2, nf=1, nk=0)
    drawn = np.array([block.sample_parameters(rng, 100.0, DT) for _ in range(400)])
    weight = drawn[:, 1]
    shares = [np.mean(weight > 4.0), np.mean(np.abs(weight) < 1.0), np.mean(weight < 0.0)]
    assert min(shares) > 0.1


def test_weights_give_the_zeros_that_they_are_for() -> None:
    numbers, leads, dt = np.log([2.0, 3.0, 0.4]), np.array([5.0, 0.7, -0.3]), 1e-4
    block = TransferFunction(nb=4, nf=3, nk=0)
    theta = np.concatenate([numbers, sections.compute_weights(3, numbers, leads)])
    found = np.log(find_zeros(block, theta, dt)) / dt
    np.testing.assert_allclose(np.sort(-1.0 / found.real), np.sort(leads), rtol=2e-3)


@pytest.mark.usefixtures("c_compiler")
def test_start_of_a_block_without_poles_is_its_weights() -> None:
    block = TransferFunction(nb=3, nf=0, nk=0)
    u = np.random.default_rng(6).normal(size=200)
    y = 2.0 * np.convolve(u, [0.5, 0.3, 0.2])[:200] + 1.0
    y[:3] = np.nan
    start = linear_start(block, u, y, DT)
    np.testing.assert_allclose(start.theta, [0.3, 0.2], atol=1e-9)
    assert (start.gain, start.offset) == (pytest.approx(2.0), pytest.approx(1.0))


def test_noise_model_recovers_an_autoregression_and_leaves_white_noise() -> None:
    rng = np.random.default_rng(7)
    e, v = rng.normal(size=20_000), np.zeros(20_000)
    for t in range(2, len(v)):
        v[t] = 1.5 * v[t - 1] - 0.7 * v[t - 2] + e[t]
    v[5000:5010] = np.nan
    np.testing.assert_allclose(noise_model([v[:, None]], 2), [1.0, -1.5, 0.7], atol=0.03)
    assert np.abs(noise_model([e[:, None]], 2)[1:]).max() < 0.03
    with pytest.raises(DataError, match="order 3"):
        noise_model([e[:6, None]], 3)


def test_text_of_state_space_goes_there_and_back() -> None:
    from martensite.identify.chains.chain_text import parse_chain

    text = StateSpace(order=3, ins=2, outs=2, nk=0).text()
    block = parse_chain(text)[0]
    assert (block.text(), block.inputs, block.outputs) == (text, 2, 2)
    assert parse_chain("ss3")[0].inputs == 1
    theta = block.start()
    assert isinstance(Chain((block,), theta, DT, ("a", "b"), ("c", "d")).simulate(np.ones((5, 2))), np.ndarray)
