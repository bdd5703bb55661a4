"""Polynomial nonlinear state space: its equation, its bound, its rest, its start as linear."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from martensite.base.errors import InputError
from martensite.identify.blocks.nonlinear_state_space import FARTHEST, NonlinearStateSpace
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.chains.best_linear import linear_start
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.scores import fit_percent
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Sampled

DT = 0.1
RNG = np.random.default_rng(4)
U = np.repeat(RNG.uniform(-1.0, 1.0, 30), 4)[:, None]
BLOCK = NonlinearStateSpace(order=2, degree=2, nk=0, low=-1.0, high=3.0, reach=2.0)
LINEAR = [np.log(3.0), np.log(0.4), 1.5, -0.3, 0.2, 0.7]
"""log ω, log ζ, C, D, offset."""


def run(block: NonlinearStateSpace, theta: np.ndarray, u: np.ndarray = U) -> np.ndarray:
    return ChainEngine([block], DT, compiled=False).simulate(theta, u)


def by_hand(e: np.ndarray, f: np.ndarray) -> np.ndarray:
    """The equation of the module with its matrices, from rest at zero input."""
    d = sections.second_order(floats, LINEAR[0], LINEAR[1], DT)
    v, change, made = 0.0, 0.0, []
    for u in [0.0, *U[:, 0]]:
        r = np.clip([(v - 1.0) / 4.0, change / (4.0 * np.sqrt(d.d2)), (u - 1.0) / 2.0], -FARTHEST, FARTHEST)
        phi = 2.0 * np.array([r[i] * r[j] for i in range(3) for j in range(i, 3)])
        first, second = u + e[0] @ phi, e[1] @ phi
        change += d.d2 * (first - (v - change)) - d.d1 * change
        v += change + np.sqrt(d.d2) * second
        made.append(1.5 * v - 0.3 * change / np.sqrt(d.d2) + 0.2 * u + 0.7 + f @ phi)
    return np.array(made[1:])


@pytest.mark.parametrize("size", [0.0, 0.1])
def test_it_computes_its_equation(size: float) -> None:
    e, f = size * RNG.normal(size=(2, 6)), size * RNG.normal(size=6)
    theta = np.concatenate([LINEAR, e.ravel(), f])
    assert BLOCK.numbers()[6:8] == ("e1_00", "e1_01")
    state = np.zeros(2)
    engine = ChainEngine([BLOCK], DT, compiled=False)
    engine.simulate(theta, np.zeros((1, 1)), state)
    y = engine.simulate(theta, U, state)[:, 0]
    assert y == pytest.approx(by_hand(e, f), abs=1e-12)
    assert np.abs(y - by_hand(e + 0.01, f)).max() > 1e-3


def test_it_is_bounded_whatever_its_numbers_are() -> None:
    theta = np.concatenate([LINEAR, 50.0 * RNG.normal(size=len(BLOCK.numbers()) - 6)])
    y = run(BLOCK, theta, 100.0 * np.tile(U, (5, 1)))
    assert np.all(np.isfinite(y)) and np.abs(y).max() < 1e7


def test_rest_is_a_fixed_point() -> None:
    theta = np.concatenate([LINEAR, 0.1 * RNG.normal(size=len(BLOCK.numbers()) - 6)])
    engine = ChainEngine([BLOCK], DT, compiled=False)
    for level in (-0.8, 0.0, 0.7):
        start = engine.rest(theta, np.array([level])).state
        state = start.copy()
        engine.simulate(theta, np.full((1, 1), level), state)
        assert state == pytest.approx(start, abs=1e-10)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_it_begins_as_a_linear_system_within_its_range(order: int) -> None:
    block = NonlinearStateSpace(order=order, outs=2).adapt_to(U, DT)
    twin = block.twin()
    theta = twin.sample_parameters(np.random.default_rng(order), 10.0, DT)
    own, numbers = block.as_linear(twin, theta, U, DT)
    expected = ChainEngine([twin], DT, compiled=False).simulate(theta, U)
    assert run(own, numbers) == pytest.approx(expected, abs=1e-12)
    signals = StateSpace(order=order, outs=order)
    poles = np.concatenate([theta[:order], np.eye(order).ravel()])
    states = ChainEngine([signals], DT, compiled=False).simulate(poles, U)
    half = 0.5 * (own.high - own.low)
    assert own.reach * half >= 0.99 * np.abs(states[:, 1 - order % 2 :: 2]).max() - abs(own.low)


def test_it_is_no_linear_block() -> None:
    with pytest.raises(InputError, match="no start"):
        linear_start(BLOCK, U, U, DT)


def test_text_goes_there_and_back() -> None:
    block: Any = parse_chain("nlss(3,2,2,0)")[0]
    assert (block.order, block.degree, block.outs, block.nk) == (3.0, 2.0, 2.0, 0.0)
    assert parse_chain(block.text())[0].text() == block.text()


def stiffening(u: np.ndarray) -> np.ndarray:
    """y'' + 0.8 y' + 4 y + 3 y³ = 4 u, in small steps."""
    y, v, made = 0.0, 0.0, []
    for force in np.repeat(u, 50):
        v += DT / 50 * (4.0 * force - 0.8 * v - 4.0 * y - 3.0 * y**3)
        y += DT / 50 * v
        made.append(y)
    return np.array(made[49::50])


@pytest.mark.usefixtures("c_compiler")
@pytest.mark.parametrize("text", [pytest.param("nlss(2,3,1,0)", marks=pytest.mark.slow), "fb(2,3) | poly1"])
def test_an_oscillator_is_found_by_itself(text: str) -> None:
    rng = np.random.default_rng(0)
    levels = np.repeat(rng.uniform(-1.5, 1.5, 250), 6)
    y = stiffening(levels)
    noisy = y[:1200] + 0.005 * rng.normal(size=1200)
    record = Sampled("oscillator", DT, levels[:1200], noisy, ("u",), ("y",))
    options = Options(starts=3, refined=1, iterations=40)
    fits = [
        fit_percent(y[1200:, None], estimate_chain(t, record, options).chain.simulate(levels)[1200:])[0]
        for t in (text, "oe(3,2,0) | poly1")
    ]
    assert fits[0] > 97.0 > fits[1] + 8.0
