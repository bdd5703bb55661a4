"""Duhem and Bouc–Wen blocks: exact in steps of any size, bounded, without a clock."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import expit

from martensite.base.errors import MartensiteError
from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.blocks.bouc_wen import BoucWen
from martensite.identify.blocks.duhem import Duhem
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.chain_text import parse_block
from martensite.identify.chains.engine import ChainEngine

TURNS = np.array([-1.0, 0.6, -0.2, 0.5, -0.7, 1.0, 0.1, 0.8, -1.0])
DUHEM = Duhem(logistics=2)
SIMPLE = Duhem(logistics=1, low=20.0, high=120.0)
BOUC_WEN = BoucWen()
BLOCKS = [DUHEM, SIMPLE, BOUC_WEN]
IDS = ["duhem 2", "duhem 1", "bouc-wen"]


def path(block: AbstractBlock, steps: int) -> np.ndarray:
    """Turning points in the range of the block, with as many steps between two of them."""
    places = np.arange((len(TURNS) - 1) * steps + 1) / steps
    r = np.interp(places, np.arange(len(TURNS)), TURNS)
    low, high = block.fixed_values()
    return 0.5 * (low + high) + 0.5 * (high - low) * r


def run(block: AbstractBlock, theta: np.ndarray, x: np.ndarray, dt: float = 1.0) -> np.ndarray:
    return ChainEngine([block], dt).simulate(theta, x[:, None])[:, 0]


def refined(block: AbstractBlock, theta: np.ndarray) -> float:
    """How far the outputs at the turning points depend on the steps between them."""
    far, near = run(block, theta, path(block, 1)), run(block, theta, path(block, 50))
    return float(np.abs(far - near[::50]).max())


def thetas(block: AbstractBlock) -> list[np.ndarray]:
    rng = np.random.default_rng(2)
    return [block.start(), *(block.sample_parameters(rng, 10.0, 0.1) for _ in range(3))]


@pytest.mark.parametrize("block", BLOCKS, ids=IDS)
def test_steps_are_exact(c_compiler: str, block: AbstractBlock) -> None:
    for theta in thetas(block):
        assert refined(block, theta) < 1e-12


@pytest.mark.parametrize("block", BLOCKS, ids=IDS)
def test_time_does_not_matter(c_compiler: str, block: AbstractBlock) -> None:
    x, theta = path(block, 7), thetas(block)[1]
    once = run(block, theta, x)
    assert np.array_equal(run(block, theta, np.repeat(x, 3), 0.01)[::3], once)
    assert np.array_equal(run(block, theta, np.repeat(x, 3), 0.01)[2::3], once)


@pytest.mark.parametrize("block", BLOCKS, ids=IDS)
@pytest.mark.parametrize("size", [3.0, 30.0, 300.0])
def test_any_numbers_are_bounded(c_compiler: str, block: AbstractBlock, size: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        theta = size * rng.normal(size=len(block.numbers()))
        y, slopes = ChainEngine([block], 1.0).jacobian(theta, path(block, 5)[:, None])
        assert np.all(np.isfinite(slopes))
        if isinstance(block, Duhem):
            assert y.min() > -1e-12 and y.max() < 1.0 + 1e-12
        else:
            line, stiffness = expit(theta[0]), np.exp(np.clip(theta[1], -9.0, 9.0))
            yielded = (1.0 - line) / stiffness
            assert np.abs(y[:, 0] - line * path(block, 5)).max() <= yielded + 1e-9


def duhem_rate(theta: np.ndarray, x: float, z: float, up: bool) -> float:
    """dz/dx of the model with one logistic function per branch."""
    centre, width = (theta[0], np.exp(theta[1])) if up else (theta[2], np.exp(theta[3]))
    share = expit((x - centre) / width)
    density = share * (1.0 - share) / width
    return density * ((1.0 - z) / (1.0 - share) if up else z / share)


def bouc_wen_rate(theta: np.ndarray, w: float, up: bool) -> float:
    """dw/dx of the normalised model with n = 1."""
    stiffness, sigma = np.exp(theta[1]), 0.5 + 0.5 * np.exp(theta[2])
    against = np.sign(w) * (1.0 if up else -1.0)
    return stiffness * (1.0 - sigma * abs(w) * against + (sigma - 1.0) * abs(w))


def integrated(rate, start: float) -> np.ndarray:
    """State at the turning points, by a solver of ordinary differential equations."""
    states = [start]
    for a, b in pairwise(TURNS):
        found = solve_ivp(
            lambda x, s, up=b > a: [rate(x, s[0], up)], (a, b), [states[-1]], rtol=1e-9, atol=1e-11, max_step=0.05
        )
        states.append(found.y[0, -1])
    return np.array(states)


def test_duhem_follows_its_equation(c_compiler: str) -> None:
    block = Duhem(logistics=1)
    theta = np.array([0.3, np.log(0.12), -0.1, np.log(0.25)])
    begin = float(expit((-1.0 - theta[0]) / np.exp(theta[1])))
    wanted = integrated(lambda x, z, up: duhem_rate(theta, x, z, up), begin)
    # apart from the guard of 10⁻⁶ in its denominators
    assert run(block, theta, TURNS) == pytest.approx(wanted, abs=1e-4)


def test_bouc_wen_follows_its_equation(c_compiler: str) -> None:
    theta = np.array([-0.5, np.log(4.0), np.log(0.6)])
    w = integrated(lambda x, w, up: bouc_wen_rate(theta, w, up), 0.0)
    line = expit(theta[0])
    wanted = line * TURNS + (1.0 - line) * w / 4.0
    # at rest w is 0 wherever the input is
    assert run(BOUC_WEN, theta, TURNS) == pytest.approx(wanted, abs=1e-6)


def test_histories(c_compiler: str) -> None:
    """From far below and from far above, at rest in between and on the way there."""
    theta = SIMPLE.start()
    above = SIMPLE.with_parts(history="above")
    low, high, between = 20.0 - 500.0, 120.0 + 500.0, np.array([70.0])
    assert run(SIMPLE, theta, between)[0] < run(above, theta, between)[0]
    for block, far in ((SIMPLE, low), (above, high)):
        there = run(block, theta, np.array([far, 70.0]))[-1]
        assert run(block, theta, between)[0] == pytest.approx(there, abs=1e-12)


def test_inner_loops_lie_within_the_outer(c_compiler: str) -> None:
    theta = DUHEM.start()
    x = np.concatenate([np.linspace(-2, 2, 401), np.linspace(2, -2, 401)])
    up, down = np.split(run(DUHEM, theta, x), 2)
    inner = np.concatenate([np.linspace(-2, 0.3, 50), np.linspace(0.3, -0.3, 50), [0.0, 0.2]])
    z = run(DUHEM, theta, inner)[50:]
    assert np.all(z >= np.interp(inner[50:], x[:401], up) - 1e-9)
    assert np.all(z <= np.interp(inner[50:], x[:400:-1], down[::-1]) + 1e-9)


@pytest.mark.parametrize("block", BLOCKS, ids=IDS)
def test_derivatives(c_compiler: str, block: AbstractBlock) -> None:
    theta, x = thetas(block)[2], path(block, 6)[:, None]
    engine = ChainEngine([block], 1.0)
    _, slopes = engine.jacobian(theta, x)
    for i in range(len(theta)):
        away = 1e-6 * np.eye(len(theta))[i]
        found = (engine.simulate(theta + away, x) - engine.simulate(theta - away, x)) / 2e-6
        assert slopes[:, :, i] == pytest.approx(found, abs=2e-8 * np.abs(slopes).max())


def test_texts_and_what_is_shown() -> None:
    assert parse_block("duhem1").text() == "duhem(1)"
    assert parse_block("boucwen").text() == "boucwen"
    with pytest.raises(MartensiteError, match="whole"):
        parse_block("duhem(1.5)")
    rows = {name: value for name, value, _ in SIMPLE.describe_numbers(SIMPLE.start())}
    assert rows["rising_centre"] == pytest.approx(80.0)
    assert rows["rising_width"] == pytest.approx(7.5)
    shares = [value for name, value, _ in DUHEM.describe_numbers(DUHEM.start()) if name.endswith("share")]
    assert shares == pytest.approx([expit(1.0)] * 2)
    assert [v for _, v, _ in BOUC_WEN.describe_numbers(BOUC_WEN.start())] == pytest.approx([0.5, 1 / 3, 1.0])


def test_fractions_take_a_gain(c_compiler: str) -> None:
    """In a chain the fraction is one signal more."""
    blocks = (SIMPLE, parse_block("poly1"))
    theta = np.concatenate([SIMPLE.start(), blocks[1].start()])
    chain = Chain(blocks, theta, 0.1)
    assert chain.simulate(path(SIMPLE, 3)).shape == (25, 1)
