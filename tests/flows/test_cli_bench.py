"""Command line on closed loops: run, check, params, cite and the lists of what a bench is made of.

Source of truth: the scenario itself, and the registries.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from command import Command

from martensite.scenario.catalogue import list_registries
from martensite.scenario.netcdf import read_labelled
from martensite.scenario.scenario import load, read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples"
SHORT = ("--runtime", "floats", "--set", "run.duration=0.5 s")
LISTS = ("drives", "sensors", "observers", "controllers", "supervisors", "faults")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a closed loop in it."""
    text = (EXAMPLES / "closed_loop.toml").read_text(encoding="utf-8")
    (tmp_path / "loop.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


command = Command()
call, fine, refused = command, command.fine, command.refused


# ---------------------------------------------------------------- run


def test_run_writes_every_column_and_the_scenario(folder: Path) -> None:
    printed = fine("run", "loop.toml", *SHORT, "--set", "controller.Kp=90")
    assert "reading of position" in printed
    assert (folder / "loop.png").read_bytes()[:4] == b"\x89PNG"
    saved = read_labelled("loop.nc")
    same = load("loop.toml", {"run.duration": "0.5 s", "controller.Kp": 90}).run(runtime="floats")
    assert set(same.columns) <= set(saved.variables)
    for name in ("measured.position", "reference", "wanted", "drive"):
        assert saved[name].values.tolist() == same[name].tolist()
    assert saved["measured.position"].attrs["units"] == "m"
    again = read_scenario(saved.attrs["scenario"])
    assert again.bench is not None
    assert again.bench.value_of("controllers.drive.Kp") == 90.0
    assert "astrom1995" in saved.attrs["citations"]


def test_run_json_holds_the_loop(folder: Path) -> None:
    report = json.loads(fine("run", "loop.toml", *SHORT, "--no-figure", "--json"))
    assert report["columns"]["reference"] == {"lowest": 1e-3, "highest": 1e-3, "unit": "m"}
    assert report["steps"] == 25
    assert report["files"] == ["loop.nc"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--tolerance", "1e-3"), "Option `--tolerance` has no effect"),
        (("--carrier", "100 Hz"), "without a bench"),
        (("--set", "controller.Kq=1"), "`pid` has no `Kq`"),
        (("--set", "controller.measured=angle"), "there is no such reading"),
    ],
)
def test_run_refuses_what_has_no_effect_on_a_bench(folder: Path, arguments: tuple[str, ...], sentence: str) -> None:
    assert sentence in refused("run", "loop.toml", *SHORT, *arguments)
    assert {path.name for path in folder.iterdir()} == {"loop.toml"}


# ---------------------------------------------------------------- check, params, cite


def test_check_says_how_many_periods(folder: Path) -> None:
    """In JSON, with all findings, in `test_check_loops.py`."""
    assert "24 s in 1200 periods of 0.02 s" in fine("check", "loop.toml")


def test_params_shows_every_number_where_set_reaches_it(folder: Path) -> None:
    rows = json.loads(fine("params", "loop.toml", "--json"))
    found = {row["path"]: row for row in rows}
    assert found["controller.Kp"]["from"] == "scenario"
    assert found["controller.Kd"]["from"] == "default"
    assert found["driver.supply"]["unit"] == "V"
    assert found["reference.increment"]["unit"] == "m"
    assert found["sensor.delay"]["value"] == pytest.approx(0.02)
    assert len(found) == len(rows)
    own = [r for r in rows if r["path"].startswith(("sensor", "controller", "reference"))]
    changes = {
        r["path"]: f"{r['value'] + 0.1:.6g} {r['unit']}" for r in own if r["unit"] != "1" and r["value"] is not None
    }
    assert {"controller.Kp", "controller.Ki"} < changes.keys()
    del changes["controller.Td"]
    changes |= {"controller.law.low": 0.2}
    again = load("loop.toml", changes)
    after = {again.places.path(leaf.path): leaf.value for leaf in again.leaves()}
    for path in changes:
        assert after[path] != found[path]["value"]


def test_params_leaves_out_models_that_are_the_system_itself(folder: Path) -> None:
    path = str(EXAMPLES / "closed_loop_sensorless.toml")
    known = [row["path"] for row in json.loads(fine("params", path, "--json"))]
    assert not any(name.startswith("observer.model") for name in known)
    change = ("--set", "observer.model.element.diameter=0.14 mm")
    rows = json.loads(fine("params", path, *change, "--json"))
    (changed,) = [row for row in rows if row["path"].startswith("observer.model")]
    assert (changed["path"], changed["from"]) == ("observer.model.element.diameter", "scenario")


def test_cite_names_the_works_behind_the_controller(folder: Path) -> None:
    assert "@book{astrom1995" in fine("cite", "loop.toml")


# ---------------------------------------------------------------- lists


@pytest.mark.parametrize("kind", LISTS)
def test_lists_hold_the_registry(kind: str) -> None:
    registry = list_registries()[kind.removesuffix("s")]
    found = json.loads(fine("list", kind, "--json"))
    assert [row["name"] for row in found] == registry.names()
    assert all(row["summary"] for row in found)
    name = registry.names()[0]
    described = json.loads(fine("list", kind, name, "--json"))
    assert {row["name"] for row in described["parameters"]} == set(registry[name].declarations)
    assert name in fine("list", kind)


def test_unknown_kinds_are_answered_with_the_nearest_name() -> None:
    assert "Did you mean `pid`?" in refused("list", "controller", "pit")


def test_free_texts_are_described_as_such() -> None:
    rows: list[Any] = json.loads(fine("list", "controller", "pid", "--json"))["parameters"]
    (measured,) = [row for row in rows if row["name"] == "measured"]
    assert measured["allowed"] == "text"


def test_help_and_a_scenario_with_a_controller_load_nothing_heavy() -> None:
    path = EXAMPLES / "closed_loop.toml"
    code = (
        "import sys, martensite.cli\n"
        "from martensite.scenario.scenario import load\n"
        "light = not any('martensite.control.controllers' in name for name in sys.modules)\n"
        f"load({str(path)!r})\n"
        "print(light, 'scipy' in sys.modules, 'matplotlib' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "False", "False"]
