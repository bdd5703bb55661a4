"""Profile likelihood: of a linear model the t interval, and open where the data say nothing.

Sources of truth: NumPy's least squares with one parameter held; the interval from the Jacobian;
a model with one saturating parameter whose profile is known in closed form.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy import stats

from martensite.base.errors import ParameterError, SolveError
from martensite.search.profile import walk_profile
from martensite.search.uncertainty import estimate_uncertainty

X = np.linspace(0.0, 3.0, 20)
COLUMNS = np.stack([X**0, X, X**2], axis=1)
Y = 1.0 + 2.0 * X - 0.5 * X**2 + np.random.default_rng(8).normal(0.0, 0.3, X.size)
BEST = np.linalg.lstsq(COLUMNS, Y, rcond=None)[0]
COST = float(np.sum((COLUMNS @ BEST - Y) ** 2))


def held(fixed: dict[int, float], start: Sequence[float]) -> tuple[list[float], float]:
    """Least squares with some coefficients of the parabola held."""
    values = np.asarray(start, float)
    for place, value in fixed.items():
        assert values[place] == value
    free = [k for k in range(3) if k not in fixed]
    rest = Y - COLUMNS[:, list(fixed)] @ [fixed[k] for k in fixed]
    values[free] = np.linalg.lstsq(COLUMNS[:, free], rest, rcond=None)[0]
    return values.tolist(), float(np.sum((COLUMNS @ values - Y) ** 2))


def bounded(cost):
    """A profile of one parameter alone: cost(x) itself, with the optimum at 1."""
    return lambda fixed, start: ([fixed[0]], cost(fixed[0]))


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("level", [0.68, 0.95])
def test_the_profile_of_a_linear_model_is_the_t_interval(place: int, level: float):
    found = walk_profile(held, BEST.tolist(), COST, place, low=-50.0, high=50.0, freedom=17, level=level)
    errors = estimate_uncertainty(COLUMNS @ BEST - Y, COLUMNS, ["a", "b", "c"], values=BEST.tolist(), scales=[1, 1, 1])
    assert found.interval == pytest.approx(errors.interval("abc"[place], level), abs=1e-7)
    half = 0.5 * (found.interval[1] - found.interval[0])
    curve = [(p.excess / found.limit, (p.at - BEST[place]) / half) for p in found.points]
    for excess, distance in curve:
        assert excess == pytest.approx(distance**2, abs=1e-9)
    assert found.better is None


def test_known_noise_takes_the_normal_quantile():
    found = walk_profile(held, BEST.tolist(), COST, 1, low=-50.0, high=50.0, noise=0.3)
    error = 0.3 * math.sqrt(np.linalg.inv(COLUMNS.T @ COLUMNS)[1, 1])
    z = stats.norm.ppf(0.975)
    assert found.interval == pytest.approx((BEST[1] - z * error, BEST[1] + z * error), abs=1e-7)


@pytest.mark.parametrize("step", [1e-4, 0.05, 1.0, 40.0])
def test_the_first_step_does_not_matter(step: float):
    found, other = (
        walk_profile(held, BEST.tolist(), COST, 1, low=-50.0, high=50.0, freedom=17, step=s) for s in (step, None)
    )
    assert found.interval == pytest.approx(other.interval, abs=1e-7)
    assert len(found.points) < 60


def test_a_curved_profile_is_crossed_where_it_is():
    """cost = (log x)⁴ + 1: unequal sides, log x = ± limit^(1/4)."""
    found = walk_profile(
        bounded(lambda x: math.log(x) ** 4 + 1.0), [1.0], 1.0, 0, low=1e-3, high=1e3, noise=0.2, step=0.01
    )
    far = (0.2 * stats.norm.ppf(0.975)) ** 0.5
    assert found.interval == pytest.approx((math.exp(-far), math.exp(far)), rel=1e-4)
    assert [p.at for p in found.points] == sorted(p.at for p in found.points)


def test_a_side_without_limit_is_open():
    """The cost levels off above: no upper limit within the bounds."""
    found = walk_profile(
        bounded(lambda x: (1.0 / x - 1.0) ** 2 if x < 1.0 else 0.1 * (1.0 - 1.0 / x) ** 2),
        [1.0],
        0.0,
        0,
        low=0.1,
        high=100.0,
        noise=1.0,
        name="E_M",
        unit="1",
    )
    assert found.interval == (pytest.approx(1.0 / 2.95996, rel=1e-3), math.inf)
    assert found.above.reason == "bound"
    assert found.points[-1].at == 100.0
    assert found.sentence == (
        "`E_M` = 1, 95 % interval above 0.3378, open: the data give no upper limit within the bounds (to 100)."
    )


def test_both_sides_open_and_units_in_words():
    flat = walk_profile(
        bounded(lambda x: 0.0), [320.0], 0.0, 0, low=295.0, high=394.15, noise=1.0, name="T_L", unit="K"
    )
    assert flat.interval == (-math.inf, math.inf)
    assert flat.sentence == (
        "`T_L` = 46.85 degC, open: the data give no lower limit within the bounds (to 21.85 "
        "degC), and the data give no upper limit within the bounds (to 121 degC)."
    )
    closed = walk_profile(held, BEST.tolist(), COST, 1, low=-50.0, high=50.0, freedom=17, name="b")
    assert closed.sentence.startswith("`b` = ")
    assert "95 % interval" in closed.sentence
    assert "open" not in closed.sentence


def test_another_scale_gives_the_same_interval():
    """Walked on log x and told as x, and unlike the untold one."""
    given: Any = {"low": math.log(1e-3), "high": math.log(1e3), "noise": 0.2, "step": 0.01}
    told, untold = (
        walk_profile(bounded(lambda u: u**4), [0.0], 0.0, 0, **given, **to)
        for to in list[Any]([{"to_value": math.exp}, {}])
    )
    far = (0.2 * stats.norm.ppf(0.975)) ** 0.5
    assert told.interval == pytest.approx((math.exp(-far), math.exp(far)), rel=1e-4)
    assert untold.interval == pytest.approx((-far, far), rel=1e-4)
    assert told.value == 1.0
    assert [p.at for p in told.points] == [math.exp(p.at) for p in untold.points]


def test_runs_that_fail_leave_a_side_open():
    def failing(fixed: dict[int, float], start: Sequence[float]) -> tuple[list[float], float]:
        if fixed[0] > 1.5:
            raise SolveError("no equilibrium")
        return [fixed[0]], (math.inf if fixed[0] < 0.6 else (fixed[0] - 1.0) ** 2)

    found = walk_profile(failing, [1.0], 0.0, 0, low=0.0, high=9.0, noise=1.0, step=0.2)
    assert found.below.reason == found.above.reason == "failed"
    assert 1.4 < found.above.at <= 1.5
    assert 0.6 <= found.below.at < 0.7
    assert found.sentence.count("fits beyond it fail") == 2


def test_the_number_of_refits_is_kept():
    calls = 0

    def counted(fixed: dict[int, float], start: Sequence[float]) -> tuple[list[float], float]:
        nonlocal calls
        calls += 1
        return [fixed[0]], 1e-9 * (fixed[0] - 1.0) ** 2

    found = walk_profile(counted, [1.0], 0.0, 0, low=-1e9, high=1.0, noise=1.0, step=1e-3, most=6)
    assert calls == 6
    assert found.below.reason == "refits"
    assert found.above.reason == "bound"


def test_a_better_fit_on_the_way_is_reported():
    found = walk_profile(
        bounded(lambda x: (x - 1.0) ** 2 * ((x - 3.0) ** 2 - 0.5)), [1.0], 0.0, 0, low=0.0, high=5.0, noise=3.0
    )
    assert found.better is not None
    assert found.better.at == pytest.approx(3.0, abs=0.5)
    assert "repeat it" in found.sentence


def test_bad_input_is_refused():
    good = BEST.tolist()
    for freedom, noise in ((None, None), (17, 1.0), (None, 0.0)):
        with pytest.raises(ParameterError, match="noise"):
            walk_profile(held, good, COST, 1, low=-50.0, high=50.0, freedom=freedom, noise=noise)
    with pytest.raises(ParameterError, match="C is 0"):
        walk_profile(held, good, 0.0, 1, low=-50.0, high=50.0, freedom=17)
    with pytest.raises(ParameterError, match="no parameter 3"):
        walk_profile(held, good, COST, 3, low=-50.0, high=50.0, freedom=17)
    with pytest.raises(ParameterError, match="within the bounds"):
        walk_profile(held, good, COST, 1, low=40.0, high=50.0, freedom=17)
    with pytest.raises(ParameterError, match="step"):
        walk_profile(held, good, COST, 1, low=-50.0, high=50.0, freedom=17, step=0.0)
