"""Levels and differences of a reading: in scenarios texts in a unit of it, in Python SI floats.

Source of truth: units written down by hand; 0 °C is 273.15 K, and a difference is not shifted.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from one_wire import THIN_WIRE
from typer.testing import CliRunner

from martensite.actuators.assembly import Members
from martensite.base import units
from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.base.parameters import Leaf, Number, Parametrised, param, part, text
from martensite.cli import app
from martensite.control.checks.base import CHECKS
from martensite.control.controllers.planning import Price
from martensite.control.controllers.relay import OnOff
from martensite.control.faults.base import FAULTS
from martensite.scenario.build import Builder
from martensite.scenario.catalogue import list_registries
from martensite.scenario.components import component_class
from martensite.scenario.place_units import PlaceUnits, list_named_readings
from martensite.scenario.places import Places
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.signals.constant import Constant

EXAMPLES = Path(__file__).parents[2] / "examples"
LOOP = f"""{THIN_WIRE}
[driver]
kind = "pwm-voltage"
supply = "5 V"

[controller]
period = "20 ms"
"""
RUN = "\n[run]\nduration = '0.4 s'\n"
REFERENCES = {
    "position": "2 mm",
    "temperature": "60 degC",
    "strain": "2 %",
    "stress": "100 MPa",
    "estimated.temperature": "60 degC",
}
ON_OFF = "kind = 'on-off'\nhigh = 0.5\n"
SENSORS = """
[sensors.place]
kind = "position"
[sensors.heat]
kind = "ideal"
of = "temperature"
[sensors.part]
kind = "ideal"
of = "strain"
"""


def loop(controller: str, measured: str = "position", more: str = "", **changes: Any) -> Scenario:
    """The loop with a controller of one reading."""
    level = REFERENCES.get(measured, "2 mm")
    reference = f"\n[reference]\nkind = 'constant'\nlevel = '{level}'\n"
    document = f"{LOOP}measured = '{measured}'\n{controller}{reference}{more}{RUN}"
    return read_scenario(document, None, {path.replace("__", "."): v for path, v in changes.items()})


def numbers(scenario: Scenario) -> dict[str, tuple[float, str]]:
    """Value and unit of every number, under the path that `--set` takes."""
    places = scenario.places
    return {places.path(one.path): (one.value, places.unit(one)) for one in scenario.leaves()}


# ---------------------------------------------------------------- units of readings


@pytest.mark.parametrize(
    ("declared", "reading", "unit"),
    [
        (units.LEVEL, "m", "m"),
        (units.LEVEL, "K", "K"),
        (units.DIFFERENCE, "rad", "rad"),
        (units.DIFFERENCE, "K", units.DEGREES),
        (units.DIFFERENCE, "1", "1"),
        (units.RATE, "m", "m/s"),
        (units.RATE, "K", "K/s"),
        ("Pa", "m", "Pa"),
    ],
)
def test_unit_of_a_number_is_that_of_its_reading(declared: str, reading: str, unit: str) -> None:
    assert units.of_reading(declared, reading) == unit


@pytest.mark.parametrize(
    ("measured", "band", "value", "unit"),
    [
        ("position", "0.2 mm", 2e-4, "m"),
        ("position", "150 um", 1.5e-4, "m"),
        ("temperature", "3 K", 3.0, units.DEGREES),
        ("strain", "0.1 %", 1e-3, "1"),
        ("strain", 0.001, 1e-3, "1"),
        ("stress", "2 MPa", 2e6, "Pa"),
    ],
)
def test_band_is_in_a_unit_of_what_is_measured(measured: str, band: Any, value: float, unit: str) -> None:
    found = numbers(loop(ON_OFF, measured, controller__band=band))
    assert found["controller.band"] == (pytest.approx(value), unit)


def test_band_of_an_angle_may_be_in_degrees() -> None:
    found = numbers(load(EXAMPLES / "closed_loop_platform.toml"))
    assert found["controllers.first.band"] == (pytest.approx(math.radians(0.5)), "rad")


def test_level_of_a_temperature_is_shifted_and_a_difference_is_not() -> None:
    schedule = "rising.cold = { at = '40 degC', Kp = 1 }\nrising.hot = { at = '350 K', Kp = 2 }\n"
    found = numbers(loop(f"kind = 'scheduled-pid'\n{schedule}", "temperature"))
    assert found["controller.rising.cold.at"] == (pytest.approx(313.15), "K")
    assert found["controller.rising.hot.at"] == (350.0, "K")
    far = numbers(loop("kind = 'two-level'\nfar = '5 K'\nhigh = 0.9\nnear = 0.4\n", "temperature"))
    assert far["controller.far"] == (5.0, units.DEGREES)


def test_schedule_is_over_the_reading_that_decides() -> None:
    schedule = "kind = 'scheduled-pid'\nrising.cold = { at = '40 degC', Kp = 1 }\n"
    found = numbers(loop(schedule + "over = 'temperature'\n"))
    assert found["controller.rising.cold.at"] == (pytest.approx(313.15), "K")
    with pytest.raises(UnitError, match=r"rising.cold\].*`degC` cannot be converted to `m`"):
        loop(schedule)


@pytest.mark.parametrize(
    ("controller", "path", "given", "value", "unit"),
    [
        ("kind = 'mpc'\nhorizon = '1 s'\n", "price.error", "0.2 mm", 2e-4, "m"),
        ("kind = 'mpc'\nhorizon = '1 s'\n", "error", "0.2 mm", 2e-4, "m"),
        ("kind = 'state-feedback'\n", "level", "3 mm", 3e-3, "m"),
        ("kind = 'feedforward'\n", "slack", "2 um", 2e-6, "m"),
        ("kind = 'sliding-mode'\ngain = 1\nslope = '1 1/s'\n", "layer", "2 mm/s", 2e-3, "m/s"),
    ],
)
def test_controllers_take_texts(controller: str, path: str, given: str, value: float, unit: str) -> None:
    found = numbers(loop(controller, **{f"controller__{path}": given}))
    assert found[f"controller.{path}"] == (pytest.approx(value), unit)


def test_checks_have_the_unit_of_the_reading_that_they_name() -> None:
    guard = """
[supervisor]
kind = "guard"
[supervisor.checks.place]
kind = "sensor-stuck"
reading = "place"
longest = "1 s"
band = "0.5 um"
[supervisor.checks.heat]
kind = "sensor-stuck"
reading = "heat"
longest = "1 s"
band = "0.2 K"
[supervisor.checks.apart]
kind = "mismatch"
reading = "part"
other = "part"
limit = "1 %"
"""
    scenario = loop(ON_OFF, "place", SENSORS + guard)
    found = numbers(scenario)
    assert found["supervisor.checks.place.band"] == (pytest.approx(5e-7), "m")
    assert found["supervisor.checks.heat.band"] == (pytest.approx(0.2), units.DEGREES)
    assert found["supervisor.checks.apart.limit"] == (pytest.approx(0.01), "1")
    assert found["supervisor.checks.place.least"] == (0.0, "1")
    with pytest.raises(UnitError, match=r"heat\].*`mm` cannot be converted to `delta_degC`"):
        loop(ON_OFF, "place", SENSORS + guard, supervisor__checks__heat__band="1 mm")


def test_drift_has_the_unit_of_its_sensor() -> None:
    drift = "[faults.off]\nkind = 'drift'\nsensor = '{}'\nbias = '{}'\nrate = '{}'\n"
    found = numbers(loop(ON_OFF, "place", SENSORS + drift.format("place", "1 mm", "0.1 mm/s")))
    assert found["faults.off.bias"] == (pytest.approx(1e-3), "m")
    assert found["faults.off.rate"] == (pytest.approx(1e-4), "m/s")
    warm = numbers(loop(ON_OFF, "place", SENSORS + drift.format("heat", "-2 K", "3 degC/s")))
    assert warm["faults.off.bias"] == (-2.0, units.DEGREES)
    assert warm["faults.off.rate"] == (pytest.approx(3.0), "K/s")


def test_filter_has_the_unit_of_its_readings_if_it_is_one() -> None:
    ekf = "[observer]\nkind = 'extended-kalman'\nmeasured = {}\nreading_deviation = {}\n"
    watched = "[sensors.position]\nkind = 'position'\n[sensors.temperature]\nkind = 'ideal'\nof = "
    watched += "'temperature'\n"
    one = numbers(loop(ON_OFF, "position", watched + ekf.format("'position'", "'20 um'")))
    path = "observer.reading_deviation"
    assert one[path] == (pytest.approx(2e-5), "m")
    both = "['position', 'temperature']"
    assert numbers(loop(ON_OFF, "position", watched + ekf.format(both, 0.5)))[path] == (0.5, "1")


class Felt(Parametrised):
    """A part with numbers of a reading, and components."""

    names_reading = ("first", "second")

    first: str = text("name of a reading", default="")
    second: str = text("name of another one", default="heat")
    step: Number = param(units.DIFFERENCE, "least step", low=0.0, default=0.0)
    centre: Number = param(units.LEVEL, "middle of the range", default=0.0)


def test_part_of_a_sensor_has_the_unit_of_what_it_looks_at() -> None:
    """Its reading has no name."""
    builder = Builder(scales=PlaceUnits(readings={"": "K"}, reading_names=("",)))

    class Numb(Parametrised):
        step: Number = param(units.DIFFERENCE, "least step", low=0.0)
        centre: Number = param(units.LEVEL, "middle of the range")

    found = builder.build(Numb, {"step": "0.5 K", "centre": "20 degC"}, "sensor")
    assert (found.step, found.centre) == (0.5, pytest.approx(293.15))


def test_first_text_that_names_a_reading_decides() -> None:
    assert list_named_readings(Felt, {}) == ("heat",)
    assert list_named_readings(Felt, {"first": "place"}) == ("place",)
    assert list_named_readings(Felt, {"second": ""}) == ()
    builder = Builder(scales=PlaceUnits(readings={"heat": "K", "place": "m"}))
    assert builder.build(Felt, {"step": "2 K"}, "part").step == 2.0
    assert builder.build(Felt, {"first": "place", "step": "2 mm"}, "part").step == 2e-3


def nameless(cls: type[Parametrised], above: bool = False) -> list[str]:
    """Numbers of a reading, in a class and its components, that no text gives a reading."""
    named = above or bool(cls.names_reading)
    found = [f"{cls.__name__}.{n}" for n in cls.names_reading if cls.declarations[n].kind != "text"]
    if not isinstance(cls.declarations, dict):  # components by names of one's own
        return nameless(cls.kind, named) if issubclass(cls, Members) else found
    for name, declared in cls.declarations.items():
        if declared.unit in units.OF_READINGS and not named:
            found.append(f"{cls.__name__}.{name}")
        inner = component_class(cls, name)
        found += [] if inner is None else nameless(inner, named)
    return found


@pytest.mark.parametrize("kind", ["controller", "observer", "check", "fault", "supervisor"])
def test_every_number_of_a_reading_has_a_reading(kind: str) -> None:
    registry = list_registries()[kind]
    assert [one for name in registry.names() for one in nameless(registry[name])] == []


def test_number_without_a_reading_is_noticed() -> None:
    class Lost(Parametrised):
        price: Price = part("what is charged", default=Price())
        level: Number = param(units.LEVEL, "a level", default=0.0)

    assert nameless(Lost) == ["Price.error", "Lost.level"]
    lost = Leaf("lost.level", Lost.declarations["level"], 0.0)
    assert Places(scales={"lost": PlaceUnits()}).unit(lost) == units.LEVEL


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("measured", "band", "sentence"),
    [
        ("position", 0.2, '[controller] `band` is 0.2 without a unit; write for example `band = "0.2 mm"`.'),
        ("position", "0.2", "`0.2` has no unit"),
        ("position", "2 K", "Parameter `band` of `on-off`: The unit `K` cannot be converted"),
        ("position", "-1 mm", "`band` of `on-off` must be at least 0 mm, but is -1 mm."),
        ("temperature", 3, '`band` is 3 without a unit; write for example `band = "3 K"`.'),
        ("positon", "1 mm", "There is no reading `positon`. Did you mean `position`?"),
        ("", "1 mm", "No reading is named"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_sentence(measured: str, band: Any, sentence: str) -> None:
    with pytest.raises(InputError) as raised:
        loop(ON_OFF, measured, controller__band=band)
    assert sentence in str(raised.value)


def test_what_is_missing_is_named_with_its_unit() -> None:
    with pytest.raises(ParameterError) as raised:
        loop("kind = 'two-level'\nhigh = 1\nnear = 0.5\n")
    assert 'needs `far` [mm] (error φ from which it is full); write `far = "… mm"`' in str(raised.value)


def test_in_python_they_are_floats_in_si() -> None:
    rest: dict[str, Any] = {"measured": "y", "reference": Constant(level=1.0), "high": 1.0}
    assert OnOff(band=2e-4, **rest).band == 2e-4
    with pytest.raises(ParameterError) as raised:
        OnOff(band=-1.0, **rest)
    assert str(raised.value) == "Parameter `band` of `on-off` must be at least 0, but is -1.0."
    with pytest.raises(ParameterError, match="must be a number in the SI unit of the reading"):
        OnOff(**rest, **dict[str, Any](band=None))
    mismatch: Any = CHECKS["mismatch"]
    assert mismatch(reading="a", other="b", limit=0.5).limit == 0.5
    drift: Any = FAULTS["drift"]
    assert drift(sensor="a", rate=-3e-3).rate == -3e-3


# ---------------------------------------------------------------- the command line


def call(*arguments: str) -> Any:
    return CliRunner(env={"COLUMNS": "140"}).invoke(app, list(arguments))


def test_set_and_params_speak_of_the_everyday_unit() -> None:
    path = str(EXAMPLES / "closed_loop_platform.toml")
    change = ("--set", "controllers.first.band=0.8 deg")
    rows = {row["path"]: row for row in json.loads(call("params", path, *change, "--json").stdout)}
    assert rows["controllers.first.band"]["unit"] == "rad"
    assert rows["controllers.first.band"]["value"] == pytest.approx(math.radians(0.8))
    printed = call("params", path, *change).stdout
    (line,) = [one for one in printed.splitlines() if "controllers.first.band" in one]
    assert "0.8 deg" in line
    bare = call("check", path, "--set", "controllers.first.band=0.01")
    assert (bare.exit_code, bare.stdout) == (2, "")
    assert 'write for example `band = "0.01 deg"`' in bare.stderr
    done = call("check", path, *change)  # accepted; the source of the example cannot deliver its 5 V
    assert (done.exit_code, done.stderr) == (1, "") and "asks for 5 V, but the source delivers" in done.stdout


def test_descriptions_say_that_the_unit_is_that_of_the_reading() -> None:
    rows = {r["name"]: r for r in json.loads(call("list", "controller", "on-off", "--json").stdout)["parameters"]}
    assert rows["band"]["unit"] == units.DIFFERENCE
    assert rows["band"]["allowed"] == "at least 0, in the unit of the reading"
    assert "1e-06 in SI" in call("list", "controller", "feedforward").stdout
