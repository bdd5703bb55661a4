"""Scenarios of closed loops: every section builds what it says, or is refused with a sentence.

Source of truth: benches put together in Python from the same numbers, and the units written down
in the scenarios by hand.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from one_wire import THIN_WIRE

from martensite.base.errors import InputError, ParameterError, UnitError
from martensite.base.formats import write_quantity
from martensite.base.toml_text import as_toml
from martensite.control.controllers.mpc import Mpc
from martensite.control.controllers.pid import Pid, PidLaw
from martensite.control.controllers.scheduled_pid import ScheduledPid
from martensite.control.loop.names import list_readings
from martensite.control.loop.parts import Controllers, MountedSensor
from martensite.control.loop.realtime import RealtimeStep
from martensite.control.loop.run import simulate_bench
from martensite.control.observers.usual_models import AS_MODELLED, USUAL
from martensite.control.sensors.position import PositionSensor
from martensite.scenario.netcdf import read_labelled as open_result
from martensite.scenario.netcdf import save_result
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.signals.sine import Sine

EXAMPLES = Path(__file__).parents[2] / "examples"

PLANT = f"""{THIN_WIRE}
[run]
duration = "0.4 s"
"""
DRIVER = """
[driver]
kind = "pwm-voltage"
supply = "5 V"
"""
SENSOR = """
[sensor]
kind = "position"
delay = "40 ms"
"""
CONTROLLER = """
[controller]
kind = "pid"
measured = "position"
period = "20 ms"
Kp = 150
high = 0.9
"""
REFERENCE = """
[reference]
kind = "sine"
low = "1 mm"
high = "4 mm"
frequency = "0.1 Hz"
"""
LOOP = PLANT + DRIVER + SENSOR + CONTROLLER + REFERENCE


def without(text: str, *lines: str) -> str:
    for line in lines:
        assert line in text
        text = text.replace(line, "")
    return text


def controlled(controller: str, reference: str = REFERENCE, driver: str = DRIVER) -> Scenario:
    """The plant under another controller, everything known."""
    return read_scenario(PLANT + driver + "[controller]\nperiod = '20 ms'\n" + controller + reference)


def placed(scenario: Scenario) -> dict[str, Any]:
    """Every number of a scenario under the path that `--set` takes."""
    return {scenario.places.path(leaf.path): leaf for leaf in scenario.leaves()}


# ---------------------------------------------------------------- what is built


def test_loop_is_that_of_its_parts() -> None:
    bench = read_scenario(LOOP).bench
    assert bench is not None
    assert bench.period == pytest.approx(0.02)
    assert bench.sensors.members() == {"position": MountedSensor(sensor=PositionSensor(), delay=0.04)}
    assert bench.controllers.members() == {
        "drive": Pid(
            measured="position", reference=Sine(low=1e-3, high=4e-3, frequency=0.1), Kp=150.0, law=PidLaw(high=0.9)
        )
    }


def test_run_of_a_scenario_is_that_of_its_bench() -> None:
    scenario = read_scenario(LOOP)
    assert scenario.bench is not None
    result = scenario.run(runtime="floats")
    same = simulate_bench(scenario.bench, 0.4, seed=0, runtime="floats")
    assert all(np.array_equal(column, same[name], equal_nan=True) for name, column in result.columns.items())
    assert len(result.times) == 21
    assert {"position", "measured.position", "reference", "wanted"} <= set(result.columns)


def test_another_seed_draws_another_noise_the_same_in_floats_and_c(tmp_path: Path, c_compiler: str) -> None:
    """The noise is what the sensor adds to the position of the same sample; the default seed is 0."""

    def draw(seed: int | None, runtime: str) -> list[float]:
        result = read_scenario(LOOP, overrides={} if seed is None else {"run.seed": seed}).run(runtime=runtime)
        save_result(result, tmp_path / "run.nc")
        assert open_result(tmp_path / "run.nc").attrs["noise_seed"] == (seed or 0)
        return result.columns["measured.position"].tolist()

    assert draw(None, "floats") == draw(0, "floats")
    assert draw(7, "floats") == pytest.approx(draw(7, "c"), rel=1e-12)
    assert draw(7, "c") != draw(0, "c")


@pytest.mark.parametrize(("duration", "end"), [("0.4 s", 0.4), ("0.41 s", 0.4), ("0.399 s", 0.38)])
def test_a_run_that_ends_at_another_time_says_so(duration: str, end: float) -> None:
    """The truth: 19 or 20 periods of 20 ms."""
    found = read_scenario(LOOP, overrides={"run.duration": duration}).run(runtime="floats")
    assert found.times[-1] == pytest.approx(end)
    said = [warning for warning in found.warnings if f"ends at {end:g} s instead of {duration}" in warning]
    assert len(said) == (duration != "0.4 s"), found.warnings


def test_noise_can_be_left_out() -> None:
    quiet = read_scenario(LOOP + "[bench]\nnoise = 'none'\n").run(runtime="floats")
    assert set(quiet["measured.position"][:3]) == {0.0}


def test_scenario_without_sensor_or_controller_has_no_bench() -> None:
    text = PLANT + DRIVER + "waveform = { kind = 'constant', level = 0.1 }\n"
    assert read_scenario(text).bench is None
    watched = read_scenario(text + SENSOR + "[bench]\nperiod = '20 ms'\n")
    assert watched.bench is not None
    assert "measured.position" in watched.run(runtime="floats").columns


def test_drive_is_another_word_for_driver() -> None:
    named = read_scenario(LOOP.replace("[driver]", "[drive]"))
    assert named.bench == read_scenario(LOOP).bench
    assert "drive.supply" in placed(named)
    assert "driver.supply" in placed(read_scenario(LOOP))


@pytest.mark.parametrize("section", ["controller", "bench", "run"])
def test_period_may_stand_in_one_of_three_sections(section: str) -> None:
    text = without(LOOP, 'period = "20 ms"\n')
    scenario = read_scenario(text, None, {f"{section}.period": "10 ms"})
    assert scenario.bench is not None
    assert scenario.bench.period == pytest.approx(0.01)
    assert f"{section}.period" in placed(scenario)


def test_levels_are_in_the_units_of_their_places() -> None:
    power = "[driver]\nkind = 'power'\n"
    found = controlled("kind = 'pid'\nmeasured = 'position'\nKp = 1\nhigh = '400 mW'\n", driver=power)
    leaves = placed(found)
    units = {path: found.places.unit(leaf) for path, leaf in leaves.items()}
    assert (leaves["controller.high"].value, units["controller.high"]) == (0.4, "W")
    assert units["controller.law.low"] == "W"
    assert units["reference.high"] == "m"
    warm = REFERENCE.replace("1 mm", "40 degC").replace("4 mm", "60 degC")
    hot = controlled("kind = 'pid'\nmeasured = 'temperature'\nKp = 0.01\n", warm)
    assert placed(hot)["reference.low"].value == pytest.approx(313.15)


def test_reference_of_a_power_needs_no_reading() -> None:
    power = "[reference]\nkind = 'constant'\nlevel = '300 mW'\n"
    result = controlled("kind = 'constant-power'\n", power).run(runtime="floats")
    assert result.unit("reference") == "W"
    assert result.columns["power"][-1] == pytest.approx(0.3, rel=1e-3)


def test_every_number_is_reached_by_its_path() -> None:
    settings: dict[str, Any] = {
        "sensor.noise": "2 um",
        "sensor.jitter": "1 ms",
        "controller.Kp": 99,
        "controller.law.filter": "40 ms",
        "reference.high": "5 mm",
        "driver.supply": "6 V",
        "controller.high": 0.5,
    }
    leaves = placed(read_scenario(LOOP, None, settings))
    shown = {path: leaves[path].value for path in settings}
    assert list(shown.values()) == pytest.approx([2e-6, 1e-3, 99.0, 0.04, 5e-3, 6.0, 0.5])


def test_gains_and_limits_are_taken_as_they_are_printed() -> None:
    """Of a loop of a duty and a position, and of the two halves of a cascade."""
    gains = "Kp = '0.15 1/mm'\nKi = '0.75 1/m/s'\nKd = '30 ms/m'\n"
    around = "shaping = { rate = '2 mm/s', acceleration = '4 mm/s^2' }\nslew = { falling = '3 1/s' }\n"
    text = LOOP.replace("Kp = 150", gains + around)
    scenario = read_scenario(text)
    assert scenario.bench is not None
    pid: Any = scenario.bench.controllers.members()["drive"]
    assert (pid.Kp, pid.Ki, pid.Kd) == pytest.approx((150.0, 0.75, 0.03))
    assert (pid.shaping.rate, pid.shaping.acceleration, pid.slew.falling) == pytest.approx((2e-3, 4e-3, 3.0))
    leaves = {scenario.places.path(leaf.path): leaf for leaf in scenario.leaves()}
    paths = [
        f"controller.{name}" for name in ("Kp", "Ki", "Kd", "shaping.rate", "shaping.acceleration", "slew.falling")
    ]
    shown = {path: write_quantity(leaves[path].value, scenario.places.unit(leaves[path])) for path in paths}
    assert list(shown.values()) == ["150 1/m", "0.75 1/m/s", "0.03 s/m", "0.002 m/s", "0.004 m/s^2", "3 1/s"]
    assert read_scenario(text, None, shown).bench == scenario.bench
    counted = {"controller.gains_are": "per-sample", "controller.Ki": "0.75 1/m", "controller.Kd": "3 1/m"}
    sampled = read_scenario(text, None, counted).bench
    assert sampled is not None and sampled.value_of("controllers.drive.Ki") == 0.75
    with pytest.raises(InputError, match="cannot be converted to `1/m/s`"):
        read_scenario(text, None, {"controller.Ki": "0.75 1/m"})
    halves = "measured = 'position'\nperiod = '20 ms'\nstart = '60 degC'\n[controller.outer]\nKp = '20 K/mm'\n"
    halves += "law = { high = '80 K' }\n[controller.inner]\nKp = '0.05 1/K'\nKi = '2 %/K/s'\n"
    plain = PLANT + DRIVER + f"[controller]\nkind = 'cascade'\n{halves}" + REFERENCE
    halved = read_scenario(plain).bench
    assert halved is not None
    outer, inner = (halved.controllers.members()["drive"].__dict__[n] for n in ("outer", "inner"))
    assert (outer.Kp, outer.law.high, inner.Kp, inner.Ki) == pytest.approx((2e4, 80.0, 0.05, 0.02))


def test_changed_scenario_is_written_out_and_read_again() -> None:
    scenario = read_scenario(LOOP, None, {"controller.Kp": 99})
    assert read_scenario(scenario.text).bench == scenario.bench
    assert "Kp = 99" in scenario.text


@pytest.mark.parametrize(
    ("section", "name"),
    [
        ("kind = 'position'", "position"),
        ("kind = 'position'\nname = 'place'", "place"),
        ("kind = 'thermocouple'", "temperature"),
        ("kind = 'resistance'", "resistance"),
        ("kind = 'ideal'\nof = 'strain'", "strain"),
    ],
)
def test_sensor_is_called_like_what_it_measures(section: str, name: str) -> None:
    wave = "waveform = { kind = 'constant', level = 0.1 }\n"
    bench = read_scenario(PLANT + DRIVER + wave + f"[sensor]\n{section}\n[bench]\nperiod = '20 ms'").bench
    assert bench is not None
    assert list(bench.sensors.members()) == [name]


def test_model_of_an_observer_is_the_system_or_differs_where_it_says() -> None:
    text = without(LOOP, SENSOR) + "[sensor]\nkind = 'resistance'\n"
    text = text.replace('"position"', '"estimated.position"') + "[observer]\nkind = 'extended-kalman'\n"
    right = read_scenario(text)
    wrong = read_scenario(text + 'model = { "element.diameter" = "0.14 mm" }\n')
    assert right.bench is not None
    assert wrong.bench is not None
    (own,) = right.bench.observers.members().values()
    (other,) = wrong.bench.observers.members().values()
    assert own.model == right.system
    assert other.model == right.system.with_values({"element.diameter": "0.14 mm"})
    again = read_scenario(wrong.text, None, {"observer.model.element.length": "240 mm"})
    assert placed(again)["observer.model.element.length"].value == pytest.approx(0.24)


SENSED = without(LOOP, SENSOR).replace('"position"', '"estimated.position"') + "[sensor]\nkind = 'resistance'\n"
RPHASE = {"kind": "r-phase", "R_s": "55 degC", "R_f": "50 degC", "dT_R": "3 K", "C_R": "17 MPa/K", "E_R": "45 GPa"}


def test_a_model_may_be_of_another_kind() -> None:
    """Numbers that both laws have are those of the plant; parts of other kinds bring their own."""
    changes = {
        "observer": {"kind": "extended-kalman"},
        "observer.model": {
            "element.law": {**RPHASE, "eps_R": 0.005, "latent_R": 0.2, "A_s": "70 degC"},
            "mechanism": {"kind": "dead-weight", "mass": "100 g"},
            "environment": {"cooling": {"kind": "polynomial", "h0": "90 W/m^2/K"}},
        },
    }
    scenario = read_scenario(SENSED, None, changes)
    assert scenario.bench is not None
    found: Any = next(iter(scenario.bench.observers.members().values()))
    own: Any = scenario.system
    other = found.model
    kinds = [other.element.law, other.mechanism, other.environment.cooling]
    assert [one.registered_name for one in kinds] == ["r-phase", "dead-weight", "polynomial"]
    assert (other.element.law.A_s, other.element.law.M_s) == (343.15, own.element.law.M_s)
    assert other.element.diameter == own.element.diameter
    again = read_scenario(scenario.text, None, {"observer.model.element.law.R_s": "56 degC"})
    assert placed(again)["observer.model.element.law.R_s"].value == pytest.approx(329.15)


def test_a_bank_has_models_of_its_own_or_the_usual_ones() -> None:
    text = SENSED + "[observer]\nkind = 'model-bank'\n"
    usual = read_scenario(text).bench
    windy = "[observer.models.windy]\n'environment.cooling' = { kind = 'polynomial', h0 = '300 W/m^2/K' }\n"
    own = read_scenario(text + "model = { 'element.diameter' = '0.14 mm' }\n" + windy)
    assert usual is not None
    assert own.bench is not None
    names = [n for n in list_readings(usual) if n.startswith("estimated.probability_")]
    assert [n.removeprefix("estimated.probability_") for n in names] == [AS_MODELLED, *USUAL]
    bank: Any = next(iter(own.bench.observers.members().values()))
    (model,) = bank.models.members().values()
    assert (model.element.diameter, model.environment.cooling.h0) == (pytest.approx(0.14e-3), 300.0)
    assert placed(own)["observer.models.windy.environment.cooling.h0"].value == 300.0


def test_gains_by_points_and_components_of_components() -> None:
    rising = "rising = { low = { at = '0 mm', Kp = 100 }, high = { at = '4 mm', Kp = 200 } }"
    scenario = controlled(f"kind = 'scheduled-pid'\nmeasured = 'position'\n{rising}\n")
    assert scenario.bench is not None
    found = scenario.bench.controllers.members()["drive"]
    assert isinstance(found, ScheduledPid)
    assert [p.Kp for p in found.rising.members().values()] == [100.0, 200.0]
    inner = controlled("kind = 'feedforward'\nmeasured = 'position'\nKp = 50\nhigh = 0.7\nahead = 2\n")
    leaves = placed(inner)
    assert (leaves["controller.Kp"].value, leaves["controller.high"].value) == (50.0, 0.7)
    assert inner.origins["controller.high"] == "scenario"


def test_controller_that_plans_has_the_period_of_the_bench_and_the_system_as_its_model() -> None:
    plan = "horizon = '1 s'\nblocks = 5\nprice = { error = '1 mm' }\n"
    scenario = controlled(f"kind = 'mpc'\nmeasured = 'position'\n{plan}")
    assert scenario.bench is not None
    (one,) = scenario.bench.controllers.members().values()
    assert isinstance(one, Mpc)
    assert (one.blocks, one.period, one.model) == (5, 0.02, scenario.system)
    assert placed(scenario)["controller.horizon"].value == 1.0


def test_a_bench_without_a_controller_has_no_step() -> None:
    scenario = controlled("kind = 'on-off'\nmeasured = 'position'\nband = '0.1 mm'\nhigh = 0.8\n")
    assert scenario.bench is not None
    with pytest.raises(ParameterError, match=r"no controller.*outside of the bench"):
        RealtimeStep(scenario.bench.with_parts(controllers=Controllers()))


GUARD = """
[supervisor]
kind = "guard"

[supervisor.checks.hot]
kind = "overheat"
reading = "temperature"
limit = "30 degC"
"""


def test_guard_cuts_and_faults_act() -> None:
    sensors = SENSOR.replace("[sensor]", "[sensors.position]")
    text = without(LOOP, SENSOR) + sensors + "[sensors.temperature]\nkind = 'ideal'\nof = 'temperature'\n"
    text = text.replace("Kp = 150", "Kp = 3000")
    free = read_scenario(text).run(runtime="floats")
    cut = read_scenario(text + GUARD).run(runtime="floats")
    assert max(free["temperature"]) > 308.0
    assert max(cut["temperature"]) < 306.0
    assert cut["alarm"][0] == 0.0
    assert cut["alarm"][-1] == 1.0
    assert cut["drive"][-1] == 0.0 < cut["wanted"][-1]
    sag = "[faults.sag]\nkind = 'supply-sag'\nshare = 0.5\nstart = '0.2 s'\n"
    weak = read_scenario(text + sag).run(runtime="floats")
    half = 10
    assert weak["temperature"][:half].tolist() == free["temperature"][:half].tolist()
    assert weak["temperature"][-1] < free["temperature"][-1] - 1.0


def test_machine_has_controllers_by_port() -> None:
    document = (EXAMPLES / "closed_loop_platform.toml").read_text(encoding="utf-8")
    scenario = read_scenario(document, None, {"run.duration": "0.1 s"})
    assert scenario.bench is not None
    assert list(scenario.bench.controllers.members()) == ["first"]
    result = scenario.run(runtime="floats")
    assert result.columns["first.drive"][1] == 5.0
    assert result.columns["second.drive"][1] == 0.0
    single = document.replace("[controllers.first]", "[controller]")
    single = single.replace("[references.first]", "[reference]")
    with pytest.raises(ParameterError, match=r"which of the drives first, second, third"):
        read_scenario(single)


def test_model_of_blocks_is_controlled_too() -> None:
    text = """
[model]
file = "model_run.json"
[controller]
kind = "pid"
measured = "position"
period = "0.2 s"
Kp = 100
high = "16 %"
[reference]
kind = "constant"
level = "3 mm"
[run]
duration = "20 s"
"""
    scenario = read_scenario(text, EXAMPLES / "loop.toml")
    assert placed(scenario)["controller.high"].value == pytest.approx(0.16)
    result = scenario.run(runtime="floats")
    assert result.columns["wanted"][0] == pytest.approx(min(0.16, 100 * 0.003), rel=0.01)
    assert max(result["position"]) > 1e-3


# ---------------------------------------------------------------- what is refused

REFUSED = [
    ({"controler": {"kind": "pid"}}, "has no `controler`. Did you mean `controller`?"),
    ({"controller.Kq": 1}, "[controller] `pid` has no `Kq`"),
    ({"controller.kind": "pit"}, "Did you mean `pid`?"),
    ({"controller.measured": "positon"}, "Did you mean `position`?"),
    ({"controller.measured": []}, "cannot measure"),
    ({"controller.law.high": 0.5}, "`high` and `law.high` are the same; leave one out"),
    ({"sensor.dely": "1 s"}, "[sensor] `position` has no `dely`. Did you mean `delay`?"),
    ({"sensor.of": "strian"}, "looks at `strian`, which the plant does not have"),
    ({"sensor.name": "my place"}, "[sensor] A name consists of letters"),
    (
        {"supervisor": {"kind": "guard", "holt": "1 s", "checks": {"hot": {"kind": "overheat"}}}},
        "[supervisor] `guard` has no `holt`. Did you mean `hold`?",
    ),
    ({"reference.level": "1 mm"}, "[reference] `sine` has no `level`"),
    ({"bench.period": "10 ms"}, "`period` stands in [controller] and [bench]; leave one"),
    ({"bench.seed": 1}, "write it in [run], such as `seed = 1`"),
    ({"run.seed": 1.5}, "[run] Parameter `seed` of `Run` must be a whole number"),
    ({"bench.switching": "pulse"}, "Did you mean `pulses`?"),
    ({"references": {"drive": "constant"}}, "[reference] or [references.NAME], not both"),
    ({"controller.reference": "constant"}, "[reference] or [controller.reference], not both"),
    ({"drive.kind": "voltage"}, "[drive] or [driver], not both"),
    ({"driver.waveform": {"kind": "constant", "level": 1}}, "has a waveform as well; leave one"),
    ({"faults.one": {"kind": "stuck", "sensor": "place"}}, "there is no sensor `place`"),
    ({"faults.one": {"kind": "stock"}}, "Did you mean `stuck`?"),
    ({"supervisor": {"kind": "gard"}}, "Did you mean `guard`?"),
    ({"observer": {"kind": "extended-kalman", "model": "wire"}}, "A model is a table"),
    ({"observer": {"kind": "extended-kalman", "model": {"element": {"law": "mass"}}}}, "No law named `mass`. Did"),
    ({"observer": {"kind": "model-bank", "models": "fan"}}, "`models` must be tables by name"),
    ({"observer": {"kind": "model-bank", "models": {"a b": {}}}}, "letters, digits and underscores"),
]


@pytest.mark.parametrize(("changes", "sentence"), REFUSED, ids=[next(iter(c)) for c, _ in REFUSED])
def test_what_does_not_fit_is_refused_with_a_sentence(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as raised:
        read_scenario(LOOP, None, changes)
    assert sentence in str(raised.value)


@pytest.mark.parametrize(
    ("gone", "sentence"),
    [
        ((REFERENCE,), "[controller] needs a reference; write a section [reference]"),
        (('period = "20 ms"\n',), "A bench needs `period`"),
        ((CONTROLLER, SENSOR), "[reference] has no effect, since there is neither"),
        (('kind = "position"\n',), "[sensor] needs `kind`"),
        (("Kp = 150\n",), "[controller] `pid` needs `Kp`"),
        ((DRIVER,), "needs a section [drive]"),
    ],
    ids=["reference", "period", "idle", "kind", "gain", "driver"],
)
def test_what_is_missing_is_named(gone: tuple[str, ...], sentence: str) -> None:
    with pytest.raises(ParameterError) as raised:
        read_scenario(without(LOOP, *gone))
    assert sentence in str(raised.value)


def test_reference_of_another_unit_is_refused() -> None:
    with pytest.raises(UnitError, match=r"\[reference\] .*`degC` cannot be converted to `m`"):
        read_scenario(LOOP, None, {"reference.high": "40 degC"})


def test_switched_off_sections_are_no_bench_of_their_own() -> None:
    """The sound scenario is read: a refusal above is about what was changed."""
    assert read_scenario(as_toml(change_document({}, {})) + LOOP).bench is not None


def test_examples_of_closed_loops_are_sound() -> None:
    paths = sorted(EXAMPLES.glob("closed_loop*.toml"))
    assert len(paths) >= 6
    for path in paths:
        scenario = load(path)
        assert scenario.bench is not None
        assert math.isfinite(scenario.bench.period)


def test_reference_without_its_controller_is_refused() -> None:
    several = LOOP.replace("[controller]", "[controllers.drive]").replace('period = "20 ms"\n', "")
    several = several.replace("[reference]", "[references.drive]") + "[bench]\nperiod = '20 ms'\n"
    assert read_scenario(several).bench == read_scenario(LOOP).bench
    with pytest.raises(ParameterError, match=r"\[references.drve\] has no effect"):
        read_scenario(several, None, {"references.drve": {"kind": "constant", "level": "1 mm"}})
    with pytest.raises(ParameterError, match=r"\[controllers.drve\] There is no drive `drve`"):
        read_scenario(several, None, {"controllers.drve": {"kind": "pid"}})
