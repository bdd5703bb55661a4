"""The loop: what a drive is told and when, what its signal does, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pytest
from builders import ZERO, chamber, hanging_wire, law_a

from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.base.parameters import Number, param, part
from martensite.base.status import Status
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.base import AbstractDrive
from martensite.signals.constant import Constant
from martensite.signals.held import Held
from martensite.signals.ramp import Ramp
from martensite.signals.staircase import Staircase
from martensite.simulate.api import simulate
from martensite.simulate.closed_loop import ELECTRICAL, simulate_loop
from martensite.simulate.controlled_run import simulate_controlled

OUTPUTS = hanging_wire().outputs()


class Scripted(AbstractDrive):
    """Signals one after the other; remembers what it was told."""

    signals: tuple[float, ...] = part("one per period")

    def init(self) -> list[Any]:
        return []

    def __call__(self, time: float, measurement: Mapping[str, float], memory: list[Any]) -> tuple[float, list[Any]]:
        told.append((time, dict(measurement)))
        return self.signals[len(memory)], [*memory, time]


class Thermostat(AbstractDrive):
    """Full power below the set point, else none."""

    below: Number = param("K", "set point")

    def init(self) -> None:
        """No memory."""

    def __call__(self, time: float, measurement: Mapping[str, float], memory: None) -> tuple[float, None]:
        return (2.0 if measurement["temperature"] < self.below else 0.0), None


told: list[tuple[float, dict[str, float]]] = []


@pytest.fixture(autouse=True)
def fresh() -> None:
    told.clear()


def test_a_held_signal_runs_as_its_staircase() -> None:
    system = hanging_wire(mass=1.0)
    stairs = Staircase(first=0.5, increment=0.5, hold=0.5, count=5)
    loop = simulate_loop(system, stairs, 3.0, 0.5, step=0.01)
    run = simulate(system, stairs, 3.0, step=0.01, samples=7)
    for name in OUTPUTS:
        assert loop.result[name] == pytest.approx(run[name], rel=1e-10, abs=1e-13), name
    assert loop.signals == [0.5, 1.0, 1.5, 2.0, 2.5, 2.5]
    assert loop.means["drive"] == pytest.approx(loop.signals)
    assert loop.result.waveform == Held(values=tuple(loop.signals), frequency=2.0)


def test_means_are_means() -> None:
    """Energy: mean power times time is what is stored and lost."""
    system = hanging_wire()
    loop = simulate_loop(system, Constant(level=0.4), 2.0, 0.5, step=1e-3)
    stored = system.element.heat_capacity_total() * loop.result.range("temperature")
    gained = sum(p - q for p, q in zip(loop.means["power"], loop.means["heat_loss"], strict=True))
    assert 0.5 * gained == pytest.approx(stored, rel=1e-6)


def test_a_drive_is_told_the_state_at_the_start_of_its_period() -> None:
    system = hanging_wire(mass=1.0)
    loop = simulate_loop(system, Scripted(signals=(0.5, 1.0, 0.0)), 0.3, 0.1)
    assert [time for time, _ in told] == [0.0, 0.1, 0.2]
    for k, (_, found) in enumerate(told):
        assert set(found) == set(OUTPUTS)
        for name in set(OUTPUTS) - set(ELECTRICAL):
            assert found[name] == loop.result[name][k], name
    assert [found["drive"] for _, found in told] == [0.0, 0.5, 1.0]
    assert [found["power"] for _, found in told] == pytest.approx([0.0, 0.5, 1.0])


def test_pulses_are_measured_while_on_and_held_while_off() -> None:
    system = hanging_wire(mass=1.0, source=PwmVoltage(supply=5.0))
    signals = (0.5, 0.0, 0.0, 0.2)
    loop = simulate_loop(system, Scripted(signals=signals), 0.4, 0.1, pulses=True)
    assert loop.means["drive"] == pytest.approx(signals)
    assert [found["drive"] for _, found in told] == [1.0] * 4
    on = loop.ends["current"][0]
    assert [found["current"] for _, found in told][1:] == [on] * 3
    assert told[0][1]["current"] == pytest.approx(5.0 / (8.3 * 1.15 * 0.25))
    assert loop.ends["drive"] == [1.0, 0.0, 0.0, 1.0]
    assert loop.ends["temperature"][0] > loop.result["temperature"][1]


def test_a_loop_is_closed() -> None:
    system = hanging_wire(mass=1.0)
    loop = simulate_loop(system, Thermostat(below=55.0 + ZERO), 8.0, 0.05)
    late = loop.result["temperature"][80:]
    assert 50.0 + ZERO < min(late) < 55.0 + ZERO < max(late) < 65.0 + ZERO
    assert set(loop.signals) == {0.0, 2.0}


def test_peaks_at_the_ends_of_pulses_raise_alarms() -> None:
    """The starts of the periods alone stay below the limit."""
    system = hanging_wire(source=PwmVoltage(supply=5.0))
    free = simulate_loop(system, Constant(level=0.1), 2.0, 0.2, pulses=True)
    starts, ends = max(free.result["temperature"]), max(free.ends["temperature"])
    assert starts < ends - 1.0
    limit = 0.5 * (starts + ends)
    strict = system.with_values({"element.limits.temperature_limit": limit})
    loop = simulate_loop(strict, Constant(level=0.1), 2.0, 0.2, pulses=True)
    (alarm,) = loop.result.alarms
    assert (alarm.kind, alarm.worst) == ("temperature", ends)


# ---------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"duration": 1.05}, "must be a whole number of periods of 0.1 s, but is 1.05 s"),
        ({"duration": 0.0}, "`duration` must be above 0 s"),
        ({"period": math.nan}, "`period` must be above 0 s"),
        ({"step": 0.0}, "`step` must be above 0 s"),
        ({"shortest": 0.01}, "`shortest` must be at most half a period, and is for pulses only"),
        ({"pulses": True}, "a switch, `pwm-voltage`, but it is `power`"),
        ({"step": 1e-9}, "more than 20,000,000 steps"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], sentence: str) -> None:
    chosen: dict[str, Any] = {"duration": 1.0, "period": 0.1, **arguments}
    with pytest.raises(InputError, match=sentence):
        simulate_loop(hanging_wire(), Constant(level=1.0), **chosen)


def test_a_chamber_has_no_loop() -> None:
    with pytest.raises(InputError, match="needs a drive that heats"):
        simulate_loop(chamber(law_a()), Constant(level=300.0), 1.0, 0.1)


def test_no_number_from_a_drive_is_an_error() -> None:
    with pytest.raises(SolveError, match=r"The drive returned nan at t = 0.1 s\."):
        simulate_loop(hanging_wire(), Scripted(signals=(0.0, math.nan)), 0.2, 0.1)


class Singular(PowerSource):
    """Divides by zero at a demand of 1."""

    def current(self, xp: Any, drive: Any, resistance: Any) -> Any:
        return 1.0 / (drive - 1.0)


def test_a_division_by_zero_is_reported_with_its_time() -> None:
    stairs = Staircase(first=0.5, increment=0.25, hold=0.1, count=5)
    with pytest.raises(SolveError, match=r"failed at t = 0\.\d+ s"):
        simulate_loop(hanging_wire(source=Singular()), stairs, 0.5, 0.1)


def test_held_values_stay() -> None:
    held = Held(values=(1.0, 2.0, 4.0), frequency=10.0)
    assert [held.value(t) for t in (0.0, 0.05, 0.1, 0.29, 0.3, 9.0)] == [1.0, 1.0, 2.0, 4.0, 4.0, 4.0]
    assert held.edges(1.0) == [0.1, 0.2]
    with pytest.raises(ParameterError, match="`frequency`"):
        Held(values=(1.0,), frequency=0.0)
    assert Ramp(high=1.0, end=1.0).unit is None


# ---------------------------------------------------------------- the envelope

MELTING = 1583.15


@pytest.mark.parametrize("pulses", [False, True])
def test_a_loop_stops_at_the_envelope(pulses: bool) -> None:
    """Full power from the third period on; what was computed is kept, whole periods of it."""
    source = PwmVoltage(supply=60.0) if pulses else PowerSource()
    script = Scripted(signals=(0.0, 0.0, *(8 * (1.0 if pulses else 400.0,))))
    loop = simulate_loop(hanging_wire(source=source), script, 1.0, 0.1, pulses=pulses, step=1e-3)
    result, count = loop.result, len(loop.result.times)
    assert result.status is Status.OUT_OF_ENVELOPE
    assert result.status_time is not None
    assert result.times[-1] <= result.status_time < 0.1 * count < 1.0
    assert 0.2 < result.status_time
    assert len(loop.signals) == count
    assert all(len(column) == count for column in result.columns.values())
    assert all(len(column) == count - 1 for t in (loop.ends, loop.means) for column in t.values())
    assert max(result["temperature"]) < MELTING
    assert any("the temperature reached" in text for text in result.warnings)
    with pytest.raises(SolveError, match="The run stopped at t = 0"):
        result.require()


def test_a_controlled_run_stops_at_the_envelope() -> None:
    system = hanging_wire(source=PowerSource())
    stairs = Staircase(first=0.0, increment=200.0, hold=0.25, count=4)
    found = simulate_controlled(system, stairs, 1.0, 0.05, step=1e-3)
    exact = simulate(system, stairs, 1.0, samples=21)
    assert found.status is exact.status is Status.OUT_OF_ENVELOPE
    assert found.status_time is not None
    assert found.times[-1] < found.status_time <= found.times[-1] + 0.05
    assert found.times == pytest.approx(exact.times[:-1])  # the exact run ends at the crossing
    assert found["temperature"] == pytest.approx(exact["temperature"][:-1], rel=1e-2)
    assert all(len(column) == len(found.times) for column in found.columns.values())
    assert any("the temperature reached" in text for text in found.warnings)
