"""Every registered observer, fault, check and supervisor does on a bench what it promises.

Observers run beside the plant: C does what floats do.
Faults leave no trace before they begin and disturb nothing once they are over. Guards are silent
while all is well, and cut as they say when it is not. The plant is the wire of problem A under a
switched voltage; all faults and all checks share one program, in which most of them never act.
That kernels mean the same on every runtime is checked with those of all other parts.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest
from builders import example, problem_a

from martensite.base.errors import ParameterError
from martensite.control.checks import base as checks_base
from martensite.control.checks.base import CHECKS, CheckResult, Checks, alarm_names
from martensite.control.checks.reading import Overheat
from martensite.control.faults.base import FAULTS
from martensite.control.faults.plant import SupplySag
from martensite.control.faults.sensor import Stuck
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import SUPERVISORS, FaultTable, MountedSensor, Observers, Sensors
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.base import ESTIMATED, OBSERVERS
from martensite.control.sensors.position import IdealSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.control.supervisors.from_plant import build_thermal_guard
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.sine import Sine

PLANT = problem_a(source=PwmVoltage(supply=6.0))
PERIOD, SAMPLES = 0.05, 60
HEATING = Sine(low=0.05, high=0.3, frequency=0.4)
LATE = 1e6
"""When nothing is looked at any more [s]."""
FIRST, LAST = 20, 35
"""Samples in which a fault is there, the last one not."""

Columns = dict[str, np.ndarray]


def columns(bench: Bench, runtime: str | None = None, seed: int | None = None) -> Columns:
    """A run of a bench, heated from outside."""
    waves = {"drive": HEATING}
    end = SAMPLES * PERIOD
    found = simulate_bench(bench, end, waveforms=waves, seed=seed, runtime=runtime)
    return {"time": np.array(found.times)} | {n: np.array(c) for n, c in found.columns.items()}


def agree(one: Columns, other: Columns) -> None:
    """Raise unless two runs are one, to 1e-7 of the size of each column."""
    for name, values in one.items():
        size = max(np.ptp(values), 1e-3 * np.abs(values).max())
        np.testing.assert_allclose(values, other[name], rtol=0.0, atol=1e-7 * size, err_msg=name)


# ---------------------------------------------------------------- observers


@cache
def observer(name: str) -> Any:
    return example(OBSERVERS[name], model=PLANT)


def watched(one: Any) -> Bench:
    meter = MountedSensor(sensor=ResistanceSensor(relative_noise=0.005))
    return Bench(
        plant=PLANT, period=PERIOD, substeps=1, sensors=Sensors(resistance=meter), observers=Observers(wire=one)
    )


@pytest.mark.parametrize("name", OBSERVERS.names())
def test_an_observer_is_the_same_in_c(name: str, c_compiler: str) -> None:
    bench = watched(observer(name))
    plain = columns(bench, "floats", seed=3)
    assert {ESTIMATED + n for n in observer(name).estimates()} <= set(plain)
    agree(plain, columns(bench, "c", seed=3))


def test_two_observers_of_the_same_thing_are_refused() -> None:
    twice = Observers(one=observer("inverse-model"), other=observer("extended-kalman"))
    with pytest.raises(ParameterError, match="`one` and `other` both estimate `temperature`"):
        watched(observer("inverse-model")).with_parts(observers=twice)


# ---------------------------------------------------------------- faults and checks


WATCHED: dict[str, dict[str, Any]] = {
    "overheat": {"reading": "felt", "limit": 420.0},
    "over-current": {"reading": "current", "limit": 3.0},
    "over-stress": {"reading": "stress", "limit": 1e9},
    "over-force": {"reading": "force", "limit": 100.0},
    "sensor-lost": {"reading": "felt", "timeout": 0.12},
    "sensor-stuck": {"reading": "felt", "longest": 0.12},
    "open-circuit": {"reading": "current", "longest": 0.12, "most": 0.01, "least": 0.01},
    "mismatch": {"reading": "felt", "other": "again", "limit": 0.5},
    "low-confidence": {"reading": "trust", "limit": 0.5, "longest": 0.12},
}
"""Checks as they are set on a bench on which all is well; the bound comes from the plant."""
FAULTY: dict[str, dict[str, Any]] = {
    "ambient-step": {"by": 20.0},
    "clamped": {},
    "contact-resistance": {"resistance": 1.0},
    "draught": {"factor": 2.0},
    "drift": {"sensor": "felt", "bias": 1.0, "rate": 2.0},
    "drop-out": {"sensor": "felt"},
    "late-readings": {"sensor": "felt", "by": 0.1},
    "noise-burst": {"sensor": "felt", "deviation": 1.0},
    "open-circuit": {},
    "slack": {"length": 1e-3},
    "stuck": {"sensor": "felt"},
    "stuck-on": {"level": 0.4},
    "supply-sag": {"share": 0.5},
    "supply-surge": {"share": 1.3},
}
SAFE = 0.01
UNGUARDED = {
    "overheat.limit": 1e9,
    "over-current.limit": 1e9,
    "over-stress.limit": 1e12,
    "over-force.limit": 1e9,
    "sensor-lost.timeout": LATE,
    "sensor-stuck.longest": LATE,
    "open-circuit.longest": LATE,
    "mismatch.limit": 1e9,
    "low-confidence.longest": LATE,
    "thermal-bound.limit": 1e9,
}
TRIPPED: dict[str, tuple[dict[str, float], str | None]] = {
    "overheat": ({"limit": 310.0}, None),
    "over-current": ({"limit": 1.0}, None),
    "over-stress": ({"limit": 45e6}, None),
    "over-force": ({"limit": 5.1}, None),
    "sensor-lost": ({}, "drop-out"),
    "sensor-stuck": ({}, "stuck"),
    "open-circuit": ({}, "open-circuit"),
    "mismatch": ({}, "drift"),
    "low-confidence": ({"limit": 0.999}, None),
    "thermal-bound": ({"limit": 330.0}, None),
}
"""What makes each check trip: other numbers of its own, or a fault."""


def named(name: str) -> str:
    return name.replace("-", "_")


@cache
def guarded() -> Bench:
    """A bench with every fault, none of which begins, and a guard with every check."""
    sensors = {"felt": "temperature", "again": "temperature", "trust": "martensite_fraction"}
    sensors |= {name: name for name in ("current", "stress", "force")}
    bound = build_thermal_guard(PLANT, temperature_limit=430.0).checks.members()["bound_drive"]
    checks = {named(name): CHECKS[name](**given) for name, given in WATCHED.items()}
    return Bench(
        plant=PLANT,
        period=PERIOD,
        substeps=1,
        sensors=Sensors(**{n: MountedSensor(sensor=IdealSensor(), of=(o,)) for n, o in sensors.items()}),
        supervisor=Guard(checks=Checks(**checks, thermal_bound=bound), safe=SAFE),
        faults=FaultTable(**{named(n): FAULTS[n](**g, start=LATE) for n, g in FAULTY.items()}),
    )


def checks_at(values: dict[str, float]) -> dict[str, float]:
    return {f"supervisor.checks.{named(name)}": value for name, value in values.items()}


def window(name: str) -> dict[str, float]:
    """A fault in its samples."""
    place = f"faults.{named(name)}"
    return {f"{place}.start": FIRST * PERIOD, f"{place}.end": LAST * PERIOD}


def run(values: dict[str, float]) -> Columns:
    """The bench with other numbers, in C if there is a compiler."""
    return columns(guarded().with_values(values), seed=0)


@cache
def healthy() -> Columns:
    return run({})


def leaves_no_trace(found: Columns, well: Columns) -> None:
    """Raise unless all is bit for bit the same before a fault, and something is not in it."""
    for name, values in found.items():
        np.testing.assert_array_equal(values[:FIRST], well[name][:FIRST], err_msg=name)
    inside = slice(FIRST, LAST)
    assert any((values[inside] != well[name][inside]).any() for name, values in found.items())


def is_over(found: Columns) -> None:
    """Raise unless readings, current and heat loss are as they must be once a fault is over."""
    after = slice(LAST, SAMPLES)
    source, element = PLANT.source, PLANT.element
    felt = found.get("measured.felt", found["temperature"])
    np.testing.assert_array_equal(felt[after], found["temperature"][after])
    times, kelvins, ohms = (found[name][after].tolist() for name in ("time", "temperature", "resistance"))
    rows = zip(map(HEATING.value, times), ohms, strict=True)
    currents = [source.current(floats, u, R) for u, R in rows]
    losses = [element.heat_loss(floats, T, PLANT.environment) for T in kelvins]
    np.testing.assert_allclose(found["current"][after], currents, rtol=1e-9)
    np.testing.assert_allclose(found["heat_loss"][after], losses, rtol=1e-9)


@pytest.mark.parametrize("name", FAULTS.names())
def test_a_fault_is_there_from_its_start_to_its_end(name: str) -> None:
    found = run(window(name) | checks_at(UNGUARDED))
    leaves_no_trace(found, run(checks_at(UNGUARDED)))
    is_over(found)


def test_faults_and_guard_are_the_same_in_c(c_compiler: str) -> None:
    """All faults one after the other, and two checks that trip in the end."""
    values = {"supervisor.checks.overheat.limit": 380.0, "supervisor.checks.mismatch.limit": 4.0}
    for k, name in enumerate(FAULTS.names()):
        place = f"faults.{named(name)}"
        values |= {f"{place}.start": 0.2 * k + 0.1, f"{place}.end": 0.2 * k + 0.5}
    quiet = checks_at({"sensor-lost.timeout": LATE, "sensor-stuck.longest": LATE})
    quiet |= checks_at({"open-circuit.longest": LATE, "low-confidence.longest": LATE})
    bench = guarded().with_values(values | quiet)
    plain = columns(bench, "floats")
    assert plain["alarm"].max() > 0.0
    agree(plain, columns(bench, "c"))


def is_silent(found: Columns, free: Columns) -> None:
    """Raise unless a guard lets everything pass that passes without it."""
    assert set(found["alarm"]) == {0.0}
    np.testing.assert_array_equal(found["current"], free["current"])


def cuts(found: Columns, alarm: int, fault: str | None = None) -> None:
    """Raise unless from some sample on there is an alarm and the safe signal, and before not.

    Signals are told by the current, but while a fault is there, which may be in the current.
    """
    numbers = found["alarm"]
    assert set(numbers) == {0.0, alarm}
    assert (np.diff(numbers) >= 0.0).all()
    wanted = [HEATING.value(t) for t in found["time"].tolist()]
    signals = np.where(numbers > 0.0, SAFE, wanted)
    rows = zip(signals.tolist(), found["resistance"].tolist(), strict=True)
    expected = np.array([PLANT.source.current(floats, u, ohms) for u, ohms in rows])
    off = np.abs(found["current"] / expected - 1.0)
    if fault is not None:
        off[FIRST:LAST] = 0.0
    assert off.max() < 1e-9


@pytest.mark.parametrize("name", CHECKS.names())
def test_a_check_is_silent_until_it_trips_and_then_cuts(name: str) -> None:
    numbers, fault = TRIPPED[name]
    others = {k: v for k, v in UNGUARDED.items() if not k.startswith(f"{name}.")}
    alone = checks_at(others)
    is_silent(run(alone), run(checks_at(UNGUARDED)))
    changed = checks_at({f"{name}.{n}": v for n, v in numbers.items()})
    found = run(alone | changed | (window(fault) if fault else {}))
    cuts(found, CHECKS[name].alarm, fault)


def test_a_guard_is_silent_while_all_is_well() -> None:
    is_silent(healthy(), run(checks_at(UNGUARDED)))


def documented() -> dict[str, int]:
    """Name of a check -> number of its alarm, from the table of the documentation."""
    rows = re.findall(r"^\| (\d+) \| (`.+`) \|", checks_base.__doc__ or "", re.MULTILINE)
    numbers = [number for number, _ in rows]
    assert len(set(numbers)) == len(numbers)
    return {name: int(number) for number, names in rows for name in re.findall("`(.+?)`", names)}


def test_alarms_are_documented() -> None:
    assert documented() == {name: CHECKS[name].alarm for name in CHECKS.names()}
    assert sorted(alarm_names()) == list(range(len(alarm_names())))


def test_all_are_looked_at() -> None:
    assert sorted(FAULTY) == FAULTS.names()
    assert sorted(TRIPPED) == CHECKS.names()
    guard = guarded().supervisor
    assert isinstance(guard, Guard)
    assert SUPERVISORS.names() == [guard.registered_name]
    assert sorted(guard.checks.members()) == [named(n) for n in CHECKS.names()]


# ---------------------------------------------------------------- the suite can fail


def test_runs_that_differ_are_noticed() -> None:
    found = healthy()
    with pytest.raises(AssertionError, match="temperature"):
        agree(found, found | {"temperature": found["temperature"] * (1.0 + 1e-6)})


class Early(SupplySag):
    """Begins a little before its time, and never ends."""

    def active(self, xp: Any, time: Any) -> Any:
        return time >= self.start - 2.0 * PERIOD


class Mute(Stuck):
    """Does nothing."""

    def reading(self, xp: Any, sensor: str, reading: Any, last_reading: Any, active: Any) -> Any:
        return reading


class Nervous(Overheat):
    """Trips a little below its limit, and only then."""

    def look(self, xp: Any, memory: Any, *given: Any) -> CheckResult:
        looked = super().look(xp, memory, *given)
        return looked._replace(trips=given[0]["drive"] > 0.2)


class Leaky(Guard):
    """Lets a little more pass than it says."""

    def judge(self, xp: Any, memory: Any, *given: Any) -> Any:
        found = super().judge(xp, memory, *given)
        return found._replace(signals={"drive": 1.01 * found.signals["drive"]})


def small(**parts: Any) -> Columns:
    """A run of a bench with little on it, on floats."""
    bench = Bench(
        plant=PLANT,
        period=PERIOD,
        substeps=1,
        sensors=Sensors(felt=MountedSensor(sensor=IdealSensor(), of=("temperature",))),
        **parts,
    )
    return columns(bench, "floats")


def test_a_broken_fault_is_noticed() -> None:
    well, start, end = small(), FIRST * PERIOD, LAST * PERIOD
    early = small(faults=FaultTable(one=Early(share=0.5, start=start, end=end)))
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        leaves_no_trace(early, well)
    with pytest.raises(AssertionError, match="Not equal to tolerance"):
        is_over(early)
    with pytest.raises(AssertionError):
        mute = Mute(sensor="felt", start=start, end=end)
        leaves_no_trace(small(faults=FaultTable(one=mute)), well)


def test_a_broken_check_or_guard_is_noticed() -> None:
    free = small()
    nervous = small(supervisor=Guard(checks=Checks(one=Nervous(reading="felt", limit=1e9)), safe=SAFE))
    with pytest.raises(AssertionError):
        is_silent(nervous, free)
    hot = Checks(one=Overheat(reading="felt", limit=310.0))
    cuts(small(supervisor=Guard(checks=hot, safe=SAFE)), 1)
    with pytest.raises(AssertionError):
        cuts(small(supervisor=Leaky(checks=hot, safe=SAFE)), 1)
    with pytest.raises(AssertionError):
        cuts(small(supervisor=Guard(checks=hot, safe=2.0 * SAFE)), 1)
