"""Predictive control: it moves if its horizon is long enough, and beats a PID that was searched.

Sources of truth: the cost of a plan added up by hand, runs of the model itself, plans that a
random search finds with a hundred times as many trials, and a PID controller whose gains are
searched on the very course on which both are compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from builders import problem_a

import martensite as ms
from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.control.controllers.base import AHEAD
from martensite.control.controllers.mpc import Mpc, PlanMemory
from martensite.control.controllers.pid import Correction, Pid
from martensite.control.controllers.planning import Planner, PlanStart, Price, shift_plan
from martensite.control.controllers.time_scales import measure_reach
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, MountedSensor, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.hidden_states import list_names
from martensite.control.sensors.position import PositionSensor
from martensite.kernels import floats
from martensite.kernels.compiler import find_compiler
from martensite.kernels.nested import flatten_numbers
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.constant import Constant
from martensite.signals.table import Table
from martensite.simulate.lanes import Lanes
from martensite.simulate.result import Result

in_c = pytest.mark.skipif(find_compiler() is None, reason="too slow without a C compiler")
EXAMPLES = Path(__file__).parents[2] / "examples"
MM, PERIOD = 1e-3, 0.05
SYSTEM = problem_a().with_parts(source=PwmVoltage(supply=6.0))
OTHER = SYSTEM.with_values({"environment.temperature": 298.15, "cooling.h0": 90.0})
"""Five kelvin warmer, with a tenth less cooling."""
COURSE = Table(times=(0.0, 1.0, 4.0, 8.0, 8.5, 14.0), values=tuple(y * MM for y in (0.5, 0.5, 6, 6, 1, 1)))
"""Up, hold, and down faster than the wire can cool."""
DURATION = 14.0
ERROR = Price(error=0.1 * MM)


@cache
def mpc(**changes: Any) -> Mpc:
    found = Mpc.for_system(SYSTEM, measured="position", reference=COURSE, period=PERIOD, price=ERROR)
    return found.with_parts(**changes)


def bench(plant: AbstractSystem = SYSTEM, delay: float = 0.0, **parts: Any) -> Bench:
    sensor = MountedSensor(sensor=PositionSensor(noise=0.02 * MM), delay=delay)
    return Bench(plant=plant, period=PERIOD, substeps=1, sensors=Sensors(position=sensor), **parts)


def run(controller: Mpc, duration: float, seed: int = 0, **changes: Any) -> Result:
    return simulate_bench(bench(controllers=Controllers(drive=controller), **changes), duration, seed=seed)


# ---------------------------------------------------------------- plans


def planner(wanted: float, blocks: int, turns: int, price: Price = ERROR, signal: float = 0.0) -> Planner:
    """Plans from rest, in blocks of 0.2 s."""
    row = [wanted] * (blocks + 1)
    state = SYSTEM.init(floats, 0.0)
    return Planner(SYSTEM, ("position",), price, (0.0, 1.0), blocks, turns, 0.2, state, (signal,), row)


def test_a_plan_costs_what_its_parts_add_up_to() -> None:
    """Error, energy, changes, and excess of temperature and stress, in a run of the model."""
    price = Price(error=0.2 * MM, energy=0.03, change=0.5, hottest=310.0, strongest=40e6, excess=0.4)
    plan = np.random.default_rng(1).uniform(0.3, 0.8, 4)
    found = planner(3 * MM, 4, 2, price, signal=0.2).rate_plan(floats, plan.tolist())
    lanes = Lanes(SYSTEM, 1)
    lanes.reset()
    rows = lanes.advance(np.repeat(plan, 2)[:, None, None], 0.1)[:, :, 0]
    seen = dict(zip(lanes.names, rows.T, strict=False))
    expected = np.mean(((3 * MM - seen["position"]) / (0.2 * MM)) ** 2)
    expected += 0.03 * np.mean(seen["power"])
    expected += 0.4 * np.mean(np.maximum(seen["hottest"] - 310.0, 0.0) ** 2)
    expected += 0.4 * np.mean((np.maximum(seen["stress"] - 40e6, 0.0) / 1e6) ** 2)
    expected += 0.5 * np.mean(np.diff([0.2, *plan]) ** 2)
    assert max(seen["hottest"]) > 320.0
    assert max(seen["stress"]) > 41e6
    assert found.total == pytest.approx(expected, rel=1e-9)
    assert found.linear == pytest.approx(0.03 * np.mean(seen["power"]), rel=1e-9)
    assert len(found.residuals) == 4 * 3


def test_the_plan_found_is_nearly_as_good_as_the_best_of_many_drawn() -> None:
    """From rest to 4 mm, eight signals: against 2000 plans of a random search."""
    tool, nothing = planner(4 * MM, 8, 1), (0.0,) * 8
    found = tool.search(floats, 3, PlanStart(nothing, nothing, nothing))
    cost = tool.rate_plan(floats, found.plan).total
    lanes, rng = Lanes(SYSTEM, 100), np.random.default_rng(0)
    centre, spread, least = np.full(8, 0.3), np.full(8, 0.3), np.inf
    for _ in range(20):
        plans = np.clip(centre + spread * rng.standard_normal((100, 8)), 0.0, 1.0)
        lanes.reset()
        error = 40.0 - lanes.advance(plans.T[:, None], 0.2)[:, lanes.names.index("position")] / (0.1 * MM)
        costs = np.mean(error**2, axis=0) + 0.01 * np.mean(np.diff(plans, axis=1, prepend=0.0) ** 2, axis=1)
        elite = plans[np.argsort(costs)[:12]]
        centre, spread, least = elite.mean(axis=0), elite.std(axis=0), min(least, costs.min())
    assert cost < 1.02 * least
    assert all(0.0 <= u <= 1.0 for u in found.plan)


@pytest.mark.parametrize(("share", "expected"), [(0.0, [1, 3, 7]), (0.25, [1.5, 4, 7]), (1.0, [3, 7, 7])])
def test_a_plan_moves_on_and_keeps_what_is_left(share: float, expected: list[float]) -> None:
    assert shift_plan([1.0, 3.0, 7.0], 1, share) == pytest.approx(expected)


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


def called(controller: Mpc, values: list[Mapping[str, float]]) -> tuple[list[float], PlanMemory]:
    """Signals on plain floats, and what is remembered at the end."""
    memory, signals = controller.init(), list[float]()
    for k, row in enumerate(values):
        signal, memory = controller(k * PERIOD, row, memory)
        signals.append(signal)
    assert memory is not None
    return signals, controller.unflatten(memory.memory)


FEW = {"blocks": 2, "horizon": 0.6}


def test_the_offset_becomes_what_readings_have_more_than_the_model() -> None:
    controller = mpc(correction=0.5, **FEW)
    _, memory = called(controller, [readings(0.3 * MM)] * 3)
    first = 0.3 * MM
    for model in reversed(memory.past[0][:2]):  # in every sample half of what is left
        first += 0.5 * (0.3 * MM - model - first)
    assert memory.offsets[0] == pytest.approx(first, rel=1e-9)
    assert memory.past[0][0] != 0.0


def test_a_late_reading_is_compared_with_the_model_of_its_time() -> None:
    """The wire moves, and readings are two periods old: there is no offset."""
    controller = mpc(reference=Constant(level=6 * MM), **FEW)
    memory, most = controller.init(), 0.0
    for k in range(16):
        past = (0.0,) * 8 if memory is None else controller.unflatten(memory.memory).past[0]
        _, memory = controller(k * PERIOD, {"position": past[1], "position.age": 2 * PERIOD}, memory)
        after = controller.unflatten(memory.memory)
        most = max(most, after.past[0][0] - after.past[0][2])
        assert after.offsets[0] == pytest.approx(0.0, abs=1e-12)
    assert most > 0.5 * MM


def test_the_state_may_come_from_an_observer() -> None:
    controller = mpc(state="observer", **FEW)
    assert controller.reads() == ("position", "estimated.temperature", "estimated.martensite_fraction")
    said = {"estimated.temperature": 333.0, "estimated.martensite_fraction": 0.8}
    _, memory = called(controller, [readings(1 * MM, **said)] * 2)
    lanes = Lanes(SYSTEM, 1)
    lanes.state = np.array(flatten_numbers(memory.state))[:, None]
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
def test_a_limit_of_temperature_is_kept_with_a_late_sensor_too() -> None:
    limit, prices = 350.0, (Price(error=0.1 * MM, hottest=400.0), Price(error=0.1 * MM, hottest=350.0))
    free, kept = (run(mpc(price=price), 5.0, delay=0.15) for price in prices)
    assert free["position"][-1] == pytest.approx(6 * MM, abs=0.3 * MM)
    assert max(free["hottest"]) > limit + 4.0
    assert max(kept["hottest"]) < limit + 2.0


# ---------------------------------------------------------------- errors


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


def test_a_missing_reading_is_named_with_the_nearest() -> None:
    controller = mpc(**FEW)
    with pytest.raises(ParameterError, match=r"`position`.*`positions`"):
        controller(0.0, {"positions": 0.0}, controller.init())


@in_c
def test_a_model_that_tracks_its_readings_follows_on_a_wire_that_cools_twice_as_well() -> None:
    """By its offset alone the model stays where the signals of the other wire lead it: 1.28 mm, and 0.70 mm with."""
    other, apart = SYSTEM.with_values({"cooling.h0": 2.0 * SYSTEM.value_of("cooling.h0")}), list[float]()
    for tracking in (None, Correction(Kp=1000.0, Ki=400.0)):
        found = run(mpc(horizon=2.0, blocks=5, tracking=tracking), DURATION, plant=other)
        wanted = np.array([COURSE.value(time) for time in found.times])
        apart.append(float(np.sqrt(np.mean((np.array(found["position"]) - wanted)[40:] ** 2))))
    assert apart[1] < 0.7 * apart[0]


def test_what_tracks_adds_to_its_own_drive_and_takes_from_the_one_that_it_leads() -> None:
    """The angle read is 2° more than that of the model; the model goes on under both signals, within their limits."""
    bench: Any = ms.load(EXAMPLES / "closed_loop_antagonistic.toml").bench
    lead = bench.controllers.protagonist.with_parts(blocks=1, horizon=0.1, tracking=Correction(Kp=10.0, Ki=5.0))
    rows = {f"{AHEAD}protagonist.{k}": 0.1 for k in (0, 1)}
    memory = lead.rest(floats, 0.1, {"angle": 0.0})
    known = lead.unflatten(memory)
    for _ in range(2):
        said = known.past[0][0]
        _, memory = lead.answer(floats, memory, 0.1, {"angle": said + math.radians(2.0), **rows}, PERIOD)
        before, known = known, lead.unflatten(memory)
    up, down = before.signals
    added = before.added[0]
    assert 0.3 < added < 2.0
    lanes = Lanes(lead.model, 1)
    lanes.state = np.array(flatten_numbers(before.state))[:, None]
    given = np.array([min(up + added, 2.0), max(down - added, 0.0)])[None, :, None]
    turns = lead.layout()[3]
    lanes.advance(np.repeat(given, turns, axis=0), PERIOD / turns)
    assert flatten_numbers(known.state) == pytest.approx(lanes.state[:, 0], rel=1e-9)


def test_plans_count_on_what_the_model_gets_besides() -> None:
    plan = (0.5, 0.4, 0.6)
    shifted = planner(3 * MM, 3, 2, signal=0.2)._replace(shifts=(0.1,)).rate_plan(floats, plan)
    found = planner(3 * MM, 3, 2, signal=0.3).rate_plan(floats, [u + 0.1 for u in plan])
    assert [shifted.total, *shifted.residuals] == pytest.approx([found.total, *found.residuals], rel=1e-12)


def test_tracking_is_for_one_reading() -> None:
    kept: dict[str, Any] = {"model": SYSTEM, "measured": "position", "reference": COURSE}
    kept |= {"period": PERIOD, "horizon": 1.0}
    wrong: list[dict[str, Any]] = [{"leads": ("a", "b")}, {"leads": ("a",), "also_measured": ("angle",)}]
    for more in wrong:
        with pytest.raises(ParameterError, match="`tracking` is for one reading, and one drive or two"):
            Mpc(tracking=Correction(), **kept, **more)
