"""Guards that trip: limits that are asked for, signals that are lowered, and the worst that a guard lets through.

Source of truth: closed forms of the bound, and wires simulated under signals that nothing else holds back. Every
bound is tried beside a run without a guard, which passes it.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.control.faults import build_faults
from builders import problem_a

from martensite.actuators.elements.limits import ElementLimits
from martensite.base.errors import InputError, ParameterError
from martensite.base.parameters import REQUIRED
from martensite.control.checks.base import CHECKS, Checks
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import FaultTable, MountedSensor, Sensors
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.control.sensors.thermometer import ThermocoupleSensor
from martensite.control.supervisors.from_plant import build_thermal_guard, find_bound, worst_power
from martensite.control.supervisors.guard import Guard
from martensite.control.supervisors.worst_case import find_transformation_end, find_worst_case
from martensite.kernels import floats
from martensite.physics.electrical.sources import CurrentSource, LinearAmplifier
from martensite.physics.electrical.switches import Mosfet
from martensite.scenario.guard_report import collect_guard
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.signals.held import Held

EXAMPLES = Path(__file__).parents[2] / "examples"
LOOP = EXAMPLES / "closed_loop.toml"
CHECK: Any = CHECKS
LIMIT, PERIOD, SECONDS = 413.15, 0.05, 12.0
WIRE = problem_a().with_parts(source=Mosfet(supply=6.0, frequency=1e3, on_resistance=0.1))
ROUNDING = 1e-6


# ---------------------------------------------------------------- limits that are asked for

NEEDED = {"sensor-lost": "timeout", "sensor-stuck": "longest", "open-circuit": "longest"}


@pytest.mark.parametrize("name", CHECKS.names())
def test_a_check_without_its_limit_is_refused(name: str) -> None:
    needed = NEEDED.get(name, "limit")
    numbers: dict[str, Any] = {"power": 1.0, "capacity": 1.0, "conductance": 1.0, "ambient": 300.0}
    words: dict[str, Any] = {"reading": "a"} | ({"other": "b"} if name == "mismatch" else {})
    given = numbers if name == "thermal-bound" else words
    if CHECKS[name].declarations[needed].default is REQUIRED:
        with pytest.raises(ParameterError, match=f"`{name}` needs `{needed}`"):
            CHECKS[name](**given)
    with pytest.raises(ParameterError, match=f"`{needed}` of `{name}` must be finite"):
        CHECKS[name](**(given | {needed: math.inf}))


def change_guarded(**changes: Any) -> Scenario:
    """The example of a guard that sees the temperature; without its limit."""
    text = (EXAMPLES / "closed_loop_guarded.toml").read_text(encoding="utf-8")
    assert 'limit = "110 degC"\n' in text
    return read_scenario(text.replace('limit = "110 degC"\n', ""), None, changes)


def test_a_limit_that_the_material_knows_is_taken() -> None:
    """Without it this loop went on to 168 °C with no alarm."""
    scenario = change_guarded()
    (row,) = (collect_guard(scenario) or {})["checks"]
    assert row["trips"] == "overheat: heat 140 °C"
    assert row["from"] == "element.limits.temperature_limit, assumed, flexinol-90"
    result = scenario.run()
    assert 1.0 in result["alarm"]
    assert any("cut a signal by `hot` (alarm 1), first at t = " in one for one in result.warnings)
    with pytest.raises(InputError, match=r"\[supervisor.checks.hot\] `over-force` needs `limit`"):
        change_guarded(**{"supervisor.checks.hot": {"kind": "over-force", "reading": "heat"}})


def test_a_check_may_read_what_an_observer_believes() -> None:
    """Beside the guard by default, which limits; this one cuts for good."""
    believed = {"kind": "overheat", "reading": "estimated.temperature"}
    found = collect_guard(load(EXAMPLES / "closed_loop_sensorless.toml", {"supervisor.checks.believed": believed}))
    rows = {row["check"]: (row["trips"], row["then"]) for row in (found or {})["checks"]}
    assert rows["believed"] == ("overheat: estimated.temperature 140 °C", "switches drive off permanently")
    assert rows["bound_drive"][1] == "limits drive"


# ---------------------------------------------------------------- the guard by default


def shorten(path: Path = LOOP, **changes: Any) -> Scenario:
    settings = {name.replace("__", "."): value for name, value in changes.items()}
    return load(path, {"run.duration": "3 s", **settings})


def test_a_loop_has_a_guard_that_lets_a_healthy_signal_pass() -> None:
    guarded, free = shorten(), shorten(supervisor={"kind": "none"})
    assert guarded.bench is not None
    guard = guarded.bench.supervisor
    assert isinstance(guard, Guard)
    assert guard.answer == "limit"
    assert guard.checks.members() == build_thermal_guard(guarded.system).checks.members()
    assert any("Nothing guards this loop" in one for one in free.cautions)
    found, plain = guarded.run(), free.run()
    assert set(found["alarm"]) == {0.0}
    assert all(np.array_equal(found[name], plain[name]) for name in plain.columns)
    assert (collect_guard(free) or {})["worst"][0]["check"] == ""


def test_its_numbers_can_be_changed() -> None:
    known = {"temperature_limit": "60 degC", "hottest": "30 degC", "least_cooling": 0.8}
    scenario = shorten(supervisor__from_plant=known, supervisor__safe=0.0)
    assert scenario.bench is not None
    (bound,) = scenario.bench.supervisor.checks.members().values()  # type: ignore[union-attr]
    assert (bound.limit, bound.ambient) == (pytest.approx(333.15), pytest.approx(303.15))
    result = scenario.run()
    assert set(result["alarm"]) == {0.0, 108.0}
    assert max(result["temperature"]) < 333.15
    words = "limited a signal by `bound_drive` (alarm 108), first at t = "
    assert any(words in one for one in result.warnings)


def test_a_guard_can_expect_more_cooling_than_the_wire_has_and_then_promises_nothing() -> None:
    believing = shorten(supervisor__from_plant={"least_cooling": 2.0})
    assert (collect_guard(believing) or {})["worst"][0]["check"] == ""


def test_what_cannot_be_guarded_is_said() -> None:
    platform = EXAMPLES / "closed_loop_platform.toml"
    assert any("No guard: the element at `first` has no `temperature_limit`" in one for one in load(platform).cautions)
    given = load(platform, {"supervisor.from_plant": {"temperature_limit": "80 degC"}})
    assert given.bench is not None
    checks: Any = given.bench.supervisor.checks.members()  # type: ignore[union-attr]
    assert (list(checks), checks["bound_first"].cuts(), checks["bound_first"].full) == (
        ["bound_first"],
        ("first",),
        5.0,
    )


@cache
def broken() -> tuple[Scenario, dict[str, Any]]:
    """The example under 8 V, whose full signal leads to 395 °C, and the faults of the benchmark."""
    scenario = load(LOOP, {"driver.supply": "8 V"})
    assert scenario.bench is not None
    return scenario, build_faults(scenario.bench, scenario.duration, span=4e-3)


def run_fault(guarded: bool, **changes: float) -> Any:
    """A run with the faults that are given, by the name of a fault and what is changed."""
    scenario, faults = broken()
    bench: Any = scenario.bench
    never = {name.replace("-", "_"): one.with_parts(start=1e6, end=math.inf) for name, one in faults.items()}
    whole = bench.with_parts(faults=FaultTable(**never), supervisor=bench.supervisor if guarded else None)
    values = {f"faults.{name.replace('__', '.')}": value for name, value in changes.items()}
    return simulate_bench(whole.with_values(values), 16.0)


def test_a_sensor_that_is_lost_does_not_burn_a_guarded_loop() -> None:
    for name in ("drop_out", "stuck"):
        lost = {f"{name}__start": 8.0}
        guarded, free = run_fault(True, **lost), run_fault(False, **lost)
        assert max(guarded["temperature"]) < LIMIT < max(free["temperature"]) - 20.0
        assert set(guarded["alarm"]) == {0.0, 108.0}


def test_no_guard_acts_on_a_driver_that_does_not_obey() -> None:
    found = run_fault(True, stuck_on__start=8.0, stuck_on__level=1.0)
    assert max(found["temperature"]) > LIMIT + 50.0
    assert any("above the `temperature_limit`" in one for one in found.warnings)


# ---------------------------------------------------------------- a signal that is lowered


def bound(**changes: Any) -> ThermalBound:
    numbers: dict[str, Any] = {"limit": 400.0, "power": 10.0, "capacity": 0.1, "conductance": 0.03, "ambient": 300.0}
    return ThermalBound(**(numbers | changes))


@pytest.mark.parametrize("rises", ["linear", "square"])
@pytest.mark.parametrize("now", [300.0, 370.0, 400.0])
def test_the_largest_signal_ends_at_the_limit(rises: str, now: float) -> None:
    one = bound(rises=rises, full=5.0)
    most = one.find_most(floats, (now,), 0.2)["drive"]
    assert one.after(floats, now, most, 0.2) == pytest.approx(400.0, rel=1e-12)
    assert one.after(floats, now, -1.01 * most, 0.2) > 400.0


def test_a_signal_is_lowered_and_keeps_its_direction() -> None:
    guard = Guard(checks=Checks(one=bound()), answer="limit")
    most = bound().find_most(floats, (400.0,), 0.2)["drive"]
    for wanted, expected in ((1.0, most), (-1.0, -most), (0.5 * most, 0.5 * most), (math.nan, 0.0)):
        found = guard.judge(floats, (0.0, 0.0, 400.0), {"drive": wanted}, {}, 0.2)
        assert found.signals["drive"] == pytest.approx(expected, rel=1e-12)
        assert found.alarm == (0.0 if wanted == 0.5 * most else 108.0)
    both = Guard(checks=Checks(one=bound(), hot=CHECK["overheat"](reading="T", limit=390.0)), answer="limit")
    memory = both.rest(floats, {"T": 300.0})
    for reading, expected in ((380.0, 108.0), (395.0, 1.0), (380.0, 1.0)):
        found = both.judge(floats, (*memory[:2], 400.0, *memory[3:]), {"drive": 1.0}, {"T": reading}, 0.2)
        memory = found.memory
        assert found.alarm == expected
    assert found.signals == {"drive": 0.0}


def test_a_loop_on_a_computer_limits_as_the_bench_does() -> None:
    scenario = shorten(supervisor__from_plant={"temperature_limit": "60 degC"}, bench__noise="none")
    assert scenario.bench is not None
    result, loop = scenario.run(), RealtimeStep(scenario.bench)
    rows = zip(result["measured.position"], result["drive"], result["alarm"], strict=True)
    for k, (position, signal, alarm) in enumerate(rows):
        (found,) = loop.step({"position": position, "position.age": 0.02})
        assert found == pytest.approx(signal, abs=1e-9), k
        assert loop.state.alarm == alarm


# ---------------------------------------------------------------- the worst case


def draw_signals(seed: int) -> list[tuple[float, ...]]:
    """Full signal all the time; full after a rest that cools; full and none by chance."""
    count, rng = round(SECONDS / PERIOD) + 1, np.random.default_rng(seed)
    rest = np.arange(count) % 120 < rng.integers(30, 110)
    chance = np.repeat(rng.random(count // 8 + 1) < 0.7, 8)[:count]
    return [tuple(np.asarray(row, float)) for row in (np.ones(count), rest, chance)]


FELT = ThermocoupleSensor(attachment=0.85, lag=0.4, noise=0.2, resolution=0.25)
SEEN = MountedSensor(sensor=FELT, sample_time=0.1, delay=0.08, jitter=0.01)


@cache
def guarded(by: str, answer: str) -> Bench:
    bounds: dict[str, Any] = {"bound": find_bound(WIRE, "drive", LIMIT, 1.0)}
    felt = {"hot": CHECK["overheat"](reading="felt", limit=370.0, band=5.0)}
    guard = Guard(checks=Checks(**(bounds if by == "bound" else felt)), answer=answer)
    return Bench(plant=WIRE, period=PERIOD, substeps=2, sensors=Sensors(felt=SEEN), supervisor=guard)


def find_hottest(bench: Bench, seed: int) -> float:
    """Hottest temperature [K] of all signals that are drawn."""
    runs = [{"drive": Held(values=row, frequency=1.0 / PERIOD)} for row in draw_signals(seed)]
    return max(max(simulate_bench(bench, SECONDS, waveforms=one, seed=seed)["temperature"]) for one in runs)


@pytest.mark.parametrize(("by", "answer"), [("bound", "limit"), ("bound", "latch"), ("felt", "resume")])
def test_no_signal_passes_the_worst_case(by: str, answer: str) -> None:
    bench = guarded(by, answer)
    worst = find_worst_case(bench, "drive", 1.0)
    assert worst.check == ("bound" if by == "bound" else "hot")
    hottest = max(find_hottest(bench, seed) for seed in range(3))
    assert hottest <= worst.guarded + ROUNDING
    if answer != "latch":
        assert hottest > (LIMIT - 30.0 if by == "bound" else 370.0)
    free = find_hottest(bench.with_parts(supervisor=None), 0)
    assert worst.guarded < free <= worst.free


def test_a_bound_that_was_told_less_than_the_plant_brings_is_none() -> None:
    bench, told = guarded("bound", "limit"), find_bound(WIRE, "drive", LIMIT, 1.0)
    for name, share in (("power", 0.9), ("capacity", 1.1), ("conductance", 1.1), ("ambient", 0.99)):
        path = f"supervisor.checks.bound.{name}"
        weak = bench.with_values({path: share * told.value_of(name)})
        assert find_worst_case(weak, "drive", 1.0).check == ""


def test_martensite_that_is_left_lifts_the_worst_case() -> None:
    """Liang and Rogers: the strip ends at A_f + σ/C_A."""
    stress = 400e6
    element = WIRE.element.with_parts(limits=ElementLimits(stress_limit=stress, temperature_limit=LIMIT))
    one: Any = WIRE.with_parts(element=element)
    end = element.law.value_of("A_f") + stress / element.law.value_of("C_A")
    actuator = next(iter(one.actuators().values()))
    assert find_transformation_end(actuator, 320.0) == pytest.approx(end, abs=1.5)
    assert find_transformation_end(actuator, end + 5.0) == end + 5.0


def test_pulses_go_above_their_mean() -> None:
    bench = guarded("bound", "limit")
    pulsed = find_worst_case(bench.with_parts(switching="pulses", substeps=0), "drive", 1.0)
    plain = find_worst_case(bench, "drive", 1.0)
    assert pulsed.guarded > plain.guarded == LIMIT


def test_the_power_of_a_source_at_its_limit_is_bounded_below_it_too() -> None:
    """At 1 V a source of current gives less at 5 A than a parabola through it would give at 0.3 A."""
    limited: Any = WIRE.with_parts(source=CurrentSource(voltage_limit=1.0))
    actuator = next(iter(limited.actuators().values()))
    most = worst_power(actuator, LIMIT, 5.0)
    for current in (0.1, 0.3, 1.0, 5.0):
        for ohms in (limited.element.ohms(floats, xi, 0.05, 350.0, 0.0) for xi in (0.0, 0.5, 1.0)):
            real = limited.source.current(floats, current, ohms) ** 2 * ohms
            assert real <= most * (current / 5.0) ** 2 * (1.0 + 1e-12)
    off = WIRE.with_parts(source=LinearAmplifier(offset=0.5, voltage_limit=5.0))
    with pytest.raises(InputError, match="heats without a signal"):
        find_bound(next(iter(off.actuators().values())), "drive", LIMIT, 5.0)
