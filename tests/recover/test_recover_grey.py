"""Grey models find the truth again: heat, latent heat and hysteresis from noisy records."""

import numpy as np
import pytest

from martensite.identify.blocks.bouc_wen import BoucWen
from martensite.identify.blocks.duhem import Duhem
from martensite.identify.blocks.gain import Gain
from martensite.identify.blocks.heated_duhem import HeatedDuhem
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.estimate import ChainEstimate, Options, estimate_chain
from martensite.signals.sampling.sampled import Sampled

DT = 0.1
SIGMA = (0.3, 0.05)
"""Noise of temperature [K] and position [mm]."""
TRUTH = HeatedDuhem(
    ambient=21.0,
    gain=6.0,
    time_constant=8.0,
    latent=35.0,
    rising=60.0,
    falling=37.0,
    sensor_gain=0.6,
    sensor_lag=0.4,
    stroke=7.0,
    stroke_lag=0.1,
)
NAMES = TRUTH.numbers()


def pulses(seed: int, count: int) -> np.ndarray:
    """Pulses to different heights, not always down to rest, after some rest."""
    rng = np.random.default_rng(seed)
    parts = [np.zeros(20)]
    for _ in range(count):
        parts += [np.full(rng.integers(50, 90), rng.uniform(12.0, 30.0))]
        parts += [np.full(rng.integers(80, 200), rng.choice([0.0, 4.0, 7.0]))]
    return np.concatenate(parts)


def record(theta: np.ndarray, seed: int, count: int) -> Sampled:
    u = pulses(seed, count)
    y = Chain((TRUTH,), theta, DT).simulate(u)
    y = y + np.random.default_rng(seed + 100).normal(size=y.shape) * SIGMA
    return Sampled(f"pulses {seed}", DT, u, y, ("u",), ("T", "y"), {"T": "degC", "y": "mm"})


def true_numbers() -> np.ndarray:
    theta = TRUTH.start()
    theta[NAMES.index("resistance")] = 0.1
    return theta


@pytest.fixture(scope="module")
def found(c_compiler: str) -> ChainEstimate:
    """From a start that knows nothing of the truth but the room."""
    data = [record(true_numbers(), 1, 8)]
    return estimate_chain("heated", data, Options(starts=2, refined=1, sigma=SIGMA))


def errors(chain: Chain, data: Sampled) -> np.ndarray:
    """Root mean square of errors over the noise."""
    return np.sqrt(np.mean((chain.simulate(data) - data.outputs) ** 2, axis=0)) / SIGMA


def test_validation_is_near_the_noise(found: ChainEstimate) -> None:
    assert np.all(errors(found.chain, record(true_numbers(), 7, 5)) < 1.05)


def test_what_can_be_told_is_found(found: ChainEstimate) -> None:
    """All but the scale of temperature, which only priors tell."""

    def told(theta: np.ndarray) -> dict[str, float]:
        shown = {name: value for name, value, _ in TRUTH.describe_numbers(theta)}
        seen = shown["sensor_gain"]
        rise = {k: shown[f"{k}_centre1"] - shown["ambient"] for k in ("rising", "falling")}
        return {
            "ambient": shown["ambient"],
            "stroke": shown["stroke"],
            "lag": shown["sensor_lag"],
            "gain": seen * shown["gain"],
            "time": shown["time_constant"],
            "latent": seen * shown["latent"],
            "rising": seen * rise["rising"],
            "falling": seen * rise["falling"],
        }

    wanted, made = told(true_numbers()), told(found.chain.theta)
    assert made == pytest.approx(wanted, rel=0.1)
    assert (made["ambient"], made["stroke"]) == pytest.approx((21.0, 7.0), rel=0.01)


@pytest.mark.parametrize("kind", ["duhem", "bouc-wen"])
def test_operators_are_found_again(c_compiler: str, kind: str) -> None:
    rng = np.random.default_rng(3)
    turns = rng.uniform(20.0, 100.0, 40)
    u = np.interp(np.arange(800) / 20.0, np.arange(40), turns)
    record = Sampled("turns", DT, u, np.zeros(800), ("T",), ("y",))
    block = Duhem(logistics=1) if kind == "duhem" else BoucWen()
    block = block.adapt_to(record.inputs, DT)
    truth = block.start() + 0.3 * rng.normal(size=len(block.start()))
    y = 5.0 * Chain((block,), truth, DT).simulate(record) + 1.0
    spread = 0.01 * float(np.std(y))
    noisy = record.with_outputs(y + spread * rng.normal(size=y.shape))
    fitted = estimate_chain([block, Gain()], noisy, Options(starts=4, refined=1, threads=1))
    assert np.std(fitted.chain.simulate(noisy) - y) < 0.3 * spread
    own = fitted.chain.theta[: len(truth)]
    assert own == pytest.approx(truth, abs=0.1)
