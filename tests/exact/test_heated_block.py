"""The block of heat, latent heat and hysteresis: its balance, its rest, its stability."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import expit, logit

from martensite.base.errors import InputError
from martensite.identify.blocks.heated_duhem import MIDDLE, HeatedDuhem
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_block
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.estimate import Options, estimate_chain
from martensite.identify.chains.goals import build_aims, find_expected
from martensite.identify.chains.starts import align_chain
from martensite.signals.sampling.sampled import Sampled

BLOCK = HeatedDuhem(gain=7.0, stroke=9.0)
NAMES = BLOCK.numbers()
PULSES = np.repeat([0.0, 25.0, 0.0, 15.0, 0.0], [10, 70, 60, 80, 80])
"""One per 0.1 s."""


def numbers(**other: float) -> np.ndarray:
    theta = BLOCK.start()
    for name, value in other.items():
        theta[NAMES.index(name)] = value
    return theta


def run(theta: np.ndarray, u: np.ndarray, dt: float, block: HeatedDuhem = BLOCK) -> np.ndarray:
    return ChainEngine([block], dt).simulate(theta, u[:, None])


def rates(theta: np.ndarray, u: float):
    """The equations as they stand, of rise, z and the two lags."""
    t = dict(zip(NAMES, theta, strict=True))
    r = expit(t["loss_logit"])

    def branch(word: str, x: float) -> tuple[float, float]:
        first = expit(t[f"{word}_logit"])
        share, density = 0.0, 0.0
        for part, k in ((first, 1), (1.0 - first, 2)):
            width = np.exp(t[f"log_{word}_width{k}"])
            g = expit((x - t[f"{word}_centre{k}"]) / width)
            share, density = share + part * g, density + part * g * (1.0 - g) / width
        return share, density

    def f(time: float, s: np.ndarray) -> list[float]:
        rise, z, seen, moved = s
        q = np.exp(t["log_gain"]) * u * np.exp(t["resistance"] * z)
        q -= rise * (1.0 - r + r * abs(rise) / MIDDLE)
        share, density = branch("rising" if q > 0 else "falling", rise)
        slope = density * ((1 - z) / (1 - share + 1e-6) if q > 0 else z / (share + 1e-6))
        rate = q / (np.exp(t["log_time_constant"]) * (1.0 + np.exp(t["log_latent"]) * slope))
        lags = np.exp(t["log_sensor_lag"]), np.exp(t["log_stroke_lag"])
        return [rate, slope * rate, (rise - seen) / lags[0], (z - moved) / lags[1]]

    return f


def test_follows_its_equations(c_compiler: str) -> None:
    theta = numbers(resistance=0.1)
    state = ChainEngine([BLOCK], 0.1).rest(theta, PULSES[:1]).state
    wanted = [state]
    for u in PULSES[:-1]:
        found = solve_ivp(rates(theta, float(u)), (0, 0.1), wanted[-1], rtol=1e-7, atol=1e-8)
        wanted.append(found.y[:, -1])
    states = np.array(wanted)
    temperature, position = 23.0 + 0.7 * states[:, 2], 9.0 * states[:, 3]
    errors = []
    for finer in (1, 5):
        y = run(theta, np.repeat(PULSES, finer), 0.1 / finer)[::finer]
        errors.append([np.abs(y[:, 0] - temperature).max(), np.abs(y[:, 1] - position).max()])
    assert errors[0] == pytest.approx([0.0, 0.0], abs=0.5)
    assert np.all(np.array(errors[1]) < 0.25 * np.array(errors[0]))


def test_steps_of_latent_heat_are_stable(c_compiler: str) -> None:
    """Where the latent heat is ten times the heat capacity, and steps are long."""
    theta = numbers(log_latent=np.log(300.0), log_rising_width1=0.0, log_falling_width1=0.0)
    fine, coarse = run(theta, np.repeat(PULSES, 50), 0.002), run(theta, PULSES, 0.1)
    assert np.abs(coarse[:, 1] - fine[::50, 1]).max() < 0.3
    assert np.all(np.diff(coarse[11:80, 1]) >= -1e-12)  # heated, it never turns back


@pytest.mark.parametrize("dt", [0.002, 0.02, 10.0])
@pytest.mark.parametrize("size", [1.0, 5.0, 50.0])
def test_any_numbers_can_be_simulated(c_compiler: str, dt: float, size: float) -> None:
    rng = np.random.default_rng(4)
    engine = ChainEngine([BLOCK], dt)
    for _ in range(10):
        theta = BLOCK.start() + size * rng.normal(size=len(NAMES))
        y, slopes = engine.jacobian(theta, PULSES[:, None])
        assert np.all(np.isfinite(y)) and np.all(np.isfinite(slopes))


@pytest.mark.parametrize("u", [0.0, 4.0, 30.0])
@pytest.mark.parametrize("resistance", [-0.2, 0.0, 0.2])
def test_rest_stays(c_compiler: str, u: float, resistance: float) -> None:
    y = run(numbers(resistance=resistance), np.full(200, u), 0.5)
    assert np.ptp(y, axis=0) == pytest.approx([0.0, 0.0], abs=1e-6)


def test_derivatives(c_compiler: str) -> None:
    theta, engine = numbers(resistance=0.1), ChainEngine([BLOCK], 0.1)
    x = (PULSES + 2.0)[:, None]  # rest is warm, so that it depends on the numbers
    _, slopes = engine.jacobian(theta, x)
    for i in range(len(theta)):
        away = 1e-6 * np.eye(len(theta))[i]
        found = (engine.simulate(theta + away, x) - engine.simulate(theta - away, x)) / 2e-6
        assert slopes[:, :, i] == pytest.approx(found, abs=1e-7 * np.abs(slopes).max())


def rescaled(theta: np.ndarray, s: float) -> np.ndarray:
    """The same model with rises s times as large."""
    made = dict(zip(NAMES, theta, strict=True))
    r = float(expit(made["loss_logit"]))
    part = 1.0 - r + r / s
    made["loss_logit"] = float(logit(r / s / part))
    made["log_time_constant"] -= np.log(part)
    made["log_gain"] += np.log(s / part)
    made["log_latent"] += np.log(s)
    made["sensor_gain"] /= s
    for name in NAMES:
        if "centre" in name:
            made[name] *= s
        if "width" in name:
            made[name] += np.log(s)
    return np.array([made[name] for name in NAMES])


def test_no_record_tells_the_scale_of_temperature(c_compiler: str) -> None:
    theta = numbers(resistance=0.1)
    first = run(theta, PULSES, 0.1)
    assert run(rescaled(theta, 1.3), PULSES, 0.1) == pytest.approx(first, abs=1e-8)
    chain = Chain((BLOCK,), rescaled(theta, 1.3), 0.1)
    centres, weights = find_expected(chain, Options())
    assert weights @ np.abs(chain.theta - centres) > weights @ np.abs(theta - centres)


def record(y: np.ndarray) -> Sampled:
    names = ("T", "y")[: y.shape[1]]
    return Sampled("pulses", 0.1, PULSES, y, ("u",), names)


def test_outputs_and_texts(c_compiler: str) -> None:
    both = run(BLOCK.start(), PULSES, 0.1)
    for k, word in enumerate(("temperature", "position")):
        one = BLOCK.with_parts(gives=word)
        assert np.array_equal(run(BLOCK.start(), PULSES, 0.1, one)[:, 0], both[:, k])
        assert parse_block(f"heated({word})").outputs == 1
        assert one.text() == f"heated({word})"
    assert parse_block("heated").text() == "heated"
    with pytest.raises(InputError, match="position"):
        parse_block("heated(positon)")


def test_start_suits_the_record(c_compiler: str) -> None:
    """The mean input makes the gain, the outputs the stroke."""
    y = run(BLOCK.start(), PULSES, 0.1)
    y[5, 1] = np.nan
    chain = build_untrained([HeatedDuhem(latent=20.0)], record(y))
    shown = {name: value for name, value, _ in chain.blocks[0].describe_numbers(chain.theta)}
    assert shown["gain"] == pytest.approx(50.0 / PULSES.mean())
    assert shown["rising_centre1"] == pytest.approx(65.0 + 23.0)
    found = align_chain(chain, [record(y)])
    own = found.simulate(record(y))[:, 1]
    left = (y[:, 1] - own)[np.isfinite(y[:, 1])]
    assert left @ own[np.isfinite(y[:, 1])] == pytest.approx(0.0, abs=1e-6)
    assert np.flatnonzero(found.theta != chain.theta).tolist() == [NAMES.index("stroke")]


def test_sizes_of_residuals() -> None:
    y = np.column_stack([20.0 + PULSES, 0.1 * PULSES])
    (aim,) = build_aims([record(y)], Options(sigma=(2.0, 0.1)))
    assert aim.scale() == pytest.approx([0.5, 10.0])
    (aim,) = build_aims([record(y)], Options())
    assert aim.scale() == pytest.approx(1.0 / y.std(axis=0))
    for wrong in ((1.0,), (1.0, 0.0)):
        with pytest.raises(InputError, match="above 0 for each of the 2 outputs"):
            build_aims([record(y)], Options(sigma=wrong))


def test_records_must_have_its_signals() -> None:
    y = np.column_stack([20.0 + PULSES, 0.1 * PULSES])
    with pytest.raises(InputError, match="`heated` gives 2 outputs, but record `pulses` has 1: T"):
        estimate_chain("heated", record(y[:, :1]))
    two = Sampled("both", 0.1, y, y, ("u", "v"), ("T", "y"))
    with pytest.raises(InputError, match="takes 1 inputs, but record `both` has 2: u, v"):
        estimate_chain("heated", two)


def test_priors_can_be_left_out() -> None:
    theta = BLOCK.start() + 1.0
    chain = Chain((BLOCK,), theta, 0.1)
    centres, weights = find_expected(chain, Options())
    stroke = NAMES.index("stroke")
    assert weights[stroke] == 0.0 and centres[stroke] == theta[stroke]
    assert centres[0] == BLOCK.start()[0] and weights[0] == 1.0
    centres, weights = find_expected(chain, Options(priors=False))
    assert not weights.any() and np.array_equal(centres, theta)
