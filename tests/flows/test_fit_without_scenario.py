"""`martensite fit LOG...` alone: what is recognised, proposed and said, and one sentence on bad input.

Source of truth: records whose columns say what they are, and rigs of known numbers (`benchmarks.driven_rigs`).
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from pathlib import Path
from shlex import split
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from benchmarks.driven_rigs import draw_rig
from command import Command

from martensite.base.errors import DataError, UnknownNameError
from martensite.fit import cross_validation
from martensite.fit.cross_validation import HeldOutError, pool_errors
from martensite.fit.experiment_kinds.base import list_kinds, propose_scenarios, recognise_experiment
from martensite.fit.experiment_kinds.values import make_pulses, make_record
from martensite.fit.log_models import model_logs

FIT = Command("fit")
DATA = Path(os.environ.get("MARTENSITE_DATA", "/nowhere"))
RECORDS = {one.registered_name: one.make_example()[0] for one in list_kinds()}


def test_what_is_set_is_not_assumed() -> None:
    record = RECORDS["stroke"]
    kind = recognise_experiment([record])
    given = {"element.diameter": "0.3 mm", "mechanism.mass": "80 g"}
    (free, assumed), (known, told) = (propose_scenarios(kind, [record], x) for x in ({}, given))
    assert [one.name for one in free] == ["a weight", "a bias spring"]
    assert [one.name for one in known] == ["a weight"]
    assert any("element.diameter" in note for note in assumed.sentences)
    assert not any("element.diameter" in note for note in told.sentences)
    assert known[0].document["element"]["diameter"] == "0.3 mm"


def test_free_cooling_gives_film_ambient_and_time_constant(tmp_path: Path) -> None:
    """An exponential of 4 s to 296 K with noise of 0.2 K, after a second at rest; the film follows from c and d."""
    times = np.linspace(0.0, 20.0, 120)
    kelvin = 296.0 + 64.0 * np.exp(-np.maximum(times - 1.0, 0.0) / 4.0) + np.random.default_rng(1).normal(0.0, 0.2, 120)
    path, kept = tmp_path / "fall.csv", tmp_path / "kept.toml"
    path.write_text("\n".join(["time [s],temperature [K]", *(f"{t},{x}" for t, x in zip(times, kelvin, strict=True))]))
    words = ("--set", "element.diameter=0.25 mm", "--set", "element.heat_capacity=800 J/kg/K")
    found = FIT.report(str(path), *words, "--save-scenario", str(kept))
    assert (found["experiment"]["kind"], found["predicts"]) == ("cooling", True)
    tau, low, high = found["time_constant"]
    assert low < 4.0 < high
    assert high - low < 0.2
    assert found["numbers"]["environment.cooling.h"] == pytest.approx(6450.0 * 800.0 * 0.25e-3 / (4.0 * tau))
    assert found["numbers"]["environment.temperature"] == pytest.approx(296.0, abs=0.2)
    again = json.loads(FIT(*split(found["again"])[2:], "--hold-out", "none", "--json").stdout)
    assert again["scores"][0]["fit_percent"] > 97.0


def test_nothing_that_varies_is_a_sentence() -> None:
    cooling = RECORDS["cooling"]
    with pytest.raises(DataError, match="cannot be told"):
        recognise_experiment([make_record({"voltage": 0.0 * make_pulses(), "force": 0.0 * make_pulses()})])
    with pytest.raises(DataError, match="no `isobaric` experiment"):
        recognise_experiment([RECORDS["stroke"]], "isobaric")
    with pytest.raises(UnknownNameError):
        recognise_experiment([cooling], "isobarric")


def test_loop_without_a_load_is_asked_for_it_in_one_sentence() -> None:
    columns = {name: x for name, x in RECORDS["isobaric"].columns.items() if name not in ("time", "stress")}
    record = make_record(columns)
    with pytest.raises(DataError, match="under which stress"):
        propose_scenarios(recognise_experiment([record]), [record], {})
    named = replace(record, name="wire_120MPa")
    proposals, _ = propose_scenarios(recognise_experiment([named]), [named], {})
    assert proposals[0].rows[0]["stress"][0] == 120e6


def test_missing_samples_of_a_loop_are_passed_over() -> None:
    columns = dict(RECORDS["isobaric"].columns)
    columns["strain"] = np.where(np.arange(80) % 7 == 0, np.nan, np.asarray(columns["strain"]))
    record = make_record(columns)
    proposals, _ = propose_scenarios(recognise_experiment([record]), [record], {})
    assert np.isfinite(proposals[0].rows[0]["strain"]).all()
    assert len(proposals[0].rows[0]) == 68


def test_model_predicts_only_where_it_beats_every_rival() -> None:
    rivals = {"mean": 10.0, "first-order lag": 1.2}
    one = HeldOutError(1.0, 10.0, rivals, "position", "m", math.nan, "a", True, 9)
    (pooled,) = pool_errors([one])
    assert not pooled.beats_rivals
    assert not pooled.predicts
    (better,) = pool_errors([replace(one, rms=0.9)])
    assert better.predicts
    (coarse,) = pool_errors([replace(one, rms=4.0, rivals={"mean": 10.0})])
    assert coarse.beats_rivals
    assert not coarse.predicts


@pytest.fixture(scope="module")
def rig_logs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Files of two logs of a rig within the models that are tried."""
    folder = tmp_path_factory.mktemp("rig")
    rig = draw_rig(17, records=2)
    paths: list[str] = []
    for one in rig.records:
        heads = "Time (s),Duty (-),Load (N)"
        rows = list(zip(one["time"], one["duty"], one["force"], strict=True))
        path = folder / f"{one.name}.csv"
        path.write_text("\n".join([heads, *(f"{t:.4f},{u:.5f},{f:.5f}" for t, u, f in rows), ""]))
        paths.append(str(path))
    return paths


def test_logs_alone_become_a_scenario_that_is_accepted_again(rig_logs: list[str], tmp_path: Path) -> None:
    kept = tmp_path / "kept.toml"
    found = json.loads(FIT(*rig_logs, "--json", "--save-scenario", str(kept)).stdout)
    assert found["experiment"]["kind"] == "blocked-force"
    assert found["predicts"]
    assert {one["record"] for one in found["held_out"]} == {"log1", "log2"}
    assert min(one["fit_percent"] for one in found["held_out"]) > 85.0
    assert found["next"]
    command = split(found["again"])
    assert command[-6:] == ["--as", "1=time[s]", "--as", "2=duty[1]", "--as", "3=force[N]"]
    command[command.index("--free") + 1] = "E_M"
    again = json.loads(FIT(*command[2:], "--hold-out", "none", "--json").stdout)
    assert again["scores"][0]["fit_percent"] > 85.0


def test_printed_command_fits_the_kept_scenario_again(tmp_path: Path) -> None:
    """Below title lines, with jitter, its stress in its name: the record as it was fitted is written."""
    loop = RECORDS["isobaric"].columns
    noise = 0.3 * np.random.default_rng(2).standard_normal(80)
    pairs = enumerate(zip(np.add(loop["temperature"], noise - 273.15), np.multiply(100.0, loop["strain"]), strict=True))
    path, kept = tmp_path / "wire_100MPa.csv", tmp_path / "kept.toml"
    rows = [f"{k};{kelvin:.2f};{strain:.4f}" for k, (kelvin, strain) in pairs]
    path.write_text("\n".join(["Report;7", "", "Time;Chamber;Strain", "s;degC;%", *rows]))
    told = json.loads(FIT(str(path), "--json", "--save-scenario", str(kept)).stdout)
    assert any("scatters by 0.3" in note or "scatters by 0.2" in note for note in told["notes"])
    command = split(told["again"])
    assert command[:3] == ["martensite", "fit", str(tmp_path / "kept_wire_100MPa.csv")]
    command[command.index("--free") + 1] = "A_f"
    again = json.loads(FIT(*command[2:], "--hold-out", "none", "--json").stdout)
    assert again["scores"][0]["fit_percent"] > 85.0


@pytest.mark.parametrize(("cycles", "kept"), [(1, False), (3, True)])
def test_the_held_out_tail_of_a_log_contains_no_whole_transformation(cycles: int, kept: bool) -> None:
    """One cycle cools in its last third: a model cannot learn A from heating alone and predict M."""
    times = np.linspace(0.0, 1.0, 301)
    strain = 1.0 - np.interp((times * cycles) % 1.0, [0.0, 0.5, 0.7, 0.95, 1.0], [0.0, 1.0, 1.0, 0.0, 0.0])
    log: Any = SimpleNamespace(times=times, measured=strain[:, None])
    assert cross_validation._shows_both_ways(log) is kept


def test_options_of_a_scenario_are_refused_without_one(rig_logs: list[str]) -> None:
    assert "needs --scenario" in FIT.refused(rig_logs[0], "--each", "offset")
    assert "needs --scenario" in FIT.refused(rig_logs[0], "--profile", "A_s")
    assert "Did you mean" in FIT.refused(rig_logs[0], "--experiment", "blocked-forces")


def test_search_options_hold_without_a_scenario(tmp_path: Path) -> None:
    """Source of truth: what is asked for."""
    loop, path = RECORDS["isobaric"].columns, tmp_path / "wire_100MPa.csv"
    rows = zip(np.add(loop["temperature"], -273.15), np.multiply(100.0, loop["strain"]), strict=True)
    path.write_text("\n".join(["temperature [degC],strain [%]", *(f"{t:.2f},{x:.5f}" for t, x in rows)]))
    words = ("--fix", "eps_L=4 %", "--free", "M_f-M_s=-90..-2 K", "--starts", "1", "--hold-out", "25 %")
    found = json.loads(FIT(str(path), *words, "--time-box", "3 s", "--json").stdout)
    assert "eps_L" not in found["numbers"]
    assert -90.0 <= found["numbers"]["M_f-M_s"] <= -2.0
    assert not found["held_out"][0]["whole"]
    assert "free parameter" in FIT.refused(str(path), "--fix", "eps_l")
    assert "record to hold out" in FIT.refused(str(path), "--hold-out", "nothing")
    assert "no effect with --scenario" in FIT.refused(str(path), "--fix", "A_s", "--scenario", "x.toml")


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "flexinol_isobaric").exists(), reason="no measured data in MARTENSITE_DATA")
def test_isobaric_files_become_a_law_that_arithmetic_beats() -> None:
    """Source of truth: an independent average of the two neighbouring loads errs by 0.036 % at 172 MPa."""
    files = [str(DATA / "flexinol_isobaric" / f"isobaric_{mpa}MPa.txt") for mpa in (50, 100, 172, 200)]
    model = model_logs(files)
    errors = {one.record: one for one in model.chosen_model.errors}
    assert errors["isobaric_172MPa"].offset_rms < 7e-4
    assert errors["isobaric_172MPa"].rivals["neighbouring loads"] < 3.6e-4
    assert model.chosen_model.pooled_errors[0].best_rival == "neighbouring loads"
    assert not model.predicts


def test_records_that_lack_a_column_are_named() -> None:
    whole, part = RECORDS["stroke"], make_record({"duty": make_pulses()}, "other")
    with pytest.raises(DataError, match="`other` has no column `position`"):
        model_logs([whole, part])
