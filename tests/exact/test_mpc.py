"""Predictive control: it moves if its horizon is long enough, and beats a PID that was searched.

Sources of truth: the cost of a plan added up by hand, runs of the model itself, and a PID
controller whose gains are searched on the very course on which both are compared.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from builders import problem_a

from martensite.actuators.assembly import AbstractSystem, Group, Machine
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import ParameterError
from martensite.control.controllers.mpc import Mpc, Planned
from martensite.control.controllers.pid import Pid
from martensite.control.controllers.planning import Moment, Planner, PlanSearch, Price, measure_reach, shift_plan
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.hidden_states import list_names
from martensite.control.sensors.position import PositionSensor
from martensite.kernels.compiler import find_compiler
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.lanes import Lanes
from martensite.simulate.result import Result

in_c = pytest.mark.skipif(find_compiler() is None, reason="too slow without a C compiler")
MM, PERIOD = 1e-3, 0.05
SYSTEM = problem_a().with_parts(source=PwmVoltage(supply=6.0))
OTHER = SYSTEM.with_values({"environment.temperature": 298.15, "cooling.h0": 90.0})
"""Five kelvin warmer, with a tenth less cooling."""
COURSE = Table(times=(0.0, 1.0, 4.0, 8.0, 8.5, 14.0), values=tuple(y * MM for y in (0.5, 0.5, 6, 6, 1, 1)))
"""Up, hold, and down faster than the wire can cool."""
DURATION = 14.0
ERROR = Price(error=0.1 * MM)
SMALL = PlanSearch(plans=32, rounds=3)


@cache
def mpc(**changes: Any) -> Mpc:
    found = Mpc.for_system(SYSTEM, measured="position", reference=COURSE, period=PERIOD, price=ERROR, search=SMALL)
    return found.with_parts(**changes)


def bench(plant: AbstractSystem = SYSTEM, delay: float = 0.0, **parts: Any) -> Bench:
    sensor = MountedSensor(sensor=PositionSensor(noise=0.02 * MM), delay=delay)
    return Bench(plant=plant, period=PERIOD, substeps=1, sensors=Sensors(position=sensor), **parts)


def run(controller: Mpc, duration: float, seed: int = 0, **changes: Any) -> Result:
    return simulate_bench(bench(**changes), duration, outside={"drive": controller}, seed=seed)


# ---------------------------------------------------------------- plans


def planner(price: Price = ERROR, plans: int = 20) -> Planner:
    search = PlanSearch(plans=plans, rounds=3)
    return Planner(Lanes(SYSTEM, plans), "position", price, search, (0.0, 1.0))


def at_rest(wanted: float, steps: int, signal: float = 0.0) -> Moment:
    lanes = Lanes(SYSTEM, 1)
    lanes.reset()
    return Moment(lanes.state, signal, np.full(steps, wanted))


def test_a_plan_costs_what_its_parts_add_up_to() -> None:
    """Error, energy, changes, and excess of temperature and stress, in a run of the model."""
    price = Price(error=0.2 * MM, energy=0.03, change=0.5, hottest=310.0, strongest=40e6, excess=0.4)
    plans = np.random.default_rng(1).uniform(0.3, 0.8, (4, 20))
    found = planner(price).costs(at_rest(3 * MM, 8, signal=0.2), plans, 0.1)
    lanes = Lanes(SYSTEM, 1)
    lanes.reset()
    rows = lanes.advance(np.repeat(plans[:, 5], 2)[:, None, None], 0.1)[:, :, 0]
    seen = dict(zip(lanes.names, rows.T, strict=False))
    expected = np.mean(((3 * MM - seen["position"]) / (0.2 * MM)) ** 2)
    expected += 0.03 * np.mean(seen["power"])
    expected += 0.4 * np.mean(np.maximum(seen["hottest"] - 310.0, 0.0) ** 2)
    expected += 0.4 * np.mean((np.maximum(seen["stress"] - 40e6, 0.0) / 1e6) ** 2)
    expected += 0.5 * np.mean(np.diff([0.2, *plans[:, 5]]) ** 2)
    assert max(seen["hottest"]) > 320.0
    assert max(seen["stress"]) > 41e6
    assert found[5] == pytest.approx(expected, rel=1e-9)
    assert len(set(found.tolist())) == 20


@in_c
def test_the_best_plan_is_better_than_what_it_began_with() -> None:
    tool, moment, guess = planner(plans=32), at_rest(4 * MM, 20), np.full(10, 0.15)
    best, cost = tool.best(moment, guess, 0.15, np.random.default_rng(0))
    stays = np.repeat(np.linspace(0.0, 1.0, 32)[None], 10, axis=0)
    assert cost < 0.9 * min(tool.costs(moment, stays, 0.15))
    again = tool.costs(moment, np.repeat(best[:, None], 32, axis=1), 0.15)
    assert cost == pytest.approx(again[0], rel=1e-12)
    assert best.min() >= 0.0
    assert best.max() <= 1.0


@pytest.mark.parametrize(
    ("share", "expected"), [(0.0, [1, 3, 7]), (0.25, [1.5, 4, 7]), (1.0, [3, 7, 7]), (1.5, [5, 7, 7]), (4.0, [7, 7, 7])]
)
def test_a_plan_moves_on_and_keeps_what_is_left(share: float, expected: list[float]) -> None:
    assert shift_plan(np.array([1.0, 3.0, 7.0]), share) == pytest.approx(expected)


# ---------------------------------------------------------------- the horizon


def test_reach_is_what_runs_of_the_model_show() -> None:
    found = measure_reach(SYSTEM, "position", 0.0, 0.4)
    lanes = Lanes(SYSTEM, 1)
    for time, low, high in ((found.start, 0.02, 0.2), (found.up, 0.4, 0.6)):
        lanes.reset()
        rows = lanes.advance(np.full((40, 1, 1), 0.4), time / 40)
        assert low < rows[-1, lanes.names.index("position"), 0] / (10 * MM) < high
    assert found.start < found.up < found.down


@in_c
def test_a_short_horizon_stays_off_and_is_warned_about() -> None:
    """With a price of energy: within 0.2 s heating costs, and moves nothing yet."""
    changes = {"price": Price(error=0.1 * MM, energy=1.0), "reference": Constant(level=MM)}
    short, long = (mpc(horizon=h, **changes) for h in (0.2, mpc().horizon))
    still, moving = (run(one, 3.0) for one in (short, long))
    assert max(still["position"]) < 0.05 * MM
    assert moving["position"][-1] == pytest.approx(MM, abs=0.1 * MM)
    (caution,) = short.cautions()
    assert "0.2 s" in caution
    assert long.cautions() == []


def test_a_signal_that_moves_nothing_is_refused() -> None:
    with pytest.raises(ParameterError, match="does not move"):
        measure_reach(SYSTEM, "position", 0.0, 0.0)


# ---------------------------------------------------------------- memory


def readings(position: float, **more: float) -> Mapping[str, float]:
    return {"position": position, **more}


def called(controller: Mpc, values: list[Mapping[str, float]]) -> tuple[list[float], Planned]:
    memory, signals = controller.init(), list[float]()
    for k, row in enumerate(values):
        signal, memory = controller(k * PERIOD, row, memory)
        signals.append(signal)
    return signals, memory


FEW = PlanSearch(plans=24, rounds=1)


def test_the_same_seed_gives_the_same_signals() -> None:
    values = [readings(0.1 * MM * k) for k in range(6)]
    first, again, other = (called(mpc(search=s), values)[0] for s in (FEW, FEW, PlanSearch(plans=24, rounds=1, seed=1)))
    assert first == again
    assert first != other


def test_nothing_is_remembered_but_the_memory() -> None:
    controller = mpc(search=FEW)
    _, memory = called(controller, [readings(0.0)] * 3)
    now = readings(0.2 * MM)
    first, after = controller(3 * PERIOD, now, memory)
    controller(4 * PERIOD, now, after)
    again, _ = controller(3 * PERIOD, now, memory)
    assert first == again


def test_the_offset_becomes_what_readings_have_more_than_the_model() -> None:
    controller = mpc(search=FEW, correction=0.5)
    memory = controller.init()
    for k in range(12):
        value = memory.past[0] if memory.past else 0.0
        known = controller._gone_on(memory, readings(value))  # what the model will say
        _, memory = controller(k * PERIOD, readings(known.past[0] + 0.3 * MM), memory)
        assert memory.offset == pytest.approx(0.3 * MM, rel=1e-9)
    _, memory = controller(12 * PERIOD, readings(memory.past[0]), memory)
    assert memory.offset < 0.3 * MM


def test_a_late_reading_is_compared_with_the_model_of_its_time() -> None:
    """The wire moves, and readings are two periods old: there is no offset."""
    controller = mpc(search=FEW, reference=Constant(level=6 * MM))
    memory, most = controller.init(), 0.0
    for k in range(25):
        past = controller._gone_on(memory, readings(0.0)).past
        late = min(2, len(past) - 1)
        row = {"position": past[late], "position.age": late * PERIOD}
        _, memory = controller(k * PERIOD, row, memory)
        most = max(most, past[0] - past[late])
        assert memory.offset == pytest.approx(0.0, abs=1e-12)
    assert most > 0.5 * MM


def test_the_state_may_come_from_an_observer() -> None:
    controller = mpc(search=FEW, state="observer")
    assert controller.reads() == ("position", "estimated.temperature", "estimated.martensite_fraction")
    said = {"estimated.temperature": 333.0, "estimated.martensite_fraction": 0.8}
    _, memory = called(controller, [readings(1 * MM, **said)])
    lanes = Lanes(SYSTEM, 1)
    lanes.state = memory.state
    seen = dict(zip(lanes.names, lanes.observe(0.0)[:, 0], strict=False))
    assert [seen[name] for name in list_names(SYSTEM)] == pytest.approx([333.0, 0.8])


# ---------------------------------------------------------------- against a PID


class Marks(NamedTuple):
    """What a run is judged by."""

    itae: float
    """[mm s²]"""
    rms: float
    """[mm]"""
    hottest: float
    energy: float


def marks(found: Result) -> Marks:
    times = np.array(found.times)
    error = (np.array([COURSE.value(t) for t in found.times]) - found["position"]) / MM
    itae, rms = PERIOD * np.sum(np.abs(error) * times), np.sqrt(np.mean(error**2))
    energy = PERIOD * np.sum(found["power"])
    return Marks(float(itae), float(rms), max(found["hottest"]), float(energy))


GAINS = ("Kp", "Ki", "Kd", "law.filter", "law.weight")
LOW, HIGH = np.array([1.0, 0.7, -1.7, 0.02, 0.0]), np.array([4.0, 4.7, 2.8, 0.16, 1.0])
SEEDS, EACH = (11, 12), 48


@cache
def searched_pid() -> Bench:
    """The PID of least ITAE on the course, the mean over two draws of noise: 480 sets of gains."""
    pid = Pid(measured="position", reference=COURSE, Kp=1.0)
    loop, steps = bench(controllers=Controllers(drive=pid)), round(DURATION / PERIOD)
    drives, times = [d.name for d in loop.drives()], PERIOD * np.arange(1, steps + 1)
    wanted = np.array([COURSE.value(t) for t in times])[:, None]
    played = np.zeros((steps, len(drives), EACH * len(SEEDS)))
    played[:, drives.index("reference")] = wanted
    for k, seed in enumerate(SEEDS):
        noise = np.random.default_rng(seed).standard_normal((steps, 1))
        played[:, drives.index("noise.position"), k * EACH : (k + 1) * EACH] = noise
    rng, centre, spread = np.random.default_rng(0), (LOW + HIGH) / 2, (HIGH - LOW) / 2
    best, least = centre, np.inf
    for _ in range(10):
        sets = np.clip(centre + spread * rng.standard_normal((EACH, 5)), LOW, HIGH)
        sets[0] = best
        lanes = Lanes(loop, played.shape[2], {p: np.tile(v, len(SEEDS)) for p, v in at(sets.T)})
        lanes.reset(played[0])
        error = wanted - lanes.advance(played, PERIOD)[:, lanes.names.index("position")]
        cost = np.sum(np.abs(error) * times[:, None], axis=0).reshape(len(SEEDS), EACH).mean(axis=0)
        order = np.argsort(cost)
        if cost[order[0]] < least:
            best, least = sets[order[0]], cost[order[0]]
        elite = sets[order[: EACH // 8]]
        centre, spread = elite.mean(axis=0), elite.std(axis=0)
    return loop.with_values(dict(at(best)))


def at(numbers: np.ndarray) -> list[tuple[str, Any]]:
    """Gains by path; the first three are searched by their logarithms."""
    rows = zip(GAINS, numbers, strict=True)
    return [(f"controllers.drive.{n}", 10.0**x if n in GAINS[:3] else x) for n, x in rows]


@in_c
@pytest.mark.parametrize(
    "plant", [pytest.param(SYSTEM, marks=pytest.mark.slow), OTHER], ids=["true model", "another plant"]
)
def test_it_beats_a_pid_whose_gains_were_searched(plant: AbstractSystem) -> None:
    """On noise that neither has seen; with a wrong model it still does."""
    loop = searched_pid().with_parts(plant=plant)
    pid = marks(simulate_bench(loop, DURATION, seed=7))
    ours = marks(run(mpc(), DURATION, seed=7, plant=plant))
    assert pid.itae < 150.0, "the PID does not control"
    assert ours.itae < 0.7 * pid.itae
    assert ours.rms < 0.8 * pid.rms
    assert ours.hottest < pid.hottest + 1.0


@in_c
def test_a_limit_of_temperature_is_kept() -> None:
    limit = 350.0
    free, kept = mpc(), mpc(price=Price(error=0.1 * MM, hottest=limit))
    hot, cool = (max(run(one, 5.0)["hottest"]) for one in (free, kept))
    assert hot > limit + 4.0
    assert cool < limit + 2.0


@in_c
def test_a_delay_of_its_sensor_does_not_throw_it() -> None:
    found = run(mpc(), 5.0, delay=0.15)
    assert found["position"][-1] == pytest.approx(6 * MM, abs=0.3 * MM)


# ---------------------------------------------------------------- errors


def pair() -> Machine:
    one = next(iter(SYSTEM.actuators().values()))
    parts: Any = {"actuators": Group(a=one, b=one)}
    return Machine(mechanism=DeadWeight(mass=1.0), **parts)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"output": "positon"}, "no output `positon`.*position"),
        ({"low": 1.0}, "below the largest"),
        ({"horizon": 0.01}, "shorter than the period"),
        ({"blocks": 0}, "`blocks` must be a whole number"),
        ({"kept": 1.5}, "`kept` must be a whole number"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        mpc(**changes)


def test_a_search_needs_plans() -> None:
    with pytest.raises(ParameterError, match="`plans` of a search"):
        PlanSearch(plans=3)


def test_a_missing_reading_is_named_with_the_nearest() -> None:
    controller = mpc(search=FEW)
    with pytest.raises(ParameterError, match=r"`position`.*`positions`"):
        controller(0.0, {"positions": 0.0}, controller.init())


def test_it_runs_outside_of_a_bench_only() -> None:
    with pytest.raises(ParameterError, match="no kernel"):
        bench(controllers=Controllers(drive=mpc()))
