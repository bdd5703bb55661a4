"""The bench as a system: one kernel on every runtime, and the same as its parts one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base.errors import InputError, ParameterError
from martensite.base.parameters import Number, param
from martensite.base.status import Status
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.controllers.relay import OnOff
from martensite.control.faults.sensor import Stuck
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, FaultTable, MountedSensor, Observers, Sensors
from martensite.control.loop.run import open_loop, simulate_bench
from martensite.control.observers.inverse import InverseModel
from martensite.control.sensors.position import PositionSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.physics.electrical.switches import PwmVoltage
from martensite.signals.base import AbstractDrive
from martensite.signals.constant import Constant
from martensite.signals.sine import Sine
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march, compile_system
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.native_slopes import march_slopes

PERIOD, DURATION = 0.05, 6.0
REFERENCE = Sine(low=0.0, high=0.006, frequency=0.2)


def plant(supply: float = 6.0) -> Any:
    """The benchmark wire behind a switch."""
    return problem_a().with_parts(source=PwmVoltage(supply=supply))


def pid(**changes: Any) -> Pid:
    """A controller of its position."""
    known: dict[str, Any] = {"measured": "position", "reference": REFERENCE, "Kp": 300.0, "Ki": 80.0}
    return Pid(**(known | changes))


def bench(**parts: Any) -> Bench:
    """That wire with an encoder that is late, under that controller."""
    encoder = MountedSensor(sensor=PositionSensor(), delay=0.1)
    known = {
        "plant": plant(),
        "period": PERIOD,
        "sensors": Sensors(position=encoder),
        "controllers": Controllers(drive=pid()),
    }
    return Bench(**(known | parts))


class Steady(AbstractDrive):
    """A drive that follows nothing."""

    level: Number = param("1", "what it says")

    def init(self) -> None:
        return None

    def __call__(self, time: float, measurement: Any, memory: Any) -> tuple[float, None]:
        return self.level, None


def apart(one: Any, other: Any, name: str, last: int | None = None) -> float:
    """Largest difference of a column."""
    return float(np.max(np.abs(np.subtract(one[name], other[name])[:last])))


class TestSameEverywhere:
    def test_in_c_as_on_floats(self, c_compiler: None) -> None:
        on_floats = simulate_bench(bench(), DURATION, runtime="floats")
        in_c = simulate_bench(bench(), DURATION, runtime="c")
        for name in ("position", "temperature", "measured.position", "wanted"):
            scale = max(map(abs, on_floats[name]))
            assert apart(on_floats, in_c, name) <= 1e-9 * scale

    def test_controller_inside_as_outside(self) -> None:
        inside = simulate_bench(bench(), DURATION, runtime="floats")
        opening, controller = open_loop(bench(), "drive")
        outside = simulate_bench(opening, DURATION, outside={"drive": controller})
        assert apart(inside, outside, "position") <= 1e-10
        assert apart(inside, outside, "measured.position") <= 1e-10
        assert apart(inside, outside, "drive", -1) <= 1e-7  # nobody answers at the end

    def test_columns_of_a_controller_outside_are_those_of_one_inside(self) -> None:
        inside = simulate_bench(bench(), 1.0, runtime="floats")
        opening, controller = open_loop(bench(), "drive")
        outside = simulate_bench(opening, 1.0, outside={"drive": controller})
        assert set(outside.columns) == set(inside.columns)
        assert outside.outputs == inside.outputs
        assert apart(inside, outside, "reference") <= 1e-12
        assert max(inside["reference"]) > 1e-3
        assert apart(inside, outside, "wanted", -1) <= 1e-7
        assert outside["wanted"][-1] == outside["wanted"][-2]  # nobody answers at the end

    def test_drive_that_follows_nothing_has_no_reference(self) -> None:
        run = simulate_bench(bench(controllers=Controllers()), 0.2, outside={"drive": Steady(level=0.1)})
        assert "reference" not in run.columns
        assert set(run.columns["wanted"]) == {0.1}

    def test_a_run_outside_tells_how_far_it_is(self) -> None:
        told: list[float] = []
        opening, controller = open_loop(bench(), "drive")
        simulate_bench(opening, 0.5, outside={"drive": controller}, watch=told.append)
        assert told == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])

    def test_gains_matter(self) -> None:
        """The comparisons above see a controller that is another."""
        inside = simulate_bench(bench(), DURATION, runtime="floats")
        other = bench(controllers=Controllers(drive=pid(Kp=250.0)))
        assert apart(inside, simulate_bench(other, DURATION, runtime="floats"), "position") > 1e-5

    def test_derivatives_with_respect_to_gains(self, c_compiler: None) -> None:
        quiet = bench(sensors=Sensors())  # an encoder rounds
        grid = grid_of(quiet, {"reference": REFERENCE}, 2.0, 41, PERIOD)
        compiled = compile_march(quiet)
        place = compiled.outputs.index("position")
        which = compiled.paths.index("controllers.drive.Kp")
        seeds = np.zeros((len(compiled.paths), 1))
        seeds[which] = 1.0
        exact = march_slopes(compiled, compiled.values(quiet), seeds, grid, [place]).slopes[:, 0, 0]
        rows = []
        for change in (-0.01, 0.01):
            values = compiled.values(quiet)
            values[which] += change
            zero = np.zeros((len(values), 1))
            rows.append(march_slopes(compiled, values, zero, grid, [place]).rows[:, 0])
        numeric = (rows[1] - rows[0]) / 0.02
        assert np.max(np.abs(exact)) > 1e-7
        assert np.max(np.abs(exact - numeric)) <= 2e-4 * np.max(np.abs(exact))


class TestPeriods:
    def test_what_is_shown_belongs_together(self) -> None:
        """Without sensors the signal shown is the answer to the output and reference shown."""
        proportional = pid(Ki=0.0, law=PidLaw(low=-10.0, high=10.0))
        run = simulate_bench(
            bench(sensors=Sensors(), controllers=Controllers(drive=proportional)), 2.0, runtime="floats"
        )
        wanted = 300.0 * np.subtract(run["reference"], run["position"])
        assert run.columns["wanted"] == pytest.approx(wanted, abs=1e-12)
        expected = [REFERENCE.value(time) for time in run.times]
        assert run.columns["reference"] == pytest.approx(expected, abs=1e-9)

    def test_seed_decides_the_noise(self) -> None:
        one, same, other, none = (simulate_bench(bench(), 1.0, seed=seed, runtime="floats") for seed in (1, 1, 2, None))
        assert one["measured.position"].tolist() == same["measured.position"].tolist()
        assert apart(one, other, "measured.position") > 0.0
        assert apart(one, none, "measured.position") > 0.0

    def test_substeps_refine_the_plant(self) -> None:
        """Second order: half the step, a quarter of the error."""
        parts = {"sensors": Sensors(), "controllers": Controllers()}
        runs = [
            simulate_bench(bench(substeps=n, **parts), 1.0, waveforms={"drive": Constant(level=0.1)}, runtime="floats")
            for n in (1, 2, 16)
        ]
        coarse, fine = (apart(run, runs[-1], "temperature") for run in runs[:2])
        assert fine < 0.35 * coarse

    def test_pulses_heat_like_their_average(self) -> None:
        """Over short periods; and the electrical readings are those of the closed switch."""
        parts = {"sensors": Sensors(), "controllers": Controllers(), "period": 0.005}
        run = {
            how: simulate_bench(
                bench(switching=how, **parts), 1.0, waveforms={"drive": Constant(level=0.3)}, runtime="floats"
            )
            for how in ("averaged", "pulses")
        }
        rise = run["averaged"]["temperature"][-1] - run["averaged"]["temperature"][0]
        assert apart(run["averaged"], run["pulses"], "temperature") <= 0.02 * rise

    def test_a_fault_is_there_from_start_to_end(self) -> None:
        stuck = FaultTable(encoder=Stuck(sensor="position", start=1.0, end=2.0))
        run = simulate_bench(bench(faults=stuck), 3.0, seed=None, runtime="floats")
        reading = np.array(run["measured.position"])
        held = reading[(np.array(run.times) > 1.11) & (np.array(run.times) < 2.09)]
        assert np.ptp(held) == 0.0
        assert abs(reading[np.array(run.times) > 2.11][0] - held[0]) > 1e-4


@pytest.fixture(scope="module")
def machine() -> Machine:
    """Two such wires on a pulley."""
    one = plant()
    actuator = Actuator(element=one.element, environment=one.environment, source=one.source)
    return Machine(
        mechanism=AntagonisticPulley(radius=0.01, preload=5.0), group=Group(protagonist=actuator, antagonist=actuator)
    )


class TestSeveralDrives:
    def test_one_controller_per_drive(self, machine: Machine) -> None:
        coordinate = next(iter(machine.mechanism.outputs()))
        switch = OnOff(measured=coordinate, reference=Constant(level=0.02), high=0.3)
        both = Bench(
            plant=machine,
            period=0.05,
            controllers=Controllers(protagonist=switch, antagonist=switch.with_values({"high": 0.0})),
        )
        names = [drive.name for drive in both.drives()]
        assert names == ["reference.protagonist", "reference.antagonist"]
        one = Bench(plant=machine, period=0.05, controllers=Controllers(protagonist=switch))
        assert [drive.name for drive in one.drives()] == ["reference", "antagonist"]
        runs = [simulate_bench(b, 2.0, runtime="floats") for b in (both, one)]
        assert apart(runs[0], runs[1], coordinate) == 0.0
        assert max(runs[0][coordinate]) > 0.02

    def test_drives_outside_are_in_the_names_of_their_columns(self, machine: Machine) -> None:
        coordinate = next(iter(machine.mechanism.outputs()))
        switch = OnOff(measured=coordinate, reference=Constant(level=0.02), high=0.3)
        names, alone = ("protagonist", "antagonist"), Bench(plant=machine, period=0.05)
        run = simulate_bench(alone, 0.2, outside=dict.fromkeys(names, switch))
        assert {f"{n}.{d}" for n in ("reference", "wanted") for d in names} <= set(run.columns)
        assert set(run.columns["reference.antagonist"]) == {0.02}
        assert run.unit("reference.antagonist") == run.unit(coordinate)
        assert run.columns["wanted.protagonist"] == pytest.approx(run.columns["protagonist.drive"])
        one = alone.with_parts(controllers=Controllers(protagonist=switch))
        mixed = simulate_bench(one, 0.2, outside={"antagonist": switch})
        assert {"reference", "wanted", "reference.antagonist"} <= set(mixed.columns)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"sensors": Sensors(x=MountedSensor(sensor=PositionSensor(), of=("positon",)))}, "`position`"),
        ({"controllers": Controllers(drive=pid(measured="positoin"))}, "`position`"),
        ({"controllers": Controllers(wire=pid())}, "`drive`"),
        ({"faults": FaultTable(f=Stuck(sensor="encoder"))}, "`position`"),
    ],
)
def test_names_are_checked(parts: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        bench(**parts)


def test_pulses_need_a_switch() -> None:
    with pytest.raises(ParameterError, match="switch"):
        bench(plant=problem_a(), switching="pulses")


def test_what_drives_it_is_checked() -> None:
    with pytest.raises(InputError, match="`reference`"):
        simulate(bench(), {"refernce": REFERENCE}, 1.0)


def test_numbers_are_no_structure() -> None:
    assert compile_system(bench()) is compile_system(bench(controllers=Controllers(drive=pid(Kp=1.0))))
    later = Sensors(position=MountedSensor(sensor=PositionSensor(), delay=0.3))
    assert compile_system(bench()) is not compile_system(bench(sensors=later))


def test_an_estimate_comes_from_one_observer() -> None:
    same = InverseModel(model=plant(), measured="resistance")
    resistance = MountedSensor(sensor=ResistanceSensor())
    with pytest.raises(ParameterError, match="both estimate"):
        bench(
            sensors=Sensors(position=MountedSensor(sensor=PositionSensor()), resistance=resistance),
            observers=Observers(one=same, other=same),
        )


@pytest.mark.parametrize("runtime", ["floats", "c"])
def test_a_bench_stops_at_the_envelope(runtime: str, c_compiler: str) -> None:
    """A controller that asks for more than there is, on a supply that melts the wire."""
    far = Constant(level=0.1)
    wild = bench(plant=plant(60.0), controllers=Controllers(drive=pid(reference=far)))
    found = simulate_bench(wild, DURATION, runtime=runtime)
    assert found.status is Status.OUT_OF_ENVELOPE
    assert found.status_time is not None
    assert found.times[-1] < found.status_time <= found.times[-1] + PERIOD + 1e-9
    assert max(found["temperature"]) < 1583.15
    assert any("the temperature reached" in text for text in found.warnings)


def test_a_bench_with_a_controller_outside_stops_there_too() -> None:
    wild = bench(plant=plant(60.0), controllers=Controllers())
    steady = pid(reference=Constant(level=0.1))
    found = simulate_bench(wild, DURATION, outside={"drive": steady}, seed=None)
    assert found.status is Status.OUT_OF_ENVELOPE
    assert all(len(column) == len(found.times) for column in found.columns.values())
