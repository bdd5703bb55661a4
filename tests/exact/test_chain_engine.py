"""The engine of chains: derivatives, tiles, chunks, taps, initial states, with and without C."""

import numpy as np
import pytest

from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.native_columns import TILE

RNG = np.random.default_rng(3)
INTERVAL = 0.01
BLOCKS = (
    Polynomial(degree=2, low=0.0, high=1.0, offset="no"),
    TransferFunction(nb=3, nf=3, nk=1),
    Polynomial(degree=3, low=0.0, high=1.0),
)
TAPS = ((1, 0), (2, 0))
INPUT = RNG.uniform(0.0, 1.0, (3 * TILE + 7, 1))
THETA = np.concatenate([block.sample_parameters(RNG, 10.0, INTERVAL) for block in BLOCKS])


def engine(compiled: bool) -> ChainEngine:
    return ChainEngine(BLOCKS, INTERVAL, TAPS, compiled)


@pytest.fixture(params=[True, False], ids=["c", "plain"])
def run(request: pytest.FixtureRequest) -> ChainEngine:
    if request.param:
        request.getfixturevalue("c_compiler")
    return engine(request.param)


def differences(run: ChainEngine, theta: np.ndarray, state: np.ndarray | None = None) -> np.ndarray:
    """Central differences of the outputs."""
    columns: list[np.ndarray] = []
    for i in range(len(theta)):
        away = np.zeros(len(theta))
        away[i] = 1e-6
        ends = [
            run.simulate(theta + sign * away, INPUT, None if state is None else state.copy()) for sign in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.stack(columns, axis=2)


def worst(found: np.ndarray, expected: np.ndarray) -> float:
    scale = np.abs(expected).max(axis=(0, 1)) + 1e-12
    return float((np.abs(found - expected).max(axis=(0, 1)) / scale).max())


def test_derivatives_are_those_of_differences(run: ChainEngine) -> None:
    y, slopes = run.jacobian(THETA, INPUT)
    np.testing.assert_allclose(y, run.simulate(THETA, INPUT), rtol=0, atol=1e-14)
    assert worst(slopes, differences(run, THETA)) < 1e-7


def test_an_output_does_not_depend_on_later_blocks(run: ChainEngine) -> None:
    _, slopes = run.jacobian(THETA, INPUT)
    after = len(THETA) - len(BLOCKS[2].numbers())
    assert np.all(slopes[:, 0, after:] == 0.0)
    assert np.any(slopes[:, 1, after:] != 0.0)


def test_derivatives_with_respect_to_the_initial_state(run: ChainEngine) -> None:
    away = 0.1 * RNG.normal(size=run.plan.states)
    start = run.rest(THETA, INPUT[0], away)
    _, slopes = run.jacobian(THETA, INPUT, start)
    assert slopes.shape[2] == run.plan.states + len(THETA)
    for k in range(run.plan.states):
        step = np.zeros(run.plan.states)
        step[k] = 1e-6
        ends = [run.simulate(THETA, INPUT, start.state + s * step) for s in (1.0, -1.0)]
        noise = 1e-9 * np.abs(ends[0]).max()  # of differences: rounding over the step
        np.testing.assert_allclose(slopes[:, :, k], (ends[0] - ends[1]) / 2e-6, 1e-7, noise)


def test_rest_depends_on_the_numbers_too(run: ChainEngine) -> None:
    slopes = run.rest(THETA, INPUT[0]).slopes
    for i in range(len(THETA)):
        away = np.zeros(len(THETA))
        away[i] = 1e-6
        ends = [run.rest(THETA + s * away, INPUT[0]).state for s in (1.0, -1.0)]
        np.testing.assert_allclose(slopes[:, i], (ends[0] - ends[1]) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("chunk", [1, TILE - 1, TILE + 1])
def test_chunks_do_not_matter(run: ChainEngine, chunk: int) -> None:
    whole, slopes = run.jacobian(THETA, INPUT)
    parts = list(run.sensitivities(THETA, INPUT, chunk=chunk))
    np.testing.assert_allclose(np.concatenate([p.outputs for p in parts]), whole, atol=1e-14)
    np.testing.assert_allclose(np.concatenate([p.slopes for p in parts]), slopes, atol=1e-13)
    assert parts[-1].rows.stop == len(INPUT)


@pytest.mark.usefixtures("c_compiler")
def test_c_does_what_plain_python_does() -> None:
    for found, expected in zip(engine(True).jacobian(THETA, INPUT), engine(False).jacobian(THETA, INPUT), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-13)


def test_a_run_goes_on_from_the_state_it_reached(run: ChainEngine) -> None:
    state = run.rest(THETA, INPUT[0]).state
    halves = [run.simulate(THETA, part, state) for part in (INPUT[:50], INPUT[50:])]
    np.testing.assert_allclose(np.concatenate(halves), run.simulate(THETA, INPUT), atol=1e-14)
