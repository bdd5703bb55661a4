"""Chains of blocks that made noisy records are found again: judged on noise-free truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from martensite.base.errors import InputError
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.scores import fit_percent
from martensite.identify.chains.wiener_hammerstein import wiener_hammerstein_starts
from martensite.signals.sampling.sampled import Sampled

pytestmark = pytest.mark.usefixtures("c_compiler")

DT = 0.02
SECOND = [np.log(2.0), np.log(0.6), 0.5]
TRUTHS = {
    "hammerstein": ("poly3 | oe(2,2,1)", [[0.1, 1.0, 0.6, -0.5], SECOND]),
    "wiener": ("oe(1,1,1) | poly3", [[np.log(0.5)], [0.3, 1.0, 0.5, 0.4]]),
    "hammerstein-wiener": ("poly2 | oe(2,2,1) | poly3", [[1.0, 0.4], SECOND, [0.1, 1.0, 0.3, 0.3]]),
    "wiener-hammerstein": ("oe(1,1,1) | poly3 | oe(2,2,1)", [[np.log(0.3)], [0.1, 1.0, 0.6, 0.5], SECOND]),
}
QUICK = Options(starts=4, refined=1, iterations=40)


def _levels(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Random levels of 0.6 s from a rest at 0."""
    u = np.repeat(rng.uniform(-1.0, 1.0, samples // 30 + 1), 30)[:samples, None]
    u[:20] = 0.0
    return u


def _truth(text: str, parts: Sequence[Sequence[float]]) -> Chain:
    ends = np.array([[-1.0], [1.0]])
    chain = build_untrained(parse_chain(text), Sampled("ends", DT, ends, ends, ("u",), ("y",)))
    return chain.with_theta(np.concatenate([np.array(part) for part in parts]))


def _record(truth: Chain, seed: int, samples: int = 2000, missing: float = 0.0) -> Sampled:
    rng = np.random.default_rng(seed)
    u = _levels(rng, samples)
    y = truth.simulate(u)
    y = y + 0.02 * np.std(y) * rng.normal(size=y.shape)
    y[rng.random(len(y)) < missing] = np.nan
    return Sampled(f"record {seed}", DT, u, y, ("u",), ("y",))


def _validated(truth: Chain, found: Chain) -> float:
    u = 0.9 * _levels(np.random.default_rng(99), 1500)
    return float(fit_percent(truth.simulate(u), found.simulate(u))[0])


@pytest.mark.parametrize(
    "name", ["hammerstein", pytest.param("wiener", marks=pytest.mark.slow), "hammerstein-wiener", "wiener-hammerstein"]
)
def test_structure_is_recovered_with_samples_missing(name: str) -> None:
    truth = _truth(*TRUTHS[name])
    found = estimate_chain(TRUTHS[name][0], _record(truth, 1, missing=0.1), QUICK)
    assert _validated(truth, found.chain) >= 99.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hammerstein", "hammerstein-wiener"])
def test_several_records_are_fitted_together(name: str) -> None:
    truth = _truth(*TRUTHS[name])
    records = [_record(truth, seed, 1000) for seed in (2, 3, 4)]
    assert _validated(truth, estimate_chain(TRUTHS[name][0], records, QUICK).chain) >= 99.0


@pytest.mark.slow
@pytest.mark.parametrize("name", list(TRUTHS))
def test_record_that_begins_on_the_move_estimates_its_first_state(name: str) -> None:
    truth = _truth(*TRUTHS[name])
    record = _record(truth, 5, 3000).rows(700)
    options = Options(starts=6, refined=1, iterations=40, start="estimate")
    assert _validated(truth, estimate_chain(TRUTHS[name][0], record, options).chain) >= 99.0


@pytest.mark.slow
def test_prediction_error_beats_simulation_error_under_coloured_noise() -> None:
    truth = _truth(*TRUTHS["hammerstein"])
    rng = np.random.default_rng(8)
    u = _levels(rng, 3000)
    y = truth.simulate(u)
    noise = np.zeros(len(y))
    for t in range(1, len(y)):
        noise[t] = 0.99 * noise[t - 1] + rng.normal()
    y = y + 0.2 * np.std(y) / np.std(noise) * noise[:, None]
    record = Sampled("coloured", DT, u, y, ("u",), ("y",))
    ends = [estimate_chain("poly3 | oe(2,2,1)", record, Options(starts=4, refined=1, noise=order)) for order in (0, 1)]
    fits = [_validated(truth, end.chain) for end in ends]
    assert fits[1] > fits[0]
    assert ends[1].aims[0].whitening[1] == pytest.approx(-0.99, abs=0.01)
    assert len(ends[0].aims[0].whitening) == 1


@pytest.mark.slow
def test_poles_are_shared_out_as_they_belong() -> None:
    text, parts = TRUTHS["wiener-hammerstein"]
    truth = _truth(text, parts)
    record = _record(truth, 6)
    start = wiener_hammerstein_starts(build_untrained(parse_chain(text), record), record, 2)[0]
    np.testing.assert_allclose(start.split()[0], parts[0], atol=0.2)
    np.testing.assert_allclose(start.split()[2][:2], parts[2][:2], atol=0.2)


def test_a_search_begins_with_a_simpler_chain() -> None:
    truth = _truth(*TRUTHS["hammerstein"])
    record = _record(truth, 1)
    simple = estimate_chain("poly1 | oe(1,1,1)", record, Options(starts=1, iterations=20)).chain
    options = Options(starts=0, refined=1, iterations=60, begin=(simple,))
    assert _validated(truth, estimate_chain("poly3 | oe(2,2,1)", record, options).chain) >= 99.0
    own = Options(starts=0, refined=1, iterations=1, begin=(truth,))
    assert _validated(truth, estimate_chain("poly3 | oe(2,2,1)", record, own).chain) >= 99.5
    with pytest.raises(InputError, match="cannot begin with"):
        estimate_chain("oe(2,2,1)", record, own)
