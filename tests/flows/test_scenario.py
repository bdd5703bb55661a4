"""Scenario files: what is written is what is built, and what is wrong is said in one sentence."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from one_wire import hang, write_wire

from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import InputError
from martensite.base.toml_text import as_toml
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.scenario.overrides import change_document, read_settings
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.signals.sine import Sine

SOUND = write_wire(
    "Lifting 400 g",
    law='"liang-rogers"',
    diameter="0.381 mm",
    length="273 mm",
    ambient="38.5 degC",
    cooling='{ kind = "polynomial", h0 = "42.53 W/m^2/K", h2 = "0.00294 W/m^2/K^3" }',
    mechanism=hang("400 g"),
    drive='kind = "voltage"\nwaveform = { kind = "sine", low = "0 V", high = "2500 mV", frequency = "0.005 Hz" }',
    run='duration = "400 s"',
)
WAVEFORM = 'waveform = { kind = "sine", low = "0 V", high = "2500 mV", frequency = "0.005 Hz" }'
LAW = 'law = "liang-rogers"'


def edited(old: str, new: str) -> str:
    """The sound scenario with one passage replaced."""
    assert SOUND.count(old) == 1, old
    return SOUND.replace(old, new)


def sentence(text: str, path: Path | None = None) -> str:
    """The sentence with which a scenario is refused."""
    with pytest.raises(InputError) as caught:
        read_scenario(text, path)
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)
    return str(caught.value)


def law_of(scenario: Scenario) -> LiangRogers:
    law = scenario.single_system.element.law
    assert isinstance(law, LiangRogers)
    return law


# ---------------------------------------------------------------- what is built


def test_values_reach_their_parts_in_si() -> None:
    scenario = read_scenario(SOUND)
    wire, load_ = scenario.single_system.element, scenario.system.mechanism
    assert isinstance(wire, Wire)
    assert isinstance(load_, DeadWeight)
    assert isinstance(scenario.waveform, Sine)
    assert (wire.diameter, wire.length) == (0.381e-3, 0.273)
    assert scenario.single_system.environment.temperature == pytest.approx(311.65)
    assert load_.mass == pytest.approx(0.4)
    assert scenario.waveform.high == pytest.approx(2.5)
    assert (scenario.duration, scenario.tolerance, scenario.samples) == (400.0, 1e-4, 1001)
    assert scenario.step is None
    assert scenario.title == "Lifting 400 g"
    assert scenario.text == SOUND


def test_material_fills_element_law_resistance_and_limits() -> None:
    scenario = read_scenario(SOUND)
    material, system = scenario.material, scenario.single_system
    assert material is not None
    values = {name: number.value for name, number in material.values.items()}
    element = system.element
    assert isinstance(element, Wire)
    assert element.density == values["density"]
    assert law_of(scenario).C_A == values["C_A"]
    assert element.resistance.__dict__["rho_A"] == values["rho_A"]
    assert element.limits.stress_limit == values["stress_limit"]


def test_scenario_wins_over_material_and_material_over_default() -> None:
    text = edited(LAW, 'law = { kind = "liang-rogers", A_s = "70 degC", modulus = "mixture" }')
    scenario = read_scenario(text)
    law = law_of(scenario)
    assert law.A_s == pytest.approx(343.15)
    assert law.A_f == pytest.approx(349.95)  # flexinol-90
    assert law.modulus == "mixture"
    assert scenario.origins["element.law.A_s"] == "scenario"
    assert scenario.origins["element.law.A_f"] == "assumed, flexinol-90"
    assert scenario.origins["element.law.history"] == "default"


def test_subsections_mean_the_same_as_inline_tables() -> None:
    assert SOUND.count("[environment]") == 1
    split = edited(LAW + "\n", "").replace("[environment]", '[element.law]\nkind = "liang-rogers"\n\n[environment]')
    assert read_scenario(split).system == read_scenario(SOUND).system


def test_chamber_needs_neither_environment_nor_cooling() -> None:
    text = edited('kind = "voltage"', 'kind = "temperature"').replace(
        WAVEFORM, 'waveform = { kind = "ramp", low = "20 degC", high = "120 degC", end = "60 s" }'
    )
    start, end = text.index("[environment]"), text.index("[mechanism]")
    scenario = read_scenario(text[:start] + text[end:])
    assert scenario.single_waveform.value(0.0) == pytest.approx(293.15)


def test_listed_waveform_gives_the_duration() -> None:
    listed = 'waveform = { kind = "table", times = ["0 s", "1 min"], values = ["0 V", "3 V"] }'
    scenario = read_scenario(edited(WAVEFORM, listed).replace('duration = "400 s"', ""))
    assert scenario.duration == 60.0
    assert scenario.single_waveform.value(30.0) == pytest.approx(1.5)


def test_recorded_waveform_is_found_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time [s],voltage [mV]\n0,0\n10,1000\n", encoding="utf-8")
    path = tmp_path / "scenario.toml"
    recorded = 'waveform = { kind = "table", file = "log.csv", column = "voltage" }'
    path.write_text(edited(WAVEFORM, recorded).replace('duration = "400 s"', ""), encoding="utf-8")
    scenario = load(path)
    assert scenario.duration == 10.0
    assert scenario.single_waveform.value(5.0) == pytest.approx(0.5)


def test_run_simulates_what_was_read() -> None:
    result = read_scenario(SOUND).run(tolerance=1e-3)
    assert result.times[-1] == 400.0
    assert 3e-3 < result.stroke < 0.05 * 0.273
    assert max(result["temperature"]) > 350.0


def test_loading_a_scenario_needs_no_heavy_package(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(SOUND, encoding="utf-8")
    code = (
        "import sys; from martensite.scenario.scenario import load;"
        f"load({str(path)!r}).run(tolerance=0.01, runtime='floats');"
        "print({'pint', 'xarray', 'typer', 'matplotlib'} & sys.modules.keys())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


# ---------------------------------------------------------------- what is refused

REFUSED = [
    # misspelt names
    ('diameter = "0.381 mm"', 'diametr = "0.381 mm"', "[element]", "Did you mean `diameter`"),
    ("[environment]", "[enviroment]", "scenario has no `enviroment`", "Did you mean `environment`"),
    (LAW, 'law = "liang-rodgers"', "No law named", "Did you mean `liang-rogers`"),
    (LAW, 'law = { kind = "liang-rogers", A_z = "70 degC" }', "[element.law]", "Did you mean `A_"),
    ('kind = "wire"', 'kind = "wir"', "No element named", "Did you mean `wire`"),
    ('"flexinol-90"', '"flexinol-09"', "[element] No material named", "`flexinol-90`"),
    ('kind = "dead-weight"', 'kind = "dead"', "[mechanism] No mechanism named", "`dead-weight`"),
    ('kind = "voltage"', 'kind = "volts"', "No drive named", "Did you mean `voltage`"),
    ('kind = "sine"', 'kind = "sinus"', "[drive.waveform] No waveform", "Did you mean `sine`"),
    ("frequency", "freqency", "[drive.waveform]", "Did you mean `frequency`"),
    ('kind = "polynomial"', 'kind = "poly"', "[environment.cooling] No cooling", "`polynomial`"),
    ('duration = "400 s"', 'durration = "400 s"', "[run]", "Did you mean `duration`"),
    (LAW, LAW + '\nE_A = "70 GPa"', "`wire` has no `E_A`", "`element.law.E_A`"),
    (LAW, 'law = { kind = "liang-rogers", history = "resum" }', "`history`", "mean `resume`"),
    # units
    ('"0.381 mm"', '"0.381 kg"', "[element] Parameter `diameter` of `wire`", "`kg`"),
    ('"0.381 mm"', '"0.381"', "`diameter`", "has no unit"),
    ('"0.381 mm"', "0.381", "`diameter` is 0.381 without a unit", 'diameter = "0.381 mm"'),
    ('"0.381 mm"', '"thin"', "`diameter`", "not a number with a unit"),
    ('"0.381 mm"', "true", "`diameter`", "must be a number or text"),
    ('"0.381 mm"', '"0.381 furlongs/moon"', "`diameter`", "not a known unit"),
    ('high = "2500 mV"', 'high = "2.5 A"', "Parameter `high` of `sine`", "cannot be converted"),
    ('high = "2500 mV"', "high = 2.5", "`high` is 2.5 without a unit", 'high = "2.5 V"'),
    ('duration = "400 s"', "duration = 400", "`duration` is 400 without a unit", '"400 s"'),
    # ranges
    ('"0.381 mm"', '"-0.381 mm"', "must be above 0 mm and at most 20 mm", "but is -0.381 mm"),
    ('"400 g"', '"-1 kg"', "[mechanism] Parameter `mass`", "but is -1 kg"),
    ('"400 s"', '"0 s"', "[run] Parameter `duration`", "must be above 0 s"),
    ('duration = "400 s"', 'duration = "400 s"\nsamples = 10.5', "[run]", "whole number"),
    ('low = "0 V"', 'low = "3 V"', "[drive.waveform]", "must be at most `high`"),
    (LAW, 'law = { kind = "liang-rogers", A_s = "99 degC" }', "[element.law]", "below `A_f`"),
    # missing
    ('length = "273 mm"', "", "[element] `wire` needs `length` [mm] (length at", 'length = "… mm"'),
    ('material = "flexinol-90"', "", "`liang-rogers` needs `E_A`", "name a `material`"),
    ('mass = "400 g"', "", "[mechanism] `dead-weight` needs `mass` [g]", 'mass = "… g"'),
    (LAW, "", "[element] needs `law`", "`liang-rogers`"),
    (WAVEFORM, "", "[drive] needs `waveform`", "`sine`"),
    ('kind = "sine", ', "", "[drive.waveform] needs `kind`", "`sine`"),
    ('kind = "wire"', "", "[element] needs `kind`", "`wire`"),
    ('duration = "400 s"', "", "[run] needs `duration`", '"60 s"'),
    ('[run]\nduration = "400 s"', "", "[run] needs `duration`", '"60 s"'),
    ('[mechanism]\nkind = "dead-weight"\nmass = "400 g"', "", "section [mechanism]", "none given"),
    ("cooling = {", "# cooling = {", "[environment] needs `cooling`", "`polynomial`"),
    # not TOML, not the right shape
    ('"0.381 mm"', "0.381 mm", "not valid TOML", "at line 7"),
    (LAW, "law = 3", "[element.law] must be a table", "but is 3"),
    ('material = "flexinol-90"', "material = 90", "[element] `material` must be", "but is 90"),
]


@pytest.mark.parametrize("old, new, where, remedy", REFUSED)
def test_bad_scenario_is_refused_with_a_sentence(old: str, new: str, where: str, remedy: str) -> None:
    found = sentence(edited(old, new))
    assert where in found
    assert remedy in found


def test_material_without_a_needed_number_is_named() -> None:
    found = sentence(edited('"flexinol-90"', '"finger-mas"'))
    assert "[element.law] `liang-rogers` needs" in found
    assert "`C_A` [MPa/K]" in found
    assert "material `finger-mas` does not hold it" in found
    assert "in [element.law]" in found


TABLES = [
    ('file = "gone.csv", column = "voltage"', "There is no file"),
    ('file = "log.csv", column = "volts"', "Did you mean `voltage`"),
    ('file = "log.csv", column = "temperature"', "is in K, but the drive needs V"),
    ('file = "log.csv"', "needs `column`"),
    ('column = "voltage"', "needs `file`"),
    ('file = "log.csv", colum = "voltage"', "Did you mean `column`"),
    ('file = "log.csv", column = "voltage", interval = 2', "must be text with a unit"),
    ('file = "log.csv", column = "voltage", interval = "2 m"', "cannot be converted to `s`"),
    ('file = "log.csv", column = "voltage", columns = "x"', "must be a list"),
    ('file = "back.csv", column = "voltage"', "time must increase"),
    ('file = "nan.csv", column = "voltage"', "numbers must be finite"),
    ('file = "bare.csv", column = "voltage"', "has no headings"),
    ('file = "data:flexinol/x.txt", column = "voltage"', "No data set named"),
    ('times = ["0 s", "1 s"], values = ["0 V"]', "equally long"),
    ('times = ["0 s", "0 s"], values = ["0 V", "1 V"]', "must increase"),
    ('times = ["0 s", "1 V"], values = ["0 V", "1 V"]', "cannot be converted to `s`"),
    ("times = [0, 1], values = [0, 1]", "must be text with a unit"),
]


@pytest.mark.parametrize("keys, expected", TABLES)
def test_bad_table_waveform_is_refused(tmp_path: Path, keys: str, expected: str) -> None:
    head = "time [s],voltage [V],temperature [degC]\n"
    rows = {"log": "0,0,20\n1,1,21\n", "back": "0,0,20\n1,1,21\n0.5,1,21\n", "nan": "0,nan,20\n"}
    for name, text in rows.items():
        (tmp_path / f"{name}.csv").write_text(head + text, encoding="utf-8")
    (tmp_path / "bare.csv").write_text("0,0\n1,1\n", encoding="utf-8")
    text = edited(WAVEFORM, f'waveform = {{ kind = "table", {keys} }}')
    found = sentence(text, tmp_path / "scenario.toml")
    assert expected in found
    assert "[drive.waveform]" in found


def test_missing_scenario_names_the_nearest_file(tmp_path: Path) -> None:
    (tmp_path / "finger.toml").write_text(SOUND, encoding="utf-8")
    with pytest.raises(InputError, match=r"Did you mean `finger\.toml`"):
        load(tmp_path / "fingre.toml")


def test_folder_and_binary_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Cannot read the scenario file"):
        load(tmp_path)
    (tmp_path / "x.toml").write_bytes(b"\x80\x81\x00")
    with pytest.raises(InputError, match="is not UTF-8"):
        load(tmp_path / "x.toml")


# ---------------------------------------------------------------- overrides


def test_settings_reach_into_components() -> None:
    settings = [
        'element.diameter="0.25 mm"',
        "mechanism.mass=1 kg",
        "element.law.A_s=70 degC",
        "element.resistance.rho_A=1e-6 ohm*m",
        "run.samples=51",
    ]
    scenario = read_scenario(SOUND, None, read_settings(settings))
    wire = scenario.single_system.element
    assert isinstance(wire, Wire)
    assert wire.diameter == 0.25e-3
    assert scenario.system.mechanism.__dict__["mass"] == 1.0
    assert law_of(scenario).A_s == pytest.approx(343.15)
    assert wire.resistance.__dict__["rho_A"] == 1e-6
    assert scenario.samples == 51


def test_text_of_a_changed_scenario_builds_the_same_again() -> None:
    first = read_scenario(SOUND, None, {"element.law.A_s": "70 degC", "run.samples": 51})
    again = read_scenario(first.text)
    assert again.system == first.system
    assert (again.samples, again.title) == (51, first.title)


@pytest.mark.parametrize(
    "setting, expected",
    [
        ("element.diametr=1 mm", "Did you mean `diameter`"),
        ("elment.diameter=1 mm", "Did you mean `element.diameter`"),
        ("element.diameter=0.25", "without a unit"),
        ("element.diameter.x=1 mm", "must be"),
        ("element.law.A_ss=70 degC", "Did you mean `A_s`"),
        ("run.duration.x=1", "[run]"),
        ("title.x=1", "`title` is a value, not a table"),
    ],
)
def test_bad_setting_is_refused(setting: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        read_scenario(SOUND, None, read_settings([setting]))
    assert expected in str(caught.value)


@pytest.mark.parametrize(("kind", "level"), [("triangle", 'high = "2 V"'), ("pwm", 'high = "2 V", duty = 0.3')])
def test_edges_without_end_are_refused_before_they_are_listed(kind: str, level: str) -> None:
    """The truth: two edges in a period."""
    text = edited(WAVEFORM, f'waveform = {{ kind = "{kind}", {level}, frequency = "1 kHz" }}')
    wave = read_scenario(text, overrides={"run.duration": "0.5 s"}).single_waveform
    assert abs(len(wave.edges(0.5)) - wave.count_edges(0.5)) < 2
    with pytest.raises(InputError, match=rf"`{kind}` has about 2e\+303 edges in 1e\+300 s"):
        read_scenario(text, overrides={"run.duration": "1e300 s"})


@pytest.mark.parametrize("setting", ["element.diameter", "=1 mm"])
def test_setting_without_path_or_value_is_refused(setting: str) -> None:
    with pytest.raises(InputError, match="write `path=value`"):
        read_settings([setting])


def test_toml_is_written_as_it_is_read() -> None:
    document = {
        "title": 'with "quotes", a \\ and °C',
        "element": {"kind": "wire", "law": {"kind": "x", "n": 1, "f": 1e-7, "on": True}},
        "run": {"list": ["a", 2.5], "odd key": "x"},
    }
    assert tomllib.loads(as_toml(document)) == document


def test_changing_leaves_the_original_alone() -> None:
    document = {"element": {"law": "liang-rogers"}}
    after = change_document(document, {"element.law.A_s": "1 K"})
    assert after == {"element": {"law": {"kind": "liang-rogers", "A_s": "1 K"}}}
    assert document == {"element": {"law": "liang-rogers"}}


def test_changing_leaves_what_it_is_given_alone() -> None:
    settings: dict[str, dict[str, str] | str] = {"element": {"law": "brinson"}, "element.law.A_s": "1 K"}
    assert change_document({}, settings)["element"]["law"]["A_s"] == "1 K"
    assert settings["element"] == {"law": "brinson"}
