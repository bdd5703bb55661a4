"""Nonlinear feedback: its equation, its rest, its start as a linear system, runs that grow."""

import numpy as np
import pytest

from martensite.base.errors import ParameterError
from martensite.identify.blocks.feedback import Feedback
from martensite.identify.blocks.polynomial import Polynomial
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.identify.operators import sections
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Sampled

RNG = np.random.default_rng(5)
DT = 0.1
U = np.repeat(RNG.uniform(-1.0, 1.0, 30), 4)[:, None]
BLOCK = Feedback(order=2, degree=3)
FREQUENCY, DAMPING = np.log(4.0), np.log(0.2)
BETA = (-0.6, 0.1)


def cubic(c2: float, c3: float, e3: float) -> np.ndarray:
    """Numbers of c₂ r₁² + c₃ r₁³ + e₃ r₂³, r₁ and r₂ the outputs one and two samples back."""
    s = np.sqrt(sections.second_order(floats, FREQUENCY, DAMPING, DT).d2)
    terms = {
        "c20": c2,
        "c11": 0.0,
        "c02": 0.0,
        "c30": c3 + e3,
        "c21": -3 * s * e3,
        "c12": 3 * s**2 * e3,
        "c03": -(s**3) * e3,
    }
    assert BLOCK.numbers()[4:] == tuple(terms)
    return np.array([FREQUENCY, DAMPING, *BETA, *terms.values()])


def recursion(c2: float, c3: float, e3: float) -> np.ndarray:
    """The same by its difference equation, from zero under zero input."""
    d = sections.second_order(floats, FREQUENCY, DAMPING, DT)
    s, u = np.sqrt(d.d2), np.concatenate([np.zeros(2), U[:, 0]])
    y = np.zeros(len(u))
    for t in range(2, len(u)):
        first, second = u[t] - u[t - 1], u[t] - 2 * u[t - 1] + u[t - 2]
        z = u[t] + BETA[0] * first / s + BETA[1] * second / s**2
        z -= c2 * y[t - 1] ** 2 + c3 * y[t - 1] ** 3 + e3 * y[t - 2] ** 3
        y[t] = (2 - d.d1) * y[t - 1] - (1 - d.d1 + d.d2) * y[t - 2] + d.d2 * z
    return y[2:]


@pytest.mark.parametrize("case", [(0.0, 0.0, 0.0), (0.1, 0.5, 0.0), (-0.2, 0.3, 0.4)])
def test_it_spans_polynomials_of_two_past_outputs(case):
    y = ChainEngine([BLOCK], DT, compiled=False).simulate(cubic(*case), U, np.zeros(4))
    assert y[:, 0] == pytest.approx(recursion(*case), abs=1e-12)
    other = recursion(case[0], case[1] + 0.01, case[2])
    assert np.abs(y[:, 0] - other).max() > 1e-4


@pytest.mark.parametrize(
    "block",
    [Feedback(), Feedback(order=1), Feedback(order=3, degree=2, past=1, feedthrough="no")],
    ids=["second", "first", "third"],
)
def test_rest_is_a_fixed_point_and_derivatives_are_those_of_differences(block):
    theta = block.sample_parameters(np.random.default_rng(2), 10.0, DT)
    engine = ChainEngine([block], DT, compiled=False)
    for level in (-0.8, 0.0, 0.7):
        start = engine.rest(theta, np.array([level])).state
        state = start.copy()
        engine.simulate(theta, np.full((1, 1), level), state)
        assert state == pytest.approx(start, abs=1e-12)
    _, slopes = engine.jacobian(theta, U)
    for i in range(len(theta)):
        away = 1e-6 * np.eye(len(theta))[i]
        ends = [engine.simulate(theta + sign * away, U) for sign in (1.0, -1.0)]
        expected = (ends[0] - ends[1]) / 2e-6
        assert np.abs(slopes[:, :, i] - expected).max() <= 1e-7 * max(np.abs(expected).max(), 1.0)


@pytest.mark.parametrize(("feedthrough", "delay"), [("yes", 0), ("no", 1)])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_it_begins_as_a_transfer_function(order, feedthrough, delay):
    block = Feedback(order=order, feedthrough=feedthrough)
    linear = TransferFunction(nb=order + 1 - delay, nf=order, nk=delay)
    theta = linear.sample_parameters(np.random.default_rng(3), 10.0, DT)
    own = block.like(linear, theta, DT)
    y, expected = (
        ChainEngine([one], DT, compiled=False).simulate(numbers, U) for one, numbers in ((block, own), (linear, theta))
    )
    assert y == pytest.approx(expected, abs=1e-9)


def test_another_order_is_refused():
    linear = TransferFunction(nb=2, nf=3, nk=0)
    with pytest.raises(ParameterError, match=r"can begin as `oe\(3,2,0\)`, not as `oe\(2,3,0\)`"):
        BLOCK.like(linear, linear.start(), DT)


def test_orders_are_whole():
    with pytest.raises(ParameterError, match="whole number"):
        Feedback(order=1.5)


def test_a_run_that_grows_without_bound_has_no_finite_cost(c_compiler):
    theta = cubic(0.0, -40.0, 0.0)
    engine = ChainEngine([BLOCK, Polynomial(degree=1)], DT)
    record = Sampled("test", DT, U, np.zeros(len(U)), ("u",), ("y",))
    cost = ResidualSquares(engine, [RecordResidual(record, start="zero")])
    assert cost.value(np.concatenate([theta, [0.0, 1.0]])) == np.inf
    assert np.isfinite(cost.value(np.concatenate([cubic(0.0, 0.4, 0.0), [0.0, 1.0]])))
