"""Operating points, linear plants on both branches, and regulators.

Sources of truth: heat balances, the plant itself a little pushed, Riccati equations with closed
forms, and costs that any other gains raise.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import problem_a
from scipy.linalg import solve_discrete_lyapunov

from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.controllers.state_feedback import StateFeedback
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.synthesis.linear import Readings, average_plants, linearise_plant, realise_readings
from martensite.control.synthesis.lqr import LqrSizes, Regulator, augment_plant, design_regulator, solve_riccati
from martensite.identify.chains.linear_system import LinearSystem
from martensite.kernels import floats
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.compiled import bind_system
from martensite.simulate.operating_point import Direction, SteadyPoint, find_operating_level, find_operating_point

PERIOD, LEVEL = 0.02, 3e-3
PLANT = problem_a()
BRANCHES = ("heating", "cooling")
pytestmark = pytest.mark.usefixtures("c_compiler")


@cache
def point(direction: Direction) -> SteadyPoint:
    return find_operating_level(PLANT, LEVEL, "position", 0.0, 3.0, direction=direction)


@cache
def linear(direction: str) -> LinearSystem:
    return linearise_plant(point(direction), PERIOD)


@cache
def design(direction: str = "cooling") -> Regulator:
    return design_regulator(readings(direction), "position", LqrSizes((5e-4,), 5e-4, 1.0))


def readings(direction: str, *states: str) -> Readings:
    return realise_readings(linear(direction), states or ("position",))


# ---------------------------------------------------------------- operating points


@pytest.mark.parametrize("direction", BRANCHES)
def test_a_plant_rests_where_it_should(direction):
    """At the level, with as much heat in as out."""
    found = point(direction)
    assert found.outputs["position"] == pytest.approx(LEVEL, abs=1e-6)
    assert found.outputs["heat_loss"] == pytest.approx(found.outputs["power"], rel=1e-6)


def test_hysteresis_has_two_signals_for_one_level():
    up, down = (point(direction) for direction in BRANCHES)
    assert up.signal > down.signal + 0.3
    assert up.outputs["temperature"] > down.outputs["temperature"] + 20.0
    assert find_operating_point(PLANT, up.signal).outputs == pytest.approx(up.outputs)


def test_what_is_not_there_is_refused():
    with pytest.raises(ParameterError, match=r"never at 0\.5"):
        find_operating_level(PLANT, 0.5, "position", 0.0, 3.0)
    with pytest.raises(InputError, match=r"No output named `positon`.*`position`"):
        find_operating_level(PLANT, 0.5, "positon", 0.0, 3.0)
    with pytest.raises(InputError, match="needs `high`"):
        find_operating_point(PLANT, 1.0, direction="cooling")
    with pytest.raises(InputError, match="No direction named `up`"):
        wrong: Any = "up"
        find_operating_point(PLANT, 1.0, direction=wrong)
    with pytest.raises(InputError, match="No drive named `current`"):
        find_operating_point(PLANT, 1.0, drive="current")
    with pytest.raises(InputError, match="period above 0 s"):
        linearise_plant(point("heating"))


# ---------------------------------------------------------------- linear plants


def pushed(found: SteadyPoint, share: float, samples: int) -> np.ndarray:
    """Positions under a signal that is changed by a share of itself, less that at rest [m]."""
    functions, size = bind_system(PLANT)
    state, signal, y = tuple(found.state.tolist()), found.signal * (1.0 + share), []
    place = list(PLANT.outputs()).index("position")
    for _ in range(samples):
        y.append(functions["observe"](*state, signal)[place])
        state = functions["step"](*state, signal, PERIOD)[:size]
    return np.array(y) - found.outputs["position"]


@pytest.mark.parametrize(("direction", "way"), [("heating", 1.0), ("cooling", -1.0)])
def test_a_linear_plant_does_what_the_plant_does_on_its_branch(direction, way):
    """And not what it does the other way: there nothing transforms at first."""
    share, found = way * 2e-4, point(direction)
    expected = pushed(found, share, 100)
    u = np.full(100, share * found.signal)
    for states in (("position",), ("temperature", "position")):
        slim = readings(direction, *states)
        assert slim.residual < 1e-9
        y = slim.linear.simulate(u)[:, states.index("position")]
        np.testing.assert_allclose(y, expected, atol=0.02 * np.abs(expected).max())
    turned = pushed(found, -share, 100)
    assert np.abs(turned).max() < 0.05 * np.abs(expected).max()


def test_readings_that_are_no_states_are_told():
    """The position says all that moves; the drop of a current is no state at all."""
    with pytest.raises(InputError, match="`current` jumps with the signal"):
        readings("heating", "current")
    with pytest.raises(InputError, match="No output named `speed`"):
        readings("heating", "speed")


def test_states_that_are_left_out_are_noticed():
    """Two tanks in series: the second alone does not say what it will do."""
    a = np.array([[0.9, 0.0], [0.1, 0.8]])
    tanks = LinearSystem(
        a,
        np.array([[0.1], [0.0]]),
        np.eye(2),
        np.zeros((2, 1)),
        1.0,
        np.zeros(1),
        np.zeros(2),
        np.zeros(2),
        ("u",),
        ("one", "two"),
    )
    whole = realise_readings(tanks, ("one", "two"))
    assert whole.residual < 1e-12
    assert whole.linear.a == pytest.approx(a)
    turned = realise_readings(tanks, ("two", "one")).linear
    assert turned.a == pytest.approx(a[::-1, ::-1])
    assert realise_readings(tanks, ("two",)).residual > 0.01


def test_the_mean_of_both_branches_lies_between():
    up, down = (readings(direction).linear for direction in BRANCHES)
    both = average_plants([readings(direction) for direction in BRANCHES]).linear
    assert both.b == pytest.approx(0.5 * (up.b + down.b))
    assert min(up.inputs, down.inputs) < both.inputs < max(up.inputs, down.inputs)


# ---------------------------------------------------------------- regulators


def test_the_integrator_has_the_golden_ratio():
    """P = P - P²/(1 + P) + 1."""
    one = np.ones((1, 1))
    golden = 0.5 * (1.0 + 5.0**0.5)
    assert solve_riccati(one, one, one, one) == pytest.approx(np.array([[golden / (1.0 + golden)]]))


def test_the_double_integrator_has_its_printed_gains():
    """A = [[1, 1], [0, 1]], B = [0, 1], Q = diag(1, 0), R = r: z⁴ - 4z³ + (6 + 1/r)z² - 4z + 1.

    The poles inside the unit circle are those of the closed loop (symmetric root locus).
    """
    a, b, r = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), 2.0
    k = solve_riccati(a, b, np.diag([1.0, 0.0]), np.array([[r]]))
    roots = np.roots([1.0, -4.0, 6.0 + 1.0 / r, -4.0, 1.0])
    wanted = np.sort_complex(roots[np.abs(roots) < 1.0])
    assert np.sort_complex(np.linalg.eigvals(a - b @ k)) == pytest.approx(wanted)


def cost(regulator: Regulator, gains: np.ndarray, sizes: LqrSizes) -> float:
    """Of all starts together, under u = -gains x."""
    a, b, _ = augment_plant(regulator.linear, "position")
    q = np.diag(np.array([*sizes.states, sizes.integral]) ** -2.0)
    closed, k = a - b @ gains[None], gains[None]
    weight = q + k.T @ k * sizes.signal**-2.0
    return float(np.trace(solve_discrete_lyapunov(closed.T, weight)))


@pytest.mark.parametrize("direction", BRANCHES)
def test_any_other_gains_cost_more(direction):
    sizes, found = LqrSizes((5e-4,), 5e-4, 1.0), design(direction)
    gains = np.array([*found.gains, -found.Ki])
    assert np.abs(found.poles()).max() < 1.0
    for k in range(2):
        for factor in (0.9, 1.1):
            other = gains.copy()
            other[k] *= factor
            assert cost(found, other, sizes) > cost(found, gains, sizes)


def test_the_prefilter_needs_no_integral_to_get_there():
    """On the linear plant, where the integral stays 0."""
    found = design()
    slim, k, x = found.linear, found.gains[0], np.zeros(1)
    for _ in range(2000):
        x = slim.a @ x + slim.b[:, 0] * (found.prefilter * 1e-4 - k * x[0])
    assert x[0] == pytest.approx(1e-4, rel=1e-6)


def test_sizes_and_names_must_fit():
    with pytest.raises(ParameterError, match="1 states and 2 sizes"):
        design_regulator(readings("heating"), "position", LqrSizes((1.0, 1.0), 1.0, 1.0))
    with pytest.raises(ParameterError, match="must be above 0"):
        design_regulator(readings("heating"), "position", LqrSizes((0.0,), 1.0, 1.0))
    with pytest.raises(ParameterError, match="`force` is no state"):
        design_regulator(readings("heating"), "force", LqrSizes((1.0,), 1.0, 1.0))
    with pytest.raises(ParameterError, match="1 states, but 2 names"):
        design().controller(0.0, 6.0, reference=Constant(level=1.0), names=("a", "b"))
    with pytest.raises(SolveError, match="makes the plant stable"):
        solve_riccati(np.array([[2.0]]), np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1)))


# ---------------------------------------------------------------- on a bench

STEPS = Table(times=(0.0, 10.0, 10.02, 20.0, 20.02, 30.0), values=(3e-3, 3e-3, 4e-3, 4e-3, 2.5e-3, 2.5e-3))


def run(controller, duration: float = 30.0, runtime: str = "c"):
    bench = Bench(plant=PLANT, period=PERIOD, controllers=Controllers(drive=controller))
    samples = round(duration / PERIOD) + 1
    return simulate(bench, {"reference": STEPS}, duration, samples=samples, runtime=runtime)


def test_a_regulator_holds_a_plant_on_both_branches():
    found = run(design().controller(0.0, 6.0, reference=STEPS))
    y, r = (np.array(found[name]) for name in ("position", "reference"))
    for second in (9.9, 19.9, 29.9):
        k = round(second / PERIOD)
        assert y[k] == pytest.approx(r[k], abs=0.15e-3)
    slow = Pid(measured="position", reference=STEPS, Kp=300.0, Ki=100.0, law=PidLaw(high=6.0))
    other = np.array(run(slow)["position"])
    assert np.mean(np.abs(y - r)[300:]) < 0.5 * np.mean(np.abs(other - r)[300:])


def test_its_answer_is_the_equation():
    controller = StateFeedback(
        measured="y",
        reference=Constant(level=1.0),
        states=("y", "estimated.T"),
        gains=(2.0, 0.1),
        at=(1.0, 300.0),
        signal=3.0,
        level=1.0,
        prefilter=4.0,
        Ki=0.5,
        low=0.0,
        high=10.0,
    )
    assert controller.reads() == ("y", "y", "estimated.T")
    seen = {"y": 1.5, "estimated.T": 310.0}
    signal, memory = controller.answer(floats, (0.2,), 2.0, seen, 0.1)
    assert memory[0] == pytest.approx(0.25)
    assert signal == pytest.approx(3.0 + 4.0 * 1.0 - 2.0 * 0.5 - 0.1 * 10.0 + 0.5 * 0.25)


@pytest.mark.parametrize(("reference", "limit"), [(100.0, 1.0), (-100.0, 0.0)])
def test_the_integral_stops_at_a_limit(reference, limit):
    controller = StateFeedback(measured="y", reference=Constant(level=0.0), gains=(1.0,), Ki=1.0)
    signal, memory = controller.answer(floats, (0.0,), reference, {"y": 0.0}, 1.0)
    assert (signal, memory[0]) == (limit, 0.0)
    _, free = controller.answer(floats, (0.0,), 0.5, {"y": 0.0}, 1.0)
    assert free[0] == 0.5


def test_every_state_has_a_gain():
    with pytest.raises(ParameterError, match="a number for each of the 2 states"):
        StateFeedback(measured="y", reference=Constant(level=0.0), states=("y", "v"), gains=(1.0,))
    with pytest.raises(ParameterError, match="below the largest"):
        StateFeedback(measured="y", reference=Constant(level=0.0), low=1.0)
