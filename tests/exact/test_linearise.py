"""Operating points and linear systems of chains, against small steps of the chains themselves."""

from dataclasses import replace

import numpy as np
import pytest

from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.identify.blocks.base import BLOCKS
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.linear_system import LinearSystem
from martensite.identify.chains.linearise import linearise_chain, operating_point, static_curve
from martensite.signals.sampling.sampled import Sampled

DT = 0.05


def plain(blocks, theta=None, rng=None):
    """A chain that runs without a compiler."""
    theta = np.concatenate([np.zeros(0), *(b.start() for b in blocks)]) if theta is None else theta
    if rng is not None:
        theta = theta + 0.1 * rng.normal(size=len(theta))
    made = Chain(
        tuple(blocks),
        theta,
        DT,
        tuple(f"u{i}" for i in range(blocks[0].inputs)),
        tuple(f"y{i}" for i in range(blocks[-1].outputs)),
    )
    made.__dict__["engine"] = ChainEngine(made.blocks, DT, compiled=False)
    return made


@pytest.fixture(scope="module")
def chain():
    return plain(parse_chain("poly2 | oe(3,3,1) | poly3"), rng=np.random.default_rng(3))


def test_a_linear_system_is_what_small_steps_of_the_chain_do(chain):
    point, linear = operating_point(chain, 0.3), linearise_chain(chain, 0.3)
    _, predicted = linear.step_response(3.0)
    u, small = np.full((len(predicted), 1), 0.3), 1e-6
    high, low = (chain.simulate(u + s * small, point.state) for s in (1.0, -1.0))
    assert np.max(np.abs((high - low) / (2.0 * small) - predicted)) < 1e-8


def test_gain_and_frequency_response_are_the_slope_of_the_static_curve_and_a_driven_sine(chain):
    linear = linearise_chain(chain, 0.3)
    levels, outputs = static_curve(chain, 0.3 - 1e-5, 0.3 + 1e-5, 3)
    slope = (outputs[2, 0] - outputs[0, 0]) / (levels[2] - levels[0])
    assert linear.gain()[0, 0] == pytest.approx(slope, rel=1e-6)
    assert linear.frequency_response(0.0)[0, 0, 0] == pytest.approx(linear.gain()[0, 0])
    t = DT * np.arange(4000)
    y = linear.simulate(np.cos(2.0 * np.pi * 0.4 * t))[2000:, 0]  # 40 whole periods
    found = 2.0 * np.mean(y * np.exp(-2j * np.pi * 0.4 * t[2000:]))
    assert found == pytest.approx(linear.frequency_response(0.4)[0, 0, 0], rel=1e-9)


def test_poles_are_those_of_the_linear_block(chain):
    shown = {name: value for name, value, _ in chain.blocks[1].describe_numbers(chain.split()[1])}
    constants = linearise_chain(chain, 0.0).time_constants()
    assert np.min(np.abs(constants - shown["tau"])) < 1e-9


BRANCHED = ("bouc-wen", "duhem", "heated-duhem")
"""Blocks that go up and down along different curves, however small the change."""


@pytest.mark.parametrize("name", sorted(set(BLOCKS.names()) - set(BRANCHED)))
def test_a_block_is_linearised_exactly(name):
    """At rest: one sample under a small change, and the sample after it."""
    made, u, small = *_example(name), 1e-6
    linear = linearise_chain(made, u)
    for i, step in enumerate(small * np.eye(len(u))):
        rows = [np.array([u + s * step, u]) for s in (1.0, -1.0)]
        high, low = (made.simulate(one, linear.state.copy()) for one in rows)
        expected = [linear.d[:, i], linear.c @ linear.b[:, i]]
        assert np.allclose((high - low) / (2.0 * small), expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("name", BRANCHED)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_block_of_two_branches_is_linearised_along_the_push(name, sign):
    made, u = _example(name)
    small = sign * 1e-6 * np.eye(len(u))[0]
    linear = linearise_chain(made, u, push=small)
    rows = np.array([u + small, u + small])
    change = made.simulate(rows, linear.state.copy()) - linear.outputs
    expected = linear.simulate(np.tile(small, (2, 1)))
    assert np.allclose(change[0], expected[0], rtol=1e-4, atol=1e-12)


def _example(name):
    block = BLOCKS[name]()
    return plain([block]), np.random.default_rng(5).uniform(0.2, 0.4, block.inputs)


def test_plays_stand_still_at_rest_and_follow_a_push_after_a_rise():
    ramp = Sampled("ramp", DT, np.linspace(0.0, 1.0, 50), np.zeros(50), ("u",), ("y",))
    blocks = build_untrained(parse_chain("pi(3) | poly1"), ramp).blocks
    made, rise = plain(blocks), np.linspace(0.0, 0.6, 31)
    at_rest, up, down = (
        linearise_chain(made, 0.6, history, push).gain()[0, 0]
        for history, push in ((None, 1e-6), (rise, 1e-6), (rise, -1e-6))
    )
    path = np.concatenate([np.linspace(0.0, 1.0, 11), np.linspace(0.9, 0.0, 10)])
    y = made.simulate(path)
    steepest = (y[10, 0] - y[9, 0]) / (path[10] - path[9])
    assert up == pytest.approx(steepest) and up > 1.5 * at_rest
    assert down == pytest.approx(at_rest)
    assert linearise_chain(made, 0.6).standing == 3
    assert np.max(y[10:, 0] - y[10::-1, 0]) > 0.05, "the loop must be open"


def test_states_that_take_no_part_do_not_spoil_the_gain():
    held = LinearSystem(
        np.diag([1.0, 0.5]),
        np.array([[0.0], [1.0]]),
        np.array([[1.0, 1.0]]),
        np.zeros((1, 1)),
        DT,
        np.zeros(1),
        np.zeros(2),
        np.zeros(1),
    )
    assert held.standing == 1 and held.gain()[0, 0] == pytest.approx(2.0)
    with pytest.raises(ParameterError, match="integrates"):
        replace(held, b=np.ones((2, 1))).gain()
    with pytest.raises(ParameterError, match="half the sample rate"):
        held.frequency_response(11.0)


def test_what_does_not_fit_is_refused(chain, c_compiler):
    with pytest.raises(InputError, match="takes 1 finite inputs"):
        linearise_chain(chain, [0.1, 0.2])
    with pytest.raises(InputError, match="at least 2 points"):
        static_curve(chain, 0.0, 1.0, 1)
    slow = plain(parse_chain("oe(1,1,1)"), np.array([14.0]))
    slow.__dict__["engine"] = ChainEngine(slow.blocks, DT)
    with pytest.raises(SolveError, match="does not reach a steady state"):
        linearise_chain(slow, 1.0, np.zeros(2))
