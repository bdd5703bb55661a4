"""A guard from plant and sensors: which checks there are, that they hold still, and see faults.

Source of truth: readings of sensors drawn one by one, the limits of the material, and runs of a
closed loop with and without faults.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from martensite.base.errors import InputError
from martensite.control.checks.base import CHECKS
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import MountedSensor, Sensors
from martensite.control.sensors.base import SENSORS
from martensite.control.sensors.position import IdealSensor, PositionSensor
from martensite.control.supervisors.from_plant import build_thermal_guard
from martensite.control.supervisors.from_sensors import CHANCE, build_sensor_checks, lost_after, stuck_after
from martensite.control.supervisors.guard import Guard
from martensite.kernels import floats
from martensite.scenario.scenario import Scenario, load, read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples"
SENSOR: Any = SENSORS
PERIOD, BEGIN = 0.02, 6.0
STEP, NOISE = 0.5e-6, 0.4e-6
WITH: dict[str, Any] = {"supervisor": {"kind": "guard", "from_plant": True}}
OFF = "1e6 s"


def loop(**changes: Any) -> Scenario:
    """The closed loop of the examples with a guard from its plant; `__` stands for a dot."""
    settings = {path.replace("__", "."): value for path, value in changes.items()}
    return load(EXAMPLES / "closed_loop.toml", {**WITH, "run.duration": "8 s", **settings})


def sensed(lost: str = OFF, stuck: str = OFF, **changes: Any) -> Scenario:
    """That loop with several sensors, two of which may fail."""
    text = (EXAMPLES / "closed_loop.toml").read_text(encoding="utf-8")
    encoder = '[sensors.position]\nkind = "position"\ndelay = "20 ms"\njitter = "8 ms"\n'
    others = (
        encoder
        + '[sensors.heat]\nkind = "thermocouple"\nsample_time = "50 ms"\nlag = "0.1 s"\n'
        + '[sensors.ohms]\nkind = "resistance"\n'
        + '[sensors.load]\nkind = "ideal"\nof = "stress"\n'
    )
    assert '[sensor]\nkind = "position"\ndelay = "20 ms"\n' in text
    text = text.replace('[sensor]\nkind = "position"\ndelay = "20 ms"\n', others)
    faults = {
        "faults.lost": {"kind": "drop-out", "sensor": "position", "start": lost},
        "faults.stuck": {"kind": "stuck", "sensor": "heat", "start": stuck},
    }
    return read_scenario(text, None, {**WITH, "run.duration": "12 s", **faults, **changes})


def guard(scenario: Scenario) -> Guard:
    assert scenario.bench is not None
    assert isinstance(scenario.bench.supervisor, Guard)
    return scenario.bench.supervisor


# ---------------------------------------------------------------- sensors


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.5])
def test_readings_repeat_at_most_as_often_as_is_taken_for_sound(offset: float) -> None:
    """A stuck sensor repeats itself n times; p^n is below `CHANCE` and p^(n - 1) is not."""
    sensor = PositionSensor(noise=NOISE, resolution=STEP)
    drawn = np.random.default_rng(0).standard_normal(20_000)
    state = (offset * STEP, 0.0)
    rows = [sensor.reading(floats, state, state[:1], n, 0.0)[0] for n in drawn.tolist()]
    share = max(np.unique(rows, return_counts=True)[1]) / len(rows)
    longest = stuck_after(MountedSensor(sensor=sensor), PERIOD)
    assert longest is not None
    readings = round(longest / PERIOD)
    assert share**readings < CHANCE * 1.5
    if offset == 0.0:
        assert share ** (readings - 1) > CHANCE / 1.5


@pytest.mark.parametrize(
    ("sensor", "longest"),
    [
        (PositionSensor(noise=1e-6, resolution=0.0), 5 * PERIOD),
        (PositionSensor(noise=0.0), None),
        (PositionSensor(noise=1e-9, resolution=1e-3), None),
        (SENSOR["infrared"](), None),
    ],
    ids=["no steps", "no noise", "coarse", "range"],
)
def test_only_what_must_move_can_be_stuck(sensor: Any, longest: float | None) -> None:
    found = stuck_after(MountedSensor(sensor=sensor), PERIOD)
    assert found == (None if longest is None else pytest.approx(longest))


def test_lost_is_what_is_older_than_any_reading_can_be() -> None:
    mounted = MountedSensor(sensor=PositionSensor(), sample_time=0.05, delay=0.1, jitter=0.01)
    assert lost_after(mounted, PERIOD) == pytest.approx(0.1 + 0.04 + 3 * 0.06 + 0.02)


def test_checks_are_those_of_what_is_measured() -> None:
    scenario = sensed()
    limits = scenario.single_system.element.limits
    checks = guard(scenario).checks.members()
    assert set(checks) == {
        "bound_drive",
        "hot_heat",
        "lost_heat",
        "stuck_heat",
        "lost_position",
        "stuck_position",
        "stress_load",
        "lost_load",
    }
    known: Any = checks
    assert known["hot_heat"].limit == limits.temperature_limit
    assert known["stress_load"].limit == limits.stress_limit


def test_elements_of_a_machine_are_cut_one_by_one() -> None:
    plant = load(EXAMPLES / "closed_loop_platform.toml").system
    hot = MountedSensor(sensor=IdealSensor(), of=("second.temperature",))
    bench = Bench(plant=plant, period=PERIOD, sensors=Sensors(warm=hot))
    found: Any = build_sensor_checks(bench, temperature_limit=400.0)
    assert (found["hot_warm"].cuts(), found["hot_warm"].limit) == (("second",), 400.0)
    assert list(build_sensor_checks(bench)) == ["lost_warm"]  # nothing is known of the material


# ---------------------------------------------------------------- runs


def test_nothing_is_cut_without_a_fault_and_faults_are_seen() -> None:
    fine = sensed().run()
    assert set(fine["alarm"]) == {0.0}
    for fault, number, name in (("lost", 4, "lost_position"), ("stuck", 5, "stuck_heat")):
        scenario = sensed(**{fault: f"{BEGIN} s"})
        checks: Any = guard(scenario).checks.members()
        check = checks[name]
        known = check.timeout if fault == "lost" else check.longest
        run = scenario.run()
        first = next((t, a) for t, a in zip(run.times, run["alarm"], strict=True) if a)
        assert first[1] == number
        assert BEGIN < first[0] <= BEGIN + known + 0.1
        assert run["drive"][-1] == 0.0 < fine["drive"][-1]


# ---------------------------------------------------------------- scenarios


def test_guard_of_a_scenario_is_that_of_its_plant() -> None:
    scenario = loop(supervisor__from_plant={"hottest": "40 degC", "least_cooling": 0.8})
    assert scenario.bench is not None
    made = build_thermal_guard(
        scenario.system, hottest=313.15, least_cooling=0.8, checks=build_sensor_checks(scenario.bench)
    )
    assert guard(scenario) == made
    assert guard(read_scenario(scenario.text)) == made
    assert scenario.origins["supervisor.checks.bound_drive.power"] == "plant"


def test_numbers_that_are_given_count() -> None:
    own = {
        "bound_drive": {"limit": "60 degC"},
        "lost_position": {"timeout": "1 s"},
        "stuck_position": {"kind": "over-stress", "reading": "position", "limit": "1 GPa"},
        "mine": {"kind": "sensor-lost", "reading": "position", "timeout": "2 s"},
    }
    scenario = loop(supervisor__checks=own)
    checks: Any = guard(scenario).checks.members()
    plain: Any = guard(loop()).checks.members()
    assert checks["bound_drive"].limit == pytest.approx(333.15)
    assert checks["bound_drive"].power == plain["bound_drive"].power
    assert checks["lost_position"].timeout == 1.0 != plain["lost_position"].timeout
    assert type(checks["stuck_position"]) is CHECKS["over-stress"]
    assert checks["mine"].timeout == 2.0
    origins = scenario.origins
    assert origins["supervisor.checks.bound_drive.limit"] == "scenario"
    assert origins["supervisor.checks.bound_drive.power"] == "plant"
    run = scenario.run(runtime="floats")
    assert 8.0 in run["alarm"]
    assert max(run["temperature"]) < 333.15


def test_without_noise_nothing_is_stuck() -> None:
    assert "stuck_position" in guard(loop()).checks.members()
    assert "stuck_position" not in guard(loop(bench__noise="none")).checks.members()


def test_a_guard_that_guards_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="A guard without checks guards nothing"):
        loop(supervisor__from_plant=False)


CURRENT = {"driver": {"kind": "current"}, "controller.high": "1 A"}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"supervisor.from_plant": 3}, "`from_plant` must be true, false, or a table"),
        ({"supervisor.from_plant": {"hotest": "1 K"}}, "[supervisor.from_plant] `FromPlant` has no"),
        (CURRENT, "[supervisor] Drive `current` takes a signal in A: give its largest value"),
    ],
    ids=["number", "name", "full"],
)
def test_what_is_not_known_is_asked_for(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as raised:
        load(EXAMPLES / "closed_loop.toml", {**WITH, **changes})
    assert sentence in str(raised.value)


def test_limit_is_asked_for_where_the_material_knows_none() -> None:
    path = EXAMPLES / "closed_loop_platform.toml"
    own = {"full": "5 V", "temperature_limit": "110 degC"}
    with pytest.raises(InputError, match=r"\[supervisor\] .*`first` has no `temperature_limit`"):
        load(path, {**WITH, "supervisor.from_plant": {"full": "5 V"}})
    checks: Any = guard(load(path, {**WITH, "supervisor.from_plant": own})).checks.members()
    assert checks["bound_third"].limit == pytest.approx(383.15)
    assert checks["bound_third"].cuts() == ("third",)


def test_full_signal_has_the_unit_of_the_source() -> None:
    full = {"supervisor.from_plant": {"full": "500 mA"}}
    scenario = load(EXAMPLES / "closed_loop.toml", {**WITH, **CURRENT, **full})
    checks: Any = guard(scenario).checks.members()
    assert (checks["bound_drive"].full, checks["bound_drive"].rises) == (0.5, "square")
