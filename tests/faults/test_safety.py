"""Alarms: first time, duration and amount of every kind, found exactly on straight lines.

Source of truth: straight lines drawn here, whose crossings are known, and runs whose
temperature, stress or demand is prescribed.
"""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest
from builders import ZERO, chamber, hanging_wire, law_a, plain_law, problem_a, through

from martensite.actuators.assembly import System
from martensite.actuators.elements.limits import ElementLimits
from martensite.physics.electrical.base import AbstractSource
from martensite.physics.electrical.sources import CurrentSource, PowerSource, PrescribedTemperature, VoltageSource
from martensite.physics.electrical.switches import PwmVoltage
from martensite.scenario.netcdf import describe_result
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.step import Step
from martensite.simulate.alarms import Alarm, alarms_of, find_excursion, find_undelivered
from martensite.simulate.api import simulate
from martensite.simulate.result import Result


def only(result: Result, kind: str) -> Alarm:
    (alarm,) = [a for a in result.alarms if a.kind == kind]
    assert alarm.sentence in result.warnings
    return alarm


def when(alarm: Alarm) -> tuple[float, float, float]:
    return alarm.first, alarm.duration, alarm.worst_time


# ---------------------------------------------------------------- straight lines


def test_a_crossing_between_samples_is_found_exactly() -> None:
    found = find_excursion([0.0, 1.0, 2.0, 3.0], [-1.0, 3.0, 1.0, -3.0])
    assert found is not None
    assert (found.first, found.duration, found.worst) == (0.25, 0.75 + 1.0 + 0.25, 1)


def test_excursions_add_up_and_the_first_counts() -> None:
    found = find_excursion([0.0, 2.0, 4.0, 6.0], [1.0, -1.0, -1.0, 3.0])
    assert found is not None
    assert (found.first, found.duration, found.worst) == (0.0, 1.0 + 1.5, 3)


@pytest.mark.parametrize("margins", [[-1.0, -2.0], [0.0, 0.0], [-float("inf")] * 2])
def test_what_only_touches_the_limit_is_none(margins: list[float]) -> None:
    assert find_excursion([0.0, 1.0], margins) is None


# ---------------------------------------------------------------- limits of the element


def limited(**limits: float) -> System:
    return chamber(law_a(), mass=1.0, limits=ElementLimits(**limits))


def test_overheating_on_a_ramp() -> None:
    """From 20 to 120 °C in 10 s and back: above 95 °C from 7.5 s on, for 5 s."""
    wave = through([20.0 + ZERO, 120.0 + ZERO, 20.0 + ZERO], 10.0)
    run = simulate(limited(temperature_limit=95.0 + ZERO), wave, 20.0, step=0.1, samples=7)
    alarm = only(run, "temperature")
    assert when(alarm) == pytest.approx((7.5, 5.0, 10.0), rel=1e-9)
    assert (alarm.worst, alarm.excess) == pytest.approx((120.0 + ZERO, 25.0))
    assert (alarm.quantity, alarm.unit, alarm.limit) == ("hottest", "K", 95.0 + ZERO)
    assert run.warnings == [
        "Warning: temperature reaches 120 °C, above the `temperature_limit` of 95 °C, "
        "first at t = 7.5 s, for 5 s in all."
    ]


def test_the_hottest_place_counts_not_the_mean() -> None:
    run = simulate(limited(temperature_limit=350.0), Constant(level=300.0), 1.0, step=0.5)
    columns = {**run.columns, "hottest": [360.0] * len(run.times)}
    assert [a.kind for a in alarms_of(run.system, run.times, columns)] == ["temperature"]
    assert run.alarms == []


def test_overstress_has_its_amount() -> None:
    """A spring of 1 N/mm pulls harder as the wire shortens."""
    system = problem_a(source=PowerSource())
    hot = Constant(level=2.5)
    free = simulate(system, hot, 20.0, step=0.02, samples=201)
    limit = 0.5 * (min(free["stress"]) + max(free["stress"]))
    run = simulate(system.with_values({"element.limits.stress_limit": limit}), hot, 20.0, step=0.02, samples=201)
    alarm = only(run, "stress")
    assert alarm.excess == pytest.approx(max(free["stress"]) - limit)
    k = next(i for i, value in enumerate(free["stress"]) if value > limit)
    assert free.times[k - 1] <= alarm.first <= free.times[k]
    assert alarm.duration == pytest.approx(20.0 - alarm.first)


def test_overstrain_is_a_change_either_way() -> None:
    """Thermal strain alone, linear in T: 4 % of the way there is 0.4 of the way back."""
    system = chamber(plain_law(), mass=1.0)
    run = simulate(system, through([300.0, 360.0, 300.0], 10.0), 20.0, step=0.01, samples=401)
    span = run.range("strain")
    strict = system.with_values({"element.limits.strain_limit": 0.25 * span})
    run = simulate(strict, through([300.0, 360.0, 300.0], 10.0), 20.0, step=0.01, samples=401)
    alarm = only(run, "strain")
    assert alarm.worst == pytest.approx(span, rel=1e-12)
    assert alarm.excess == pytest.approx(0.75 * span, rel=1e-12)
    columns = run.columns["strain"]
    k = next(i for i, e in enumerate(columns) if columns[0] - e > 0.25 * span)
    assert run.times[k - 1] <= alarm.first <= run.times[k]
    assert f"strain varies by {100 * span:.3g} %" in alarm.sentence


def test_slack_has_a_time_and_a_duration() -> None:
    """The wire of problem A is longer warm martensite than its spring is at rest."""
    run = simulate(problem_a(), Constant(level=0.0), 1.0, step=0.1, samples=11)
    forces = [3.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    (alarm,) = alarms_of(run.system, run.times, {**run.columns, "force": forces})
    assert alarm.kind == "slack"
    assert when(alarm) == pytest.approx((0.2, 0.3, 0.2))
    assert alarm.sentence == ("Warning: the element is slack (no force), first at t = 0.2 s, for 0.3 s in all.")
    never = {**run.columns, "force": [0.0] * 11}
    assert alarms_of(run.system, run.times, never) == []


# ---------------------------------------------------------------- supply

OHMS = 8.3 * 1.15 * 0.25
"""Of the cold wire; the ramps below are too short to change it."""


@pytest.mark.parametrize(
    ("source", "most"),
    [
        (VoltageSource(voltage_limit=3.0, series_resistance=0.5), 3.0),
        (VoltageSource(current_limit=0.5, series_resistance=0.5), 0.5 * (OHMS + 0.5)),
        (CurrentSource(current_limit=0.5), 0.5),
        (CurrentSource(voltage_limit=3.0, series_resistance=0.5), 3.0 / (OHMS + 0.5)),
        (PowerSource(voltage_limit=1.0), 1.0 / OHMS),
        (PowerSource(current_limit=0.3), 0.09 * OHMS),
        (PwmVoltage(supply=1.0), 1.0),
    ],
)
def test_saturation_on_a_ramp(source: AbstractSource, most: float) -> None:
    """The demand passes what can be delivered at 0.04 s, and ends at 2.5 times as much."""
    system = hanging_wire(mass=1.0, source=source)
    run = simulate(system, Ramp(high=2.5 * most, end=0.1), 0.1, step=1e-3, samples=8)
    alarm = only(run, "supply")
    assert when(alarm) == pytest.approx((0.04, 0.06, 0.1), rel=1e-8)
    assert (alarm.worst, alarm.limit) == pytest.approx((2.5 * most, most), rel=1e-12)
    assert alarm.excess == pytest.approx(1.5 * most, rel=1e-12)
    assert alarm.unit == source.unit
    delivered = {"V": "voltage", "A": "current", "W": "power"}.get(source.unit)
    if delivered == "voltage":
        total = run["current"][-1] * (OHMS + source.series_resistance)  # type: ignore[attr-defined]
        assert total == pytest.approx(most, rel=1e-9)
    elif delivered:
        assert run[delivered][-1] == pytest.approx(most, rel=1e-9)


def test_a_demand_for_cooling_is_not_delivered() -> None:
    run = simulate(hanging_wire(), Constant(level=-1.0), 1.0, step=0.1, samples=11)
    alarm = only(run, "supply")
    assert (alarm.worst, alarm.limit, alarm.excess) == (-1.0, 0.0, 1.0)
    assert when(alarm) == (0.0, 1.0, 0.0)


def test_both_directions_of_a_voltage_count() -> None:
    system = hanging_wire(source=VoltageSource(voltage_limit=1.0))
    run = simulate(system, Constant(level=-1.5), 0.1, step=0.1, samples=3)
    assert only(run, "supply").limit == -1.0


@pytest.mark.parametrize(
    "source",
    [
        VoltageSource(voltage_limit=1.0),
        CurrentSource(current_limit=1.0),
        PwmVoltage(supply=3.0),
        PrescribedTemperature(),
    ],
)
def test_a_demand_that_is_just_met_is_no_alarm(source: AbstractSource) -> None:
    times, drive, ohms = [0.0, 1.0], [1.0, 1.0], [0.7, 0.3]
    assert find_undelivered(source, times, drive, ohms) is None


# ---------------------------------------------------------------- where alarms go


def test_a_run_within_its_limits_has_none() -> None:
    run = simulate(hanging_wire(mass=1.0), Constant(level=0.5), 1.0, step=0.1)
    assert (run.alarms, run.warnings) == ([], [])


def test_alarms_are_saved_with_the_data() -> None:
    run = simulate(hanging_wire(), Constant(level=-1.0), 1.0, step=0.1, samples=11)
    saved = json.loads(describe_result(run).attrs["alarms"])
    assert saved == [asdict(alarm) for alarm in run.alarms]


def test_a_pulse_between_two_samples_raises_the_same_alarm() -> None:
    """Alarms come from the steps; one from the samples alone would miss the pulse."""
    system = hanging_wire(source=PowerSource(current_limit=0.1))
    pulse = Step(high=5.0, at=0.41, until=0.44)
    coarse = simulate(system, pulse, 1.0, step=0.01, samples=11)
    fine = simulate(system, pulse, 1.0, step=0.01, samples=101)
    assert only(coarse, "supply").first == only(fine, "supply").first == pytest.approx(0.41, rel=1e-12)
    assert only(coarse, "supply").duration == pytest.approx(0.03, rel=1e-9)
    assert alarms_of(system, coarse.times, coarse.columns) == []
