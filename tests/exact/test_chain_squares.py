"""Sums of squares of chains, and the search for their minimum."""

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.search.levenberg_marquardt import Normal, minimise_cost
from martensite.signals.sampling.sampled import Sampled

RNG = np.random.default_rng(5)
SAMPLES = 500


def record(outputs: np.ndarray | None = None) -> Sampled:
    u = np.repeat(np.random.default_rng(1).uniform(0.0, 1.0, SAMPLES // 20), 20)
    y = np.zeros((SAMPLES, 1)) if outputs is None else outputs
    return Sampled("steps", 0.05, u, y, ("u",), ("y",))


@pytest.fixture(scope="module")
def chain() -> Chain:
    made = build_untrained(parse_chain("poly2 | oe(3,3,1) | poly3"), record())
    return made.with_theta(made.theta + 0.1 * RNG.normal(size=len(made.theta)))


@pytest.fixture(scope="module")
def noisy(chain: Chain) -> Sampled:
    y = chain.simulate(record())
    return record(y + 0.02 * RNG.normal(size=y.shape))


def squares(chain: Chain, *aims: RecordResidual, ridge: float = 0.0) -> ResidualSquares:
    return ResidualSquares(chain.engine, aims, ridge, chain.theta)


def check(cost: ResidualSquares, theta: np.ndarray) -> None:
    """Gradient against differences, value against the sum of its parts."""
    normal = cost.normal(theta)
    assert normal.value == pytest.approx(cost.value(theta), rel=1e-12)
    for i in range(len(theta)):
        away = np.zeros(len(theta))
        away[i] = 1e-5
        slope = (cost.value(theta + away) - cost.value(theta - away)) / 2e-5
        size = np.abs(normal.gradient).max()
        assert normal.gradient[i] == pytest.approx(0.5 * slope, rel=1e-4, abs=1e-6 * size)


AR = np.array([1.0, -0.8, 0.2])


@pytest.mark.parametrize("start", ["rest", "zero", "estimate"])
@pytest.mark.parametrize("whitening", [np.ones(1), AR], ids=["white", "coloured"])
def test_gradients(chain: Chain, noisy: Sampled, start: str, whitening: np.ndarray) -> None:
    cost = squares(chain, RecordResidual(noisy, 30, start=start, whitening=whitening), ridge=1e-3)
    theta = cost.extend_parameters(chain.theta)
    check(cost, theta + 0.02 * RNG.normal(size=len(theta)))


def test_missing_and_skipped_samples_do_not_count(chain: Chain, noisy: Sampled) -> None:
    gaps = noisy.outputs.copy()
    gaps[100:150] = np.nan
    wild = noisy.outputs.copy()
    wild[:40] = 1e3
    weights = np.array([2.0])
    counted = [squares(chain, RecordResidual(noisy.with_outputs(y), 40, weights)) for y in (gaps, wild)]
    error = 2.0 * (noisy.outputs - chain.simulate(noisy))[40:]
    assert counted[1].value(chain.theta) == pytest.approx(float(np.sum(error**2)))
    without = np.delete(error, range(60, 110), axis=0)
    assert counted[0].value(chain.theta) == pytest.approx(float(np.sum(without**2)))
    assert counted[0].count == len(without)


def test_records_add_up_and_estimate_states_of_their_own(chain: Chain, noisy: Sampled) -> None:
    halves = noisy.rows(0, 250), noisy.rows(250)
    both = squares(chain, *(RecordResidual(h, weights=np.ones(1), start="estimate") for h in halves))
    assert both.size == len(chain.theta) + 2 * chain.engine.plan.states
    found = minimise_cost(both, both.extend_parameters(chain.theta))
    truth = noisy.outputs[250:]
    assert np.sqrt(found.value / both.count) < 0.025
    run = chain.with_theta(found.theta[: len(chain.theta)])
    free = run.simulate(halves[1], both.initial(found.theta)[1])
    assert np.std(truth - free) < 0.03 < np.std(truth - run.simulate(halves[1]))


def test_parts_are_the_residuals(chain: Chain, noisy: Sampled) -> None:
    cost = squares(chain, RecordResidual(noisy, weights=np.ones(1)))
    found = np.concatenate([part.residuals for _, part in cost.parts(chain.theta)])
    np.testing.assert_allclose(found, noisy.outputs - chain.simulate(noisy), atol=1e-14)


def test_an_unknown_start_is_refused(noisy: Sampled) -> None:
    with pytest.raises(ParameterError, match="rest, zero or estimate, not `warm`"):
        RecordResidual(noisy, start="warm")


class Valley:
    """Rosenbrock's function as residuals, and a number that does nothing."""

    def residuals(self, theta: np.ndarray) -> np.ndarray:
        return np.array([10.0 * (theta[1] - theta[0] ** 2), 1.0 - theta[0]])

    def value(self, theta: np.ndarray) -> float:
        return float(np.sum(self.residuals(theta) ** 2))

    def normal(self, theta: np.ndarray) -> Normal:
        jacobian = np.array([[-20.0 * theta[0], 10.0, 0.0], [-1.0, 0.0, 0.0]])
        r = self.residuals(theta)
        return Normal(self.value(theta), jacobian.T @ r, jacobian.T @ jacobian)


def test_the_search_follows_a_bent_valley() -> None:
    found = minimise_cost(Valley(), np.array([-1.2, 1.0, 7.0]))
    np.testing.assert_allclose(found.theta, [1.0, 1.0, 7.0], atol=1e-6)
    assert found.converged


def test_held_numbers_stay_and_a_limit_is_told() -> None:
    held = minimise_cost(Valley(), np.array([-1.2, 1.0, 0.0]), free=np.array([False, True, True]))
    np.testing.assert_allclose(held.theta, [-1.2, 1.44, 0.0], atol=1e-9)
    assert not minimise_cost(Valley(), np.array([-1.2, 1.0, 0.0]), iterations=2).converged
