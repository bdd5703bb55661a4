"""Command line: what is printed and written, one sentence and exit code 2 on bad input."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from one_wire import LIFTED, write_wire
from typer.testing import CliRunner, Result

from martensite.base.errors import DataError, SolveError
from martensite.cli import app
from martensite.fit.experiment_kinds.base import list_kinds
from martensite.scenario.scenario import Scenario

SCENARIO = write_wire(
    "Lifting 400 g", law='"liang-rogers"', **LIFTED | {"run": 'duration = "40 s"\ntolerance = 1e-3\nsamples = 101'}
)
COOL = ("--set", "drive.waveform.high=2 V")
"""Keeps the temperature limit."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with one scenario in it."""
    (tmp_path / "wire.toml").write_text(SCENARIO, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def fine(*arguments: str) -> str:
    """Standard output of a command that succeeds and has nothing to complain about."""
    done = call(*arguments)
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    return done.stdout


def parsed(*arguments: str) -> Any:
    return json.loads(fine(*arguments, "--json"))


def refused(*arguments: str, code: int = 2) -> str:
    """The sentence with which a command is refused; nothing else is printed."""
    done = call(*arguments)
    assert done.exit_code == code, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert done.stderr.endswith(".\n")
    assert done.stderr.count("\n") == 1
    return done.stderr


def process(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


# ---------------------------------------------------------------- run


def test_run_prints_a_summary_and_writes_data_and_figure(folder: Path) -> None:
    printed = fine("run", "wire.toml")
    assert "Lifting 400 g" in printed
    assert "wire temperature" in printed
    assert "limit 140 °C" in printed
    assert names(folder) == {"wire.toml", "wire.nc", "wire.png"}
    assert (folder / "wire.png").read_bytes()[:4] == b"\x89PNG"
    assert (folder / "wire.nc").read_bytes()[1:4] == b"HDF"


def test_run_json_holds_numbers_in_si(folder: Path) -> None:
    report = parsed("run", "wire.toml", "--no-figure")
    assert report["duration"] == 40.0
    assert report["status"] == "OK"
    assert report["accuracy"] <= 1e-3
    assert report["columns"]["temperature"]["unit"] == "K"
    assert report["columns"]["temperature"]["lowest"] == pytest.approx(295.15)
    assert report["stroke"] == pytest.approx(
        report["columns"]["position"]["highest"] - report["columns"]["position"]["lowest"]
    )
    assert report["files"] == ["wire.nc"]
    assert names(folder) == {"wire.toml", "wire.nc"}


def test_saved_data_hold_the_scenario_that_was_run(folder: Path) -> None:
    from martensite.scenario.netcdf import read_labelled
    from martensite.scenario.scenario import read_scenario

    fine("run", "wire.toml", "--no-figure", "--set", "element.length=100 mm", "--out", "a.nc")
    text = read_labelled("a.nc").attrs["scenario"]
    assert read_scenario(text).single_system.element.__dict__["length"] == pytest.approx(0.1)


def test_settings_tolerance_and_runtime_change_the_run(folder: Path) -> None:
    first = parsed("run", "wire.toml", "--no-figure")
    short = parsed("run", "wire.toml", "--no-figure", "--force", "--set", "element.length=100 mm")
    fine_ = parsed("run", "wire.toml", "--no-figure", "--force", "--tolerance", "1e-5")
    assert short["stroke"] < 0.5 * first["stroke"]
    assert fine_["steps"] > first["steps"]
    assert "No runtime named `float`" in refused("run", "wire.toml", "--force", "--runtime", "float")


def test_overheating_names_the_limit(folder: Path) -> None:
    hot = ("--set", 'drive.waveform={kind="constant", level="3 V"}')
    report = parsed("run", "wire.toml", "--no-figure", *hot)
    assert any("above the `temperature_limit` of 140 °C" in line for line in report["warnings"])
    assert "`temperature_limit`" in fine("run", "wire.toml", "--no-figure", "--force", *hot)


def test_comparison_with_a_record(folder: Path) -> None:
    fine("run", "wire.toml", "--no-figure")
    log = "time [s],temperature [degC],position [mm]\n0,23,0\n10,90,5\n"
    (folder / "log.csv").write_text(log, encoding="utf-8")
    report = parsed("run", "wire.toml", "--no-figure", "--force", "--compare", "log.csv")
    compared = {entry["quantity"]: entry for entry in report["comparison"]}
    assert set(compared) == {"temperature", "position"}
    assert compared["position"]["range"] == pytest.approx(5e-3)
    printed = fine("run", "wire.toml", "--no-figure", "--force", "--compare", "log.csv")
    assert "RMS" in printed


def test_measured_record_of_the_scenario_is_compared_unless_unwanted(folder: Path) -> None:
    (folder / "log.csv").write_text("0\n20\n", encoding="utf-8")
    text = SCENARIO + '[measured]\nfile = "log.csv"\ncolumns = ["position [mm]"]\ninterval = "9 s"\n'
    (folder / "wire.toml").write_text(text, encoding="utf-8")
    (entry,) = parsed("run", "wire.toml", "--no-figure")["comparison"]
    assert (entry["quantity"], entry["range"]) == ("position", pytest.approx(0.02))
    silent = parsed("run", "wire.toml", "--no-figure", "--force", "--no-compare")
    assert silent["comparison"] == []


def test_columns_name_those_of_a_file_without_headings(folder: Path) -> None:
    (folder / "log.csv").write_text("0,23\n10,90\n", encoding="utf-8")
    columns = ("--compare", "log.csv", "--as", "1=time[s]", "--as", "2=temperature[degC]")
    assert len(parsed("run", "wire.toml", "--no-figure", *columns)["comparison"]) == 1


@pytest.mark.parametrize("ending", ["svg", pytest.param("pdf", marks=pytest.mark.slow)])
def test_figure_in_another_format(folder: Path, ending: str) -> None:
    fine("run", "wire.toml", "--figure", f"a.{ending}", "--out", "b.nc")
    assert names(folder) == {"wire.toml", "b.nc", f"a.{ending}"}


# ---------------------------------------------------------------- run: bad input

BAD_TABLES = {
    "back.csv": ("time [s],position [mm]\n0,0\n2,1\n1,2\n", "time must increase"),
    "late.csv": ("time [s],position [mm]\n0,0\n99,1\n", "the run must cover the record"),
    "other.csv": ("time [s],colour [1]\n0,0\n1,1\n", "no column in common"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_bad_record_is_refused_and_nothing_written(folder: Path, name: str) -> None:
    text, expected = BAD_TABLES[name]
    (folder / name).write_text(text, encoding="utf-8")
    assert expected in refused("run", "wire.toml", "--compare", name)
    assert names(folder) == {"wire.toml", name}


BAD_CALLS = [
    (("nowhere.toml",), "There is no scenario file `nowhere.toml`"),
    (("wire.toml", "--compare", "nowhere.csv"), "There is no file `nowhere.csv`"),
    (("wire.toml", "--set", "element.diametr=1 mm"), "Did you mean `diameter`"),
    (("wire.toml", "--set", "element.diameter=1 kg"), "cannot be converted to `m`"),
    (("wire.toml", "--set", "element.diameter=-1 mm"), "but is -1 mm"),
    (("wire.toml", "--set", "element.diameter=1"), "without a unit"),
    (("wire.toml", "--set", "element.law=liang"), "No law named `liang`"),
    (("wire.toml", "--set", "element.material=finger-mas"), "`finger-mas` does not hold"),
    (("wire.toml", "--set", "element.diameter"), "write `path=value`"),
    (("wire.toml", "--out", "a.txt"), "must end in .nc"),
    (("wire.toml", "--figure", "a.bmp"), "must end in .png or .svg or .pdf"),
    (("wire.toml", "--out", "no/where/a.nc"), "There is no folder `no/where`"),
    (("wire.toml", "--tolerance", "-1"), "`tolerance` must be"),
    (("wire.toml", "--as", "2=x[1]"), "`--as` has no effect"),
    (("wire.toml", "--no-figure", "--figure", "a.png"), "`--figure` has no effect"),
    (("wire.toml", "--no-compare", "--compare", "a.csv"), "`--compare` has no effect"),
    (("wire.toml", "--import", "no_such_module"), "Cannot import `no_such_module`"),
]


@pytest.mark.parametrize("arguments, expected", BAD_CALLS)
def test_bad_call_is_refused_and_nothing_written(folder: Path, arguments: tuple[str, ...], expected: str) -> None:
    assert expected in refused("run", *arguments)
    assert names(folder) == {"wire.toml"}


@pytest.mark.parametrize("name", [pytest.param("wire.nc", marks=pytest.mark.slow), "wire.png"])
def test_existing_file_is_kept_without_force(folder: Path, name: str) -> None:
    (folder / name).write_text("mine", encoding="utf-8")
    assert f"`{name}` is there already; use --force" in refused("run", "wire.toml")
    assert names(folder) == {"wire.toml", name}
    assert (folder / name).read_text(encoding="utf-8") == "mine"
    fine("run", "wire.toml", "--force")
    assert (folder / name).read_bytes() != b"mine"


def test_failed_run_leaves_existing_files_alone(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise SolveError("The step at t = 1 s failed.")

    (folder / "wire.nc").write_text("mine", encoding="utf-8")
    monkeypatch.setattr(Scenario, "run", fail)
    assert "The step at t = 1 s failed." in refused("run", "wire.toml", "--force", code=1)
    assert names(folder) == {"wire.toml", "wire.nc"}
    assert (folder / "wire.nc").read_text(encoding="utf-8") == "mine"


def test_failing_figure_leaves_no_data_behind(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise DataError("The disk is full.")

    monkeypatch.setattr("martensite.show.figures.overview.save_figure", fail)
    assert "The disk is full." in refused("run", "wire.toml")
    assert names(folder) == {"wire.toml"}


# ---------------------------------------------------------------- other commands


def test_own_module_adds_a_law(folder: Path) -> None:
    (folder / "mine.py").write_text(
        "from martensite.physics.laws.base import LAWS\n"
        "from martensite.physics.laws.strip_laws import LiangRogers\n"
        "@LAWS.register('mine')\n"
        "class Mine(LiangRogers):\n"
        "    'A law of my own.'\n",
        encoding="utf-8",
    )
    text = SCENARIO.replace('"liang-rogers"', '"mine"').replace("2.5 V", "2 V")
    (folder / "own.toml").write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "martensite", "check", "own.toml", "--import", "mine.py", "--json"],
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["title"] == "Lifting 400 g"


def test_check_reports_cautions_and_writes_nothing(folder: Path) -> None:
    report = parsed("check", "wire.toml", *COOL, "--set", "element.law.Theta=0.5 MPa/K")
    assert any("Theta > 0" in caution for caution in report["cautions"])
    assert "element.law.A_s" in report["doubtful"]
    assert report["steps"] >= 100
    assert ": valid. All limits are kept." in fine("check", "wire.toml", *COOL)
    assert "cannot be converted" in refused("check", "wire.toml", "--set", "run.duration=1 m")
    assert names(folder) == {"wire.toml"}


def test_params_of_a_scenario_are_the_paths_that_set_takes(folder: Path) -> None:
    found = {entry["path"]: entry for entry in parsed("params", "wire.toml")}
    assert found["element.diameter"]["value"] == pytest.approx(0.381e-3)
    assert found["element.diameter"]["from"] == "scenario"
    assert found["element.density"]["from"] == "datasheet, flexinol-90"
    assert found["drive.waveform.high"]["unit"] == "V"
    assert found["drive.series_resistance"]["from"] == "default"
    settings: list[str] = []
    for path, entry in found.items():
        if entry["value"] is not None:
            setting = f"{path}={entry['value']!r} {entry['unit']}"
            settings += ["--set", setting.removesuffix(" 1")]
    assert len(settings) > 40
    parsed("check", "wire.toml", *settings, *COOL)
    text = fine("params", "wire.toml")
    assert "0.381 mm" in text
    assert " none " in text and " inf" not in text


@pytest.mark.parametrize("kind, name", [("law", "liang-rogers"), ("mechanism", "bias-spring")])
def test_listing_and_description(kind: str, name: str) -> None:
    command = "list", kind
    listed = parsed(*command)
    assert name in [entry["name"] for entry in listed]
    assert all(entry["summary"] for entry in listed)
    part = parsed(*command, name)
    assert all(entry["meaning"] and entry["allowed"] for entry in part["parameters"])
    printed = fine(*command, name)
    assert all(entry["name"] in printed for entry in part["parameters"])
    assert name in fine(*command)
    assert f"named `{name}x`" in refused(*command, name + "x")


def test_kinds_are_listed_and_known_in_the_plural() -> None:
    assert parsed("list", "laws") == parsed("list", "law")
    assert "Did you mean `law`" in refused("list", "lew")
    assert "tanaka" in fine("list")


def test_studies_are_listed_and_none_is_computed() -> None:
    listed = parsed("study")
    assert [one["key"] for one in listed][:3] == ["migaone", "hammerstein-wiener", "platform"]
    assert all(sum(one["tally"].values()) > 0 for one in listed)
    assert "all of kossoski2018" in fine("study")


@pytest.mark.parametrize("columns", ["80"])
def test_help_fits_a_terminal(columns: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    text = fine("--help")
    assert max(map(len, text.splitlines())) <= 80
    assert "..." not in text.partition("Simulate:")[2]


def test_materials_mark_what_is_not_measured() -> None:
    assert "flexinol-90" in fine("materials")
    assert {"name", "title", "summary"} == parsed("materials")[0].keys()
    material = parsed("materials", "niti-brinson-1993")
    assert material["values"]["E_A"]["kind"] == "recalled"
    printed = fine("materials", "niti-brinson-1993")
    assert "! assumed or recalled" in printed
    assert "! assumed" in printed
    assert "! datasheet" not in fine("materials", "flexinol-90")
    assert "Did you mean `flexinol-90`" in refused("materials", "flexinol90")


def test_cite_prints_the_works_behind_a_scenario(folder: Path) -> None:
    printed = fine("cite", "wire.toml")
    assert "@article{liang1990," in printed
    assert "@manual{dynalloy-f1140," in printed
    assert "copaci2019" not in printed
    assert printed.count("{") == printed.count("}")
    keys = [entry["key"] for entry in parsed("cite", "wire.toml")]
    assert keys[0] == "liang1990"
    assert len(keys) == len(set(keys))


def test_data_sets_are_listed_and_shown() -> None:
    listed = [entry["name"] for entry in parsed("data", "list")]
    assert "flexinol-isobaric" in listed
    assert "flexinol-isobaric" in fine("data")
    assert "data:flexinol-isobaric/isobaric_50MPa.txt" in fine("data", "show", "flexinol-isobaric")
    assert "Did you mean" in refused("data", "fetch", "flexinol-isobarik")


def test_study_shows_digest_claims_and_reasons() -> None:
    (told,) = parsed("study", "migaone")
    needed = {"id", "source", "published", "computed", "unit", "tolerance", "verdict", "why"}
    assert told["claims"] and told["reports"] and told["digest"]["use_instead"]
    assert all(needed <= claim.keys() for claim in told["claims"])
    assert sum(told["tally"].values()) == len(told["claims"]) + len(told["reports"])
    brief, whole = fine("study", "migaone"), fine("study", "migaone", "--all")
    assert brief.index("Recommended") < brief.index("self-contradictory")
    assert "actuation-time-thin" in whole and "actuation-time-thin" not in brief
    assert all(claim["id"] in whole for claim in told["claims"])
    assert "No study named `migatwo`" in refused("study", "migatwo")
    assert "@" in fine("cite", "migaone")


def test_a_study_is_computed_on_demand() -> None:
    (shipped,), (now,) = parsed("study", "migaone"), parsed("study", "migaone", "--recompute")
    assert shipped["made_by"] and not now["made_by"]
    assert shipped["digest"] == now["digest"]


def test_demo_runs_again_over_its_own_files(folder: Path) -> None:
    for name in ("migaone.nc", "migaone.png"):
        (folder / name).write_text("of the last time")
    printed = fine("demo")
    assert printed.index("Recommended") < printed.index("martensite study migaone")
    assert names(folder) == {"wire.toml", "migaone.nc", "migaone.png"}
    assert (folder / "migaone.png").read_bytes().startswith(b"\x89PNG")


# ---------------------------------------------------------------- the command itself


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from martensite.cli import app\n"
        "try: app(['--help'])\n"
        "except SystemExit as end: assert end.code == 0\n"
        "heavy = {'numpy', 'pint', 'xarray', 'matplotlib', 'h5netcdf', 'rich.console'}\n"
        "print(heavy & sys.modules.keys(), file=sys.stderr)"
    )
    done = process(code)
    assert done.stderr.strip() == "set()"
    assert "run " in done.stdout


def test_usage_errors_exit_with_2_and_unknown_commands_too() -> None:
    assert call("run").exit_code == 2
    assert call("rnu").exit_code == 2
    assert call("run", "x.toml", "--tolerance", "small").exit_code == 2


@pytest.mark.parametrize("order", [("--debug", "list", "x"), ("list", "x", "--debug")])
def test_debug_shows_the_error_itself(order: tuple[str, ...]) -> None:
    done = call(*order)
    assert done.exit_code == 1
    assert type(done.exception).__name__ == "UnknownNameError"


def test_version() -> None:
    assert fine("--version").startswith("martensite ")


def test_kinds_of_experiment_are_listed_in_the_order_of_recognition() -> None:
    found = parsed("list", "experiment")
    assert [one["name"] for one in found] == [one.registered_name for one in list_kinds()]
    assert {one["name"]: one["command"] for one in found}["dsc"] == "fit dsc"
    assert parsed("list")["experiment"] == sorted(one["name"] for one in found)
    assert "Did you mean `isobaric`" in refused("list", "experiment", "isobarik")
