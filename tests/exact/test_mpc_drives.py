"""Predictive control of several drives: a pair and a platform of elastic elements, in closed form.

Sources of truth: an elastic element follows its temperature at once, so that a plan with a perfect
model has no error; two against each other turn a pulley of radius R by c (x - y)/(2 R) when they
are x and y kelvin warmer, each of which shortens them by c.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from elastic import REST, machine

from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import ParameterError
from martensite.control.controllers.follower import Follower
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.planning import Price
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.result import Result

R, SHORTER, PERIOD = 8e-3, 1e-3, 0.1
"""Radius [m], shortening per kelvin [m]."""
PAIR = machine(AntagonisticPulley(radius=R, preload=3.0), compliance=4e-4, contraction=SHORTER)
TURN = SHORTER / (2.0 * R)
"""[rad/K]"""
COURSE = Table(times=(0.0, 0.5, 1.0, 2.0), values=(0.0, 0.0, 4.0 * TURN, -4.0 * TURN))


def planned(model: Any = PAIR, **changes: Any) -> Mpc:
    plan: dict[str, Any] = {
        "period": PERIOD,
        "horizon": 0.4,
        "blocks": 4,
        "rounds": 3,
        "low": REST,
        "high": REST + 10.0,
    }
    price = Price(error=0.01 * TURN, change=1e-6)
    plan |= {"measured": "angle", "reference": COURSE, "leads": ("antagonist",), "price": price}
    return Mpc(model=model, **(plan | changes))


def bench(**controllers: Any) -> Bench:
    given = {"protagonist": planned(), "antagonist": Follower(), **controllers}
    return Bench(plant=PAIR, period=PERIOD, substeps=1, controllers=Controllers(**given))


@cache
def run(runtime: str) -> Result:
    return simulate_bench(bench(), 2.0, runtime=runtime)


def test_one_controller_turns_a_pair_both_ways() -> None:
    found = run("floats")
    apart = np.array(found["wanted.protagonist"]) - np.array(found["wanted.antagonist"])
    np.testing.assert_allclose(found["angle"][1:], TURN * apart[:-1], rtol=0.0, atol=1e-9)
    wanted = [COURSE.value(time) for time in found.times]
    assert np.max(np.abs(np.array(found["angle"]) - wanted)[2:]) < 0.05 * TURN
    assert max(found["wanted.protagonist"]) > REST + 3.0 < max(found["wanted.antagonist"])


def test_it_is_the_same_in_c_and_in_a_compiled_loop(c_compiler: None) -> None:
    on_floats, in_c, loop = run("floats"), run("c"), RealtimeStep(bench())
    assert loop.readings == ("angle",)
    rows = [loop.step([angle]) for angle in on_floats["angle"]]
    for k, name in enumerate(("wanted.protagonist", "wanted.antagonist")):
        np.testing.assert_allclose(in_c[name], on_floats[name], rtol=0.0, atol=1e-7)
        np.testing.assert_allclose([row[k] for row in rows], on_floats[name], rtol=0.0, atol=1e-6)


def test_a_loop_that_is_not_told_what_lies_ahead_holds_what_is_now() -> None:
    """A reference that will jump: known, the plan is ready for it; unknown, it is not."""
    told, held = RealtimeStep(bench(), native=False), RealtimeStep(bench(), native=False)
    ahead = [0.0, 0.0, 4.0 * TURN, 4.0 * TURN, 4.0 * TURN, 4.0 * TURN]
    for _ in range(2):
        known, unknown = told.step([0.0], references=ahead), held.step([0.0], references=[0.0, 0.0])
    assert unknown == pytest.approx((REST, REST), abs=1e-6)
    assert known[0] - known[1] == pytest.approx(4.0, abs=0.1)
    with pytest.raises(ParameterError, match="needs 2 references, or 6 with those ahead, but got 1"):
        told.step([0.0], references=[0.0])


def test_followers_may_have_references_of_their_own() -> None:
    """Two angles of a platform on three elements."""
    platform = machine(ParallelPlatform(side=0.1, height=0.06, mass=0.075), compliance=1e-3, contraction=SHORTER)
    ports = [drive.name for drive in platform.drives()]
    own = {"measured": "alpha", "reference": Constant(level=0.03), "price": Price(error=1e-3, change=1e-6)}
    leader = planned(platform, leads=tuple(ports[1:]), also_measured=("beta",), **own)
    second = Follower(measured="beta", reference=Constant(level=-0.02))
    controllers = Controllers(**{ports[0]: leader, ports[1]: second, ports[2]: Follower()})
    found = simulate_bench(Bench(plant=platform, period=PERIOD, substeps=1, controllers=controllers), 1.0)
    assert found["alpha"][-1] == pytest.approx(0.03, abs=1e-3)
    assert found["beta"][-1] == pytest.approx(-0.02, abs=1e-3)


@pytest.mark.parametrize(
    ("controllers", "sentence"),
    [
        ({"protagonist": Pid(measured="angle", reference=COURSE, Kp=1.0)}, "is a `follower`, and 0 others"),
        ({"antagonist": Pid(measured="angle", reference=COURSE, Kp=1.0)}, "is no `follower`, and 1 others"),
    ],
)
def test_followers_and_leaders_need_each_other(controllers: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        bench(**controllers)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"leads": ()}, "one drive that it does not lead, but has protagonist, antagonist"),
        ({"leads": ("antagonists",)}, "no drive `antagonists`.*`antagonist`"),
        ({"also_measured": ("angle", "angle")}, "names 2 readings, but `mpc` leads 1 drives"),
    ],
)
def test_drives_that_do_not_fit_are_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        planned(**changes)


def test_a_leader_runs_on_a_bench_only_and_finds_who_it_leads() -> None:
    with pytest.raises(ParameterError, match="runs on a bench"):
        planned()(0.0, {"angle": 0.0}, None)
    with pytest.raises(ParameterError, match="names drive `antagonist`, which has no controller"):
        Bench(plant=PAIR, period=PERIOD, controllers=Controllers(protagonist=planned()))
