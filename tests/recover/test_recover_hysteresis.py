"""Chains with hysteresis are found again from their own outputs with noise.

A record of steps and ramps that turn back at many levels, 1 % of noise, and another record that
no fit has seen: there the outputs without noise are reproduced to 99 %.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.estimate import ChainEstimate, Options, estimate_chain
from martensite.identify.chains.scores import fit_percent
from martensite.signals.sampling.sampled import Sampled

DT = 0.1
NOISE = 0.01


def excitation(seed: int, samples: int = 1500) -> np.ndarray:
    """Ramps of several speeds between turning points in 20 … 100, and holds; starts at rest."""
    rng = np.random.default_rng(seed)
    x, made = 20.0, [np.full(20, 20.0)]
    upward = True
    while sum(map(len, made)) < samples:
        turn = rng.uniform(x, 100.0) if upward else rng.uniform(20.0, x)
        turn = 100.0 if len(made) == 1 else turn
        made += [np.linspace(x, turn, int(rng.integers(5, 60))), np.full(int(rng.integers(1, 20)), turn)]
        x, upward = turn, not upward
    return np.concatenate(made)[:samples]


def record(truth: Chain, seed: int, noise: float) -> Sampled:
    u = excitation(seed)
    y = truth.simulate(u)
    y = y + noise * y.std() * np.random.default_rng(seed + 100).standard_normal(y.shape)
    return Sampled(f"record {seed}", DT, u, y, ("u",), ("y",))


def blank(seed: int) -> Sampled:
    u = excitation(seed)
    return Sampled("blank", DT, u, np.zeros(len(u)), ("u",), ("y",))


def truth_of(blocks: str | tuple[AbstractBlock, ...], parts: list[list[float]]) -> Chain:
    made = parse_chain(blocks) if isinstance(blocks, str) else blocks
    chain = build_untrained(made, blank(1))
    return chain.with_theta(np.concatenate(parts))


def found_again(truth: Chain, text: str, options: Options) -> tuple[ChainEstimate, float]:
    """What is estimated, and its fit [%] to the truth on a record that it has not seen."""
    made = estimate_chain(text, record(truth, 1, NOISE), options)
    other = record(truth, 2, 0.0)
    fit = fit_percent(other.outputs, made.chain.simulate(other))
    return made, float(fit[0])


WEIGHTS = np.array([0.2, 0.02, 0.4, 0.25, 0.05, 0.05, 0.03])
HAMMERSTEIN = "pi(6,positive,even) | gain | oe(2,2,1)"


def hammerstein() -> Chain:
    logits = np.log(WEIGHTS[1:] / WEIGHTS[0])
    return truth_of(HAMMERSTEIN, [list(logits), [3.0, -1.5], [np.log(1.5), np.log(0.6), -0.4]])


def test_plays_before_a_linear_system(c_compiler: str) -> None:
    truth = hammerstein()
    made, fit = found_again(truth, HAMMERSTEIN, Options(starts=3, refined=1, iterations=60))
    assert fit > 99.0
    blocks: list[Any] = [made.chain.blocks[0], truth.blocks[0]]
    own = [made.chain.split()[0], truth.split()[0]]
    plays, meant = (block.operator(theta) for block, theta in zip(blocks, own, strict=True))
    assert plays.thresholds == pytest.approx(meant.thresholds, rel=1e-9)
    assert np.abs(np.array(plays.weights) - WEIGHTS).max() < 0.03
    x = np.linspace(20.0, 80.0, 200)
    assert np.abs(plays.inverse().simulate(meant.simulate(x)) - x).max() < 0.5
    omega, zeta = np.exp(made.chain.split()[2][:2])
    assert omega == pytest.approx(1.5, rel=0.02)
    assert zeta == pytest.approx(0.6, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_preisach_after_a_linear_system(c_compiler: str, seed: int) -> None:
    text = "oe(1,1,1) | preisach(4,6)"
    chain = build_untrained(parse_chain(text), blank(1))
    preisach = chain.blocks[1]
    own = preisach.sample_parameters(np.random.default_rng(seed), 150.0, DT)
    truth = chain.with_theta(np.concatenate([[np.log(2.0)], own]))
    made, fit = found_again(truth, text, Options())
    assert fit > 99.0
    assert np.exp(made.chain.theta[0]) == pytest.approx(2.0, rel=0.03)


@pytest.mark.slow
def test_plays_of_unknown_reach(c_compiler: str) -> None:
    text = "pi6 | gain | oe(2,2,1)"
    made, fit = found_again(hammerstein(), text, Options(starts=6, refined=2))
    assert fit > 99.0
    assert made.agreeing == 2


@pytest.mark.slow
def test_backlash(c_compiler: str) -> None:
    text = "oe(1,1,1) | play | gain"
    truth = truth_of(text, [[np.log(0.8)], [np.log(0.2)], [3.0, 7.0]])
    made, fit = found_again(truth, text, Options(starts=6, refined=2))
    assert fit > 99.0
    radii = [chain.blocks[1].describe_numbers(chain.split()[1])[0][1] for chain in (made.chain, truth)]
    assert radii[0] == pytest.approx(radii[1], rel=0.03)


@pytest.mark.slow
def test_generalised_plays_before_a_linear_system(c_compiler: str) -> None:
    text = "gpi(3,6) | oe(1,1,1)"
    chain = build_untrained(parse_chain(text), blank(1))
    own = chain.blocks[0].sample_parameters(np.random.default_rng(5), 150.0, DT)
    truth = chain.with_theta(np.concatenate([own, [np.log(2.0)]]))
    made, fit = found_again(truth, text, Options(starts=8, refined=3))
    assert fit > 99.0
    assert np.exp(made.chain.theta[-1]) == pytest.approx(2.0, rel=0.03)


@pytest.mark.slow
def test_plays_stand_in_for_preisach(c_compiler: str) -> None:
    """Another hysteresis, of even density: plays and a curve come close."""
    chain = build_untrained(parse_chain("preisach(8,8) | oe(1,1,1)"), blank(1))
    first: Any = chain.blocks[0]
    truth = chain.with_theta(np.concatenate([first.line(0.1, 0.0), [np.log(0.5)]]))
    assert found_again(truth, "pi12 | poly3 | oe(1,1,1)", Options(starts=4, refined=2))[1] > 98.0
