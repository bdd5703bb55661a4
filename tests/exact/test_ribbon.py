"""Wires side by side: equal ones are a bundle; what they exchange is conduction in closed form."""

import math
from typing import Any, cast

import numpy as np
import pytest
from builders import hanging_wire

from martensite.actuators.assembly import System
from martensite.actuators.elements.base import Spring
from martensite.actuators.elements.network import ParallelCells, Rest
from martensite.actuators.elements.ribbon import Ribbon
from martensite.actuators.elements.rows import Bundle
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.signals.constant import Constant
from martensite.signals.step import Step
from martensite.simulate.api import simulate

BASE = hanging_wire(h=100.0)
WIRE = cast("Wire", BASE.element)
GAP = 0.027  # [W/(m K)]
LOADS = [BiasSpring(stiffness=2000.0, preload=16.0), DeadWeight(mass=2.0)]


def system(element, mechanism: AbstractMechanism) -> System:
    return BASE.with_parts(element=element, mechanism=mechanism)


def ribbon(**values) -> Ribbon:
    usual: dict[str, Any] = {"wire": WIRE, "heated": 1.0, "distance": 1e-3}
    return Ribbon(**(usual | values))


def pulse(element, mechanism, watts, step=0.02):
    wave = Step(low=0.0, high=watts, at=0.1, until=4.0)
    return simulate(system(element, mechanism), wave, 8.0, step=step, samples=81)


@pytest.mark.parametrize("mechanism", LOADS, ids=["spring", "weight"])
def test_equal_wires_are_a_bundle(mechanism):
    run = pulse(ribbon(heated=2.0), mechanism, 5.0)
    bundle = pulse(Bundle(strand=WIRE, count=2.0), mechanism, 5.0)
    assert bundle.stroke > 1e-3
    assert run["position"] == pytest.approx(bundle["position"], abs=1e-9)
    assert run["temperature"] == pytest.approx(bundle["temperature"], abs=1e-5)
    assert run["resistance"] == pytest.approx(bundle["resistance"], rel=1e-8)


@pytest.mark.parametrize("distance", [0.5e-3, 1e-3, 3e-3])
def test_two_wires_exchange_what_two_cylinders_conduct(distance):
    """Steady and not transforming: two balances with G' = 2π k/acosh(2 D²/d² - 1)."""
    watts, h = 0.3, 100.0
    wires = system(ribbon(distance=distance), DeadWeight(mass=0.5))
    run = simulate(wires, Constant(level=watts), 60.0, step=0.1, samples=3)
    ratio = distance / WIRE.diameter
    between = 2.0 * math.pi * GAP * WIRE.length / math.acosh(2.0 * ratio * ratio - 1.0)
    lost = h * WIRE.surface()
    hot, cold = np.linalg.solve([[lost + between, -between], [-between, lost + between]], [watts, 0.0])
    found = [cell[-1] - BASE.environment.temperature for cell in run.profiles["cell_temperature"]]
    assert found == pytest.approx([hot, cold], rel=1e-6)
    assert found != pytest.approx([watts / lost, 0.0], rel=1e-2)
    assert run["heat_loss"][-1] == pytest.approx(watts, rel=1e-6)


def test_without_exchange_the_others_stay_cold():
    run = pulse(ribbon(wires="4", gap_conductivity=0.0), LOADS[0], 2.5)
    hot, *cold = run.profiles["cell_temperature"]
    assert max(hot) > 350.0
    assert max(max(cell) for cell in cold) == pytest.approx(BASE.environment.temperature, abs=1e-9)


def test_neighbours_are_warmed_one_after_the_other():
    run = pulse(ribbon(wires="4", distance=0.6e-3), LOADS[0], 2.5)
    peaks = [max(cell) for cell in run.profiles["cell_temperature"]]
    assert peaks == sorted(peaks, reverse=True)
    assert peaks[1] > BASE.environment.temperature + 5.0
    assert run["hottest"] == pytest.approx(run.profiles["cell_temperature"][0], rel=1e-12)


def test_a_slack_wire_carries_nothing():
    """Without preload the heated wire lifts the load alone, as if no other were there."""
    load = BiasSpring(stiffness=2000.0, preload=0.0)
    beside = pulse(ribbon(gap_conductivity=0.0), load, 2.5)
    alone = pulse(WIRE, load, 2.5)
    assert beside["position"] == pytest.approx(alone["position"], abs=1e-9)
    assert beside.stroke > 2e-3


class TestSideBySide:
    def test_the_whole_is_where_the_forces_add(self):
        free, soft = [0.0, 1e-3, 2e-3, 5e-3], [1e-4, 2e-4, 1e-4, 3e-4]
        for force in (0.0, 3.0, 12.0, 25.0, 200.0):
            whole = ParallelCells().whole(floats, free, soft, force)
            e = whole.free + whole.compliance * force
            shares = [max((e - f) / c, 0.0) for f, c in zip(free, soft, strict=True)]
            assert sum(shares) == pytest.approx(force, abs=1e-9)
            own = [Spring(*pair) for pair in zip(free, soft, strict=True)]
            carried = [ParallelCells().force_share(floats, one, whole, force) for one in own]
            assert carried == pytest.approx(shares, abs=1e-12)

    @pytest.mark.parametrize("force", [[9.0, 4.0, 7.0], [20.0, 0.0, 0.0]], ids=["all taut before", "one taut before"])
    def test_a_cell_and_the_rest_are_the_whole(self, force):
        """A wire that was slack before and pulls now is part of the rest."""
        free, soft = [0.0, 1e-4, 2e-4], [1e-4, 2e-4, 1e-4]
        whole = ParallelCells().whole(floats, free, soft, sum(force))
        offsets, slopes = ParallelCells().rests(floats, free, soft, force)
        for i in range(3):
            rest = Rest(offsets[i], slopes[i])
            joined = ParallelCells().combine_springs(rest, Spring(free[i], soft[i]))
            assert tuple(joined) == pytest.approx(tuple(whole), rel=1e-12)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"heated": 3.0}, "a whole number of at most 2"),
        ({"heated": 1.5}, "but is 1.5"),
        ({"distance": 0.2e-3}, "above the diameter"),
        ({"wires": "5"}, "Valid: `2`"),
        ({"wire": Bundle(strand=WIRE, count=2.0)}, "must be an object of the class `Wire`, but is `Bundle`"),
    ],
)
def test_what_cannot_be_is_one_sentence(values, sentence):
    with pytest.raises(ParameterError, match=sentence):
        ribbon(**values)
