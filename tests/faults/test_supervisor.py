"""A guard on a bench: which alarm, how soon, and that no element gets hotter than its bound.

Every fault runs with and without the guard: without it the same bench gets too hot, so that what
is tested here can fail. All runs share one program: what is not wanted begins never, or has a
limit that is never reached.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import example, problem_a
from hypothesis import given, settings
from hypothesis import strategies as some

from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.ribbon import Ribbon
from martensite.actuators.elements.rows import Bundle
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.errors import InputError, ParameterError
from martensite.base.parameters import Number, param
from martensite.control.checks.base import CHECKS, Checks, alarm_names
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.controllers.pid import Pid
from martensite.control.faults.base import FAULTS
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import SUPERVISORS, Controllers, FaultTable, MountedSensor, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.sensors.base import AbstractSensor
from martensite.control.supervisors.from_plant import build_thermal_guard, least_conductance, worst_power
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.electrical.switches import Mosfet
from martensite.physics.thermal.ends import ClampedEnds
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp

NEVER = 1e6
LIMIT = 413.15
"""Of the bound without a sensor [K]."""
HOT = 393.15
"""Of the measured temperature [K]."""
PERIOD = 0.02
WIRE = problem_a().with_parts(source=Mosfet(supply=6.0, frequency=1e3, dead_time=5e-6, on_resistance=0.1))


class Noisy(AbstractSensor):
    """The truth and noise."""

    unit = None
    sees = ("position",)

    noise: Number = param("1", "standard deviation", default=0.0)
    resolution: Number = param("1", "least step", default=0.0)

    def step(self, xp: Any, state: Any, truth: Any, noise: Any, dt: Any) -> Any:
        return truth[0] + self.noise * noise, ()


FAULT: Any = FAULTS
CHECK: Any = CHECKS
FAULTY = {
    "lost": FAULT["drop-out"](sensor="position", start=NEVER),
    "stuck": FAULT["stuck"](sensor="position", start=NEVER),
    "drift": FAULT["drift"](sensor="position", start=NEVER, rate=-3e-3),
    "sag": FAULT["supply-sag"](share=0.3, start=NEVER),
    "broken": FAULT["open-circuit"](start=NEVER),
    "warm": FAULT["ambient-step"](by=60.0, start=NEVER),
    "calm": FAULT["draught"](factor=0.4, start=NEVER),
}
WATCHED = {
    "hot": CHECK["overheat"](reading="temperature", limit=HOT, band=10.0),
    "current": CHECK["over-current"](reading="current", limit=2.6),
    "stress": CHECK["over-stress"](reading="stress", limit=1e9),
    "lost": CHECK["sensor-lost"](reading="position", timeout=0.2),
    "stuck": CHECK["sensor-stuck"](reading="position", longest=0.3),
    "open": CHECK["open-circuit"](reading="current", longest=0.1, most=0.02, least=0.05),
    "apart": CHECK["mismatch"](reading="position", other="second", limit=5e-4, longest=0.1),
}
SILENT = {
    "hot.limit": 1e9,
    "current.limit": 1e9,
    "lost.timeout": 1e9,
    "stuck.longest": 1e9,
    "open.longest": 1e9,
    "apart.limit": 1e9,
}
"""All checks that need a sensor, off."""
OFF = {f"supervisor.checks.{name}": value for name, value in SILENT.items()}
OPEN = OFF | {"supervisor.checks.bound_drive.limit": 1e9}
"""Nothing is guarded."""
HELD = {"controllers.drive.law.low": 0.2, "controllers.drive.law.high": 0.2 + 1e-9}
"""A controller that cannot but hold its signal."""


def mounted(name: str, noise: float) -> MountedSensor:
    return MountedSensor(sensor=Noisy(noise=noise), of=(name,))


@cache
def bench(answer: str = "resume") -> Bench:
    """A wire that a PID controller pulls along a ramp of 3 mm, with everything that may happen."""
    sensors = Sensors(
        position=MountedSensor(sensor=Noisy(noise=2e-6), delay=2 * PERIOD),
        second=mounted("position", 2e-6),
        temperature=mounted("temperature", 0.2),
        current=mounted("current", 1e-3),
        stress=mounted("stress", 0.0),
    )
    guard = build_thermal_guard(
        WIRE,
        temperature_limit=LIMIT,
        hottest=303.15,
        least_cooling=0.8,
        answer=answer,
        band=5.0,
        hold=0.5,
        checks=WATCHED,
    )
    ramp = Ramp(low=0.0, high=3e-3, start=0.5, end=2.5)
    pid = Pid(measured="position", reference=ramp, Kp=150.0, Ki=150.0)
    return Bench(
        plant=WIRE,
        period=PERIOD,
        sensors=sensors,
        controllers=Controllers(drive=pid),
        supervisor=guard,
        faults=FaultTable(**FAULTY),
    )


def run(seconds: float, values: dict[str, float], **starts: float) -> Any:
    begin = {f"faults.{name}.start": start for name, start in starts.items()}
    return simulate_bench(bench().with_values(values | begin), seconds)


def alarms(found: Any) -> tuple[float, float]:
    """The first alarm, and when it was raised [s]; 0 and never."""
    rows = [(number, t) for t, number in zip(found.times, found["alarm"], strict=True) if number]
    return rows[0] if rows else (0.0, math.inf)


# ---------------------------------------------------------------- faults on the bench


def test_without_a_fault_nothing_is_cut():
    found, free = run(8.0, {}), run(8.0, OPEN)
    assert alarms(found) == (0.0, math.inf)
    assert found["position"].tolist() == free["position"].tolist()
    assert found.columns["position"][-50:] == pytest.approx([3e-3] * 50, abs=3e-4)


ALONE = {"supervisor.checks.apart.limit": 1e9}
"""There is no second sensor."""
UNKNOWN = HELD | {"supervisor.checks.bound_drive.limit": 1e9}
"""The surroundings are beyond what the bound was told: it is of no use."""
ANSWERS = {
    "lost": (4, 0.3, ALONE),
    "stuck": (5, 0.5, ALONE),
    "drift": (7, 0.4, {}),
    "sag": (8, 0.8, {}),
    "broken": (6, 0.2, {}),
    "warm": (1, 6.0, UNKNOWN),
    "calm": (1, 6.0, UNKNOWN),
}
"""Fault -> alarm, how soon [s], and what else is set."""


@pytest.mark.parametrize("fault", ANSWERS)
def test_every_fault_has_its_answer(fault):
    """The alarm of its kind, soon, and a signal of 0 from that very sample on."""
    number, soon, values = ANSWERS[fault]
    found = run(10.0, values, **{fault: 2.0})
    alarm, at = alarms(found)
    assert (alarm, 2.0 < at < 2.0 + soon) == (number, True), at
    cut = [u for u, number in zip(found["current"], found["alarm"], strict=True) if number]
    assert max(found["temperature"]) < LIMIT
    assert found["wanted"][-1] > 0.0
    assert (len(cut) > 10, set(cut)) == (True, {0.0})


@pytest.mark.parametrize("fault", ["lost", "stuck", "drift", "warm", "calm"])
def test_without_a_guard_it_gets_too_hot(fault):
    found = run(10.0, OPEN | ANSWERS[fault][2], **{fault: 2.0})
    assert alarms(found) == (0.0, math.inf)
    assert max(found["temperature"]) > LIMIT


@pytest.mark.parametrize("fault", ["lost", "stuck", "drift"])
def test_the_bound_alone_is_enough(fault):
    """Whatever the sensors say: no check that reads one is on."""
    found = run(10.0, OFF, **{fault: 2.0})
    assert alarms(found)[0] == 8.0
    assert max(found["temperature"]) < LIMIT


def test_the_bound_holds_in_the_surroundings_that_it_was_told():
    told = {
        "supervisor.checks.bound_drive.ambient": 293.15 + 60.0,
        "supervisor.checks.bound_drive.conductance": 0.4 * least_conductance(WIRE, 293.15, LIMIT),
    }
    both = {"warm": 2.0, "calm": 2.0}
    assert max(run(10.0, OPEN | HELD, **both)["temperature"]) > LIMIT + 50.0
    assert max(run(10.0, OFF | HELD | told, **both)["temperature"]) < LIMIT
    assert max(run(10.0, OFF | HELD, **both)["temperature"]) > LIMIT  # but only in those


def test_a_surge_is_seen_in_the_current():
    found = run(3.0, HELD | {"faults.sag.share": 4.0}, sag=2.0)
    assert alarms(found) == (2.0, pytest.approx(2.0, abs=1.5 * PERIOD))


def test_a_sensor_that_comes_back_is_used_again():
    found = run(10.0, ALONE | {"faults.lost.end": 3.0}, lost=2.0)
    assert alarms(found)[0] == 4.0
    assert found.columns["alarm"][-1] == 0.0
    assert found.columns["position"][-1] == pytest.approx(3e-3, abs=3e-4)


def hottest(values: dict[str, float], seed: int) -> float:
    """Hottest temperature [K] of a run with three faults that begin at random times."""
    rng = np.random.default_rng(seed)
    names = rng.choice(["lost", "stuck", "drift", "sag", "broken"], 3, replace=False)
    starts = {str(name): float(rng.uniform(0.0, 4.0)) for name in names}
    ends = {f"faults.{n}.end": start + float(rng.uniform(0.1, 4.0)) for n, start in starts.items()}
    return max(run(8.0, values | ends, **starts)["temperature"])


def test_bounded_for_faults_at_any_time():
    assert max(hottest(OFF, seed) for seed in range(16)) < LIMIT
    assert sum(hottest(OPEN, seed) > LIMIT for seed in range(16)) > 3


def test_a_latched_guard_does_not_come_back():
    once = bench("latch").with_values({"faults.lost.start": 0.7, "faults.lost.end": 1.2})
    found = simulate_bench(once, 1.6, runtime="floats")
    first = found["alarm"].tolist().index(4.0)
    assert set(found.columns["alarm"][first:]) == {4.0}
    assert set(found.columns["current"][first:-1]) == {0.0}


# ---------------------------------------------------------------- the bound


def bound(**changes: Any) -> ThermalBound:
    numbers: dict[str, Any] = {"limit": 400.0, "power": 10.0, "capacity": 0.1, "conductance": 0.03, "ambient": 300.0}
    return ThermalBound(**(numbers | changes))


def test_a_period_is_solved_exactly():
    one = bound()
    halves = one.after(floats, one.after(floats, 310.0, 0.4, 0.5), 0.4, 0.5)
    assert one.after(floats, 310.0, 0.4, 1.0) == pytest.approx(halves, rel=1e-14)
    assert one.after(floats, 310.0, 0.4, 1e3) == pytest.approx(300.0 + 4.0 / 0.03)
    slope = (one.after(floats, 310.0, 0.4, 1e-6) - 310.0) / 1e-6
    assert slope == pytest.approx((4.0 - 0.03 * 10.0) / 0.1, rel=1e-4)


def test_power_rises_with_the_signal_or_its_square():
    assert bound(full=5.0).settled_bound(floats, -2.5) == pytest.approx(300.0 + 5.0 / 0.03)
    square = bound(full=5.0, rises="square")
    assert square.settled_bound(floats, -2.5) == pytest.approx(300.0 + 2.5 / 0.03)


def warmed(one: ThermalBound, signals: list[float], share: float) -> tuple[float, float]:
    """Hottest [K] of the bound, and of a body of a larger heat capacity that also transforms.

    It takes 6 J between 340 and 350 K; Euler's method in steps of 10 ms.
    """
    temperature = high = top = hottest = 300.0
    for signal in signals:
        top = max(top, high := one.after(floats, high, signal, 0.2))
        for _ in range(20):
            heat = (10.0 * signal - 0.03 * (temperature - 300.0)) * 0.01
            latent = 6.0 / 10.0 if 340.0 < temperature < 350.0 else 0.0
            temperature += heat / (0.1 / share + latent)
            hottest = max(hottest, temperature)
    return top, hottest


@settings(deadline=None, max_examples=40)
@given(signals=some.lists(some.floats(0.0, 1.0), min_size=50, max_size=50), share=some.floats(0.5, 1.0))
def test_the_bound_is_above_what_stores_more_heat(signals, share):
    top, hottest = warmed(bound(), signals, share)
    assert hottest <= max(top, 350.0) + 0.5


def test_a_bound_that_counts_on_latent_heat_is_passed():
    top, hottest = warmed(bound(capacity=0.1 + 0.06), [1.0] * 20 + [0.1] * 20 + [1.0] * 5, 1.0)
    assert hottest > top + 5.0


def test_worst_power_is_at_the_worst_resistance():
    """A series resistance between the extremes of that of the wire: matched, U²/(4 R_s)."""
    matched = WIRE.with_parts(source=Mosfet(supply=6.0, frequency=1e3, on_resistance=2.2))
    assert worst_power(matched, LIMIT, 1.0) == pytest.approx(36.0 / 4.0 / 2.2, rel=1e-4)
    assert worst_power(WIRE, LIMIT, 0.0) == 0.0


def test_the_least_heat_loss_is_where_it_is_least():
    """Problem A cools with 100 + 0.15 θ: least at the surroundings."""
    surface = math.pi * 0.381e-3 * 0.25
    assert least_conductance(WIRE, 293.15, LIMIT) == pytest.approx(100.0 * surface, rel=1e-2)


def test_a_guard_takes_its_limit_from_the_element():
    limited = WIRE.with_parts(element=WIRE.element.with_parts(limits=ElementLimits(temperature_limit=390)))
    (one,) = build_thermal_guard(limited).checks.members().values()
    assert (one.value_of("limit"), one.value_of("ambient")) == (390.0, 293.15)
    assert one.value_of("capacity") == WIRE.element.heat_capacity_total()


SOURCE = {"supply": 6.0, "frequency": 1e3, "on_resistance": 0.1}


def pulling(element: Any, times: float = 1.0) -> Any:
    """A stiffer spring and a stronger source for so many strands."""
    source = Mosfet(**(SOURCE | {"supply": 6.0 * times, "on_resistance": 0.1 * times}))
    spring = BiasSpring(stiffness=1000.0 * times, preload=5.0 * times)
    return WIRE.with_parts(element=element, source=source, mechanism=spring)


def test_a_bundle_is_bounded_as_a_whole():
    """Three strands in series at three times the voltage: everything three times; ends apart."""
    clamped = WIRE.element.with_parts(ends=ClampedEnds(thermal_conductivity=18.0))
    bundle = Bundle(strand=clamped, count=3.0)
    three, one = (
        build_thermal_guard(plant, temperature_limit=LIMIT).checks.members()["bound_drive"]
        for plant in (pulling(bundle, 3.0), pulling(WIRE.element))
    )
    for name in ("power", "capacity", "conductance"):
        assert three.value_of(name) == pytest.approx(3.0 * one.value_of(name), rel=1e-12)


def test_the_bound_of_a_bundle_holds():
    plant = pulling(Bundle(strand=WIRE.element, count=3.0), 3.0)
    guard = build_thermal_guard(plant, temperature_limit=LIMIT, answer="resume", band=5.0)
    full = {"drive": Constant(level=1.0)}
    free = Bench(plant=plant, period=PERIOD, substeps=1)
    found, hot = (
        simulate_bench(one, 2.0, waveforms=full, runtime="floats") for one in (free.with_parts(supervisor=guard), free)
    )
    assert alarms(found)[0] == 8.0
    assert 350.0 < max(found["temperature"]) < LIMIT < max(hot["temperature"])


def test_an_element_of_many_temperatures_has_no_bound():
    ribbon = example(Ribbon)
    with pytest.raises(InputError, match=r"elements of one temperature, .* not for `ribbon`"):
        build_thermal_guard(WIRE.with_parts(element=ribbon), temperature_limit=LIMIT)


def test_a_guard_that_lacks_a_number_says_so():
    with pytest.raises(InputError, match="no `temperature_limit`"):
        build_thermal_guard(WIRE)
    with pytest.raises(InputError, match="takes a signal in W: give its largest"):
        build_thermal_guard(WIRE.with_parts(source=PowerSource()), temperature_limit=LIMIT)


# ---------------------------------------------------------------- checks, one by one


def judged(guard: Guard, rows: list[tuple[float, dict[str, float]]]) -> list[tuple[float, float]]:
    """Signal and alarm of every sample, of signals wanted and readings."""
    memory = guard.rest(floats, rows[0][1])
    found: list[tuple[float, float]] = []
    for wanted, readings in rows:
        signals, alarm, memory = guard.judge(floats, memory, {"drive": wanted}, readings, 0.1)
        found.append((signals["drive"], alarm))
    return found


def only(name: str, **values: Any) -> Checks:
    return Checks(one=CHECK[name](**values))


def test_above_its_limit_and_below_its_band():
    guard = Guard(checks=only("overheat", reading="T", limit=400.0, band=10.0), answer="resume")
    rows = [(1.0, {"T": T}) for T in (399.0, 401.0, 395.0, 389.0, math.nan)]
    assert judged(guard, rows) == [(1.0, 0), (0.0, 1), (0.0, 1), (1.0, 0), (0.0, 1)]


def test_a_cut_is_held():
    guard = Guard(checks=only("overheat", reading="T", limit=400.0), answer="resume", hold=0.25)
    rows = [(1.0, {"T": T}) for T in (401.0, 399.0, 399.0, 399.0, 399.0)]
    assert [alarm for _, alarm in judged(guard, rows)] == [1, 1, 1, 1, 0]


def test_no_current_counts_only_under_a_signal():
    guard = Guard(checks=only("open-circuit", reading="I", most=0.01, longest=0.15))
    assert judged(guard, [(0.0, {"I": 0.0})] * 5)[-1] == (0.0, 0)
    assert [a for _, a in judged(guard, [(0.5, {"I": 0.0})] * 4)] == [0, 0, 6, 6]
    assert judged(guard, [(0.5, {"I": -1.0})] * 5)[-1] == (0.5, 0)


def test_a_reading_at_rest_may_stay():
    guard = Guard(checks=only("sensor-stuck", reading="y", longest=0.15))
    same: dict[str, float] = {"y": 2.0}
    assert judged(guard, [(0.0, same)] * 5)[-1] == (0.0, 0)
    assert [a for _, a in judged(guard, [(0.5, same)] * 4)] == [0, 0, 5, 5]
    moving = [(0.5, {"y": 2.0 + 1e-9 * k}) for k in range(5)]
    assert judged(guard, moving)[-1] == (0.5, 0)
    coarse = Guard(checks=only("sensor-stuck", reading="y", longest=0.15, band=1e-6))
    assert judged(coarse, moving)[-1] == (0.0, 5)


def test_the_lowest_alarm_is_shown():
    checks = Checks(
        lost=CHECK["sensor-lost"](reading="T", timeout=0.5), current=CHECK["over-current"](reading="I", limit=2.0)
    )
    rows: list[tuple[float, dict[str, float]]] = [(1.0, {"T.age": 0.1, "I": -3.0}), (1.0, {"T.age": 0.6, "I": 0.0})]
    assert [a for _, a in judged(Guard(checks=checks), rows[::-1])] == [4, 2]
    assert [a for _, a in judged(Guard(checks=checks, answer="resume"), rows)] == [2, 4]


def test_only_the_drives_of_a_check_are_cut():
    one = CHECK["overheat"](reading="T", limit=400.0, drives=("left",))
    guard = Guard(checks=Checks(one=one), safe=0.1)
    verdict = guard.judge(floats, guard.rest(floats, {}), {"left": 1.0, "right": 0.7}, {"T": 500.0}, 0.1)
    assert verdict.signals == {"left": 0.1, "right": 0.7}


def test_every_check_has_its_alarm():
    numbers = [number for number in alarm_names() if number]
    assert numbers == list(range(1, len(numbers) + 1))
    assert sum(len(names.split(", ")) for names in alarm_names().values()) == 1 + len(CHECKS.names())
    assert SUPERVISORS.names() == ["guard"]


# ---------------------------------------------------------------- what does not fit


def test_a_signal_of_a_cut_that_is_not_safe_is_refused():
    with pytest.raises(ParameterError, match="choose a smaller `safe`"):
        Guard(checks=Checks(one=bound()), safe=0.5)


@pytest.mark.parametrize(
    ("check", "words"),
    [
        (CHECK["overheat"](reading="warmth", limit=400.0), "reads `warmth`, which is not measured"),
        (CHECK["overheat"](reading="temperature", limit=400.0, drives=("left",)), "names drive `left`"),
        (bound(drive="heater"), "names drive `heater`"),
    ],
)
def test_names_that_do_not_exist_are_refused(check, words):
    with pytest.raises(ParameterError, match=words):
        Bench(plant=WIRE, period=0.1, supervisor=Guard(checks=Checks(one=check)))


def test_a_bound_follows_the_heat_loss_that_a_reading_is_sure_of() -> None:
    one = bound(cooling="share")
    for share in (0.5, 2.0):
        memory = one.look(floats, (350.0,), {"drive": 0.3}, {"share": share}, 0.02).memory
        like = bound(conductance=share * one.conductance)
        assert one.find_most(floats, memory, 0.02) == like.find_most(floats, (350.0,), 0.02)
        assert one.remember_allowed(floats, memory, {"drive": 0.3}, 0.02) == (like.after(floats, 350.0, 0.3, 0.02),)
