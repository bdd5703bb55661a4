"""A fit says what its numbers are worth: not determined, on bounds, another cadence, raw errors, steps.

Source of truth: data that cannot hold the numbers, numbers that were put in, and the run without a log.
"""

import json
import math
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command import Command
from fit_cases import HEATED, ISOBARIC, TRUE, cycle, heated, isobaric, measured, pulse, repeated, write_log

from martensite.fit.api import fit_logs
from martensite.fit.column_matching import ComparedColumn, match_columns
from martensite.fit.descents import find_step
from martensite.fit.fit import Fit
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.scenario.recorded_waveforms import hold_levels, is_stepped
from martensite.scenario.scenario import read_scenario
from martensite.show.summaries.fit_tables import mark_parameter, tabulate_errors
from martensite.signals.records import Record
from martensite.simulate.api import simulate

FREE = "A_s,A_f"


def fitted(log: Record, free: str, text: str = ISOBARIC, **options: object) -> Fit:
    return fit_logs(read_scenario(text, log=log), log, free, **{"hold_out": "none", **options})  # type: ignore[arg-type]


def test_number_with_an_interval_wider_than_its_range_is_not_determined() -> None:
    """A wire that is hardly warmed says nothing of where its transformation ends."""
    log = isobaric(noise=0.01)
    keep = [k for k, t in enumerate(log["temperature"]) if t < TRUE["A_s"] + 2.0][:60]
    short = replace(log, columns={name: [column[k] for k in keep] for name, column in log.columns.items()})
    fit = fitted(short, "A_s,A_f,eps_L")
    low, high = fit.uncertainty.widen_interval("A_f")
    assert not high - low < 100.0 or "A_f" in fit.at_bound()
    assert "A_f" in fit.undetermined
    assert not fit.identifiability.determined
    assert mark_parameter(fit, "A_f") in ("not determined", "weak", "at a bound")
    assert not any("`A_f`" in s and s.endswith("determined.") and "not" not in s for s in fit.identifiability.sentences)


def test_numbers_on_their_bounds_are_neither_determined_nor_converged() -> None:
    log = isobaric()
    free = "A_s=40..60 degC@50 degC,A_f=90..120 degC@100 degC,M_s=20..40 degC@30 degC,M_f=0..20 degC@10 degC"
    fit = fitted(log, free)
    held = fit.at_bound()
    assert len(held) >= 2
    assert fit.reason == "stopped at bounds"
    assert set(held) <= set(fit.undetermined)
    assert all("it lies on its bound" in fit.undetermined[name] for name in held)
    assert not fit.identifiability.determined
    good = fitted(log, FREE)
    assert (good.reason, good.undetermined, good.identifiability.determined) == ("converged", {}, True)


def test_stationary_point_is_one_that_a_free_offset_cannot_make_better() -> None:
    residuals = 0.24 + 0.1 * np.sin(np.arange(50.0))
    offset, other = np.ones((50, 1)), np.linspace(0.0, 1.0, 50)[:, None]
    step, asked = find_step(residuals, np.hstack([offset, other]), np.array([0.5, 0.5]))
    assert asked > 1.0
    assert find_step(residuals + np.hstack([offset, other]) @ step, np.hstack([offset, other]), np.array([0.5, 0.5]))[
        1
    ] == pytest.approx(0.0, abs=1e-12)
    assert find_step(residuals, offset, np.array([0.0]))[1] == 0.0  # the bound holds it back
    log = isobaric()
    shifted = replace(log, columns=log.columns | {"strain": [x + 0.004 for x in log["strain"]]})
    fit = fitted(shifted, FREE, each="offset.strain")
    assert fit.reason == "converged"
    assert abs(fit.scores[0].bias) < 1e-3 * fit.scores[0].rms + 1e-9


def test_raw_error_stands_beside_that_with_a_fitted_offset() -> None:
    logs = [replace(isobaric(s, seed=k), name=f"r{k}") for k, s in enumerate((80e6, 100e6, 120e6))]
    logs[1] = replace(logs[1], columns=logs[1].columns | {"strain": [x + 0.01 for x in logs[1]["strain"]]})
    fit = fit_logs([read_scenario(ISOBARIC, log=log) for log in logs], logs, FREE, each="offset.strain")
    table = tabulate_errors(fit)
    place = list(table.head).index("raw rms error")
    kept = next(row for row in table.rows if row[0] == "r1")
    assert kept[place] == "1 %"
    assert float(kept[2].split()[0]) < 0.2
    assert any("Without this fit the held-out error is 1 %" in sentence for sentence in describe_predictions(fit))


def test_other_cadence_that_is_predicted_worse_is_named() -> None:
    """The truth has a latent heat that the scenario lacks, which slow cycles hardly show."""

    def switched(period: float, name: str) -> Record:
        times = [period / 60.0 * k for k in range(181)]
        level = [0.55 if (t % period) < 0.5 * period else 0.05 for t in times]
        drive = Record(name, {"time": times, "current": level}, {"time": "s", "current": "A"})
        return measured(drive, HEATED, ["position"], {"environment.cooling.h": "80 W/m^2/K"}, 0.005)

    poor = HEATED.replace('length = "200 mm"', 'length = "200 mm"\nheat_capacity = "2500 J/kg/K"')
    logs = [switched(60.0, "slow"), switched(14.0, "fast")]
    fit = fit_logs([read_scenario(poor, log=log) for log in logs], logs, "h", hold_out="fast")
    found = [sentence for sentence in list_fit_warnings(fit) if "Add a log of that period" in sentence]
    assert len(found) == 1
    assert "`fast` (period of about 14 s) is faster" in found[0]
    assert "The relative error of `position` is" in found[0]
    alone = fit_logs(read_scenario(poor, log=logs[0]), logs[0], "h", hold_out="none")
    assert any("All logs have one period" in sentence for sentence in describe_predictions(alone))


def test_steps_that_are_logged_act_from_their_row_on() -> None:
    table = '{ kind = "step", low = "0.05 A", high = "0.55 A", at = "1 s", until = "7 s" }'
    truth = read_scenario(HEATED.replace('"log"', table).replace("[run]", '[run]\nduration = "15 s"'))
    run = simulate(truth.system, truth.waveform, 15.0, step=0.005, samples=151)
    columns = {"time": list(run.times), "current": pulse()["current"], "position": list(run["position"])}
    log = Record("switched", columns, {"time": "s", "current": "A", "position": "m"})
    errors = {}
    for between in ("", ', between = "linear"'):
        scenario = read_scenario(HEATED.replace('"log"', f'{{ kind = "log"{between} }}'), log=log)
        again = simulate(scenario.system, scenario.waveform, 15.0, step=0.005, samples=151)
        errors[between] = float(np.max(np.abs(np.subtract(again["position"], log["position"])))) / run.range("position")
    assert errors[""] < 1e-4
    assert errors[', between = "linear"'] > 1e-2
    assert is_stepped(log["current"].tolist())
    assert not is_stepped(cycle()["temperature"].tolist())
    assert hold_levels([(0.0, 1.0), (1.0, 1.0), (2.0, 3.0)]) == [(0.0, 1.0), (1.0, 1.0), (1.9999, 1.0), (2.0, 3.0)]
    notes = fitted(log, "h", HEATED).notes
    assert any("Column `current` of record `switched` is held" in note for note in notes)


def test_scaled_column_says_its_converted_range() -> None:
    log = Record("turn", {"time": [0.0, 1.0], "angle": [0.0, math.pi]}, {"time": "s", "angle": "1"})
    system = read_scenario(HEATED, log=heated()).system
    _, record, notes = match_columns(log, system, [ComparedColumn("position", "angle", 0.01)], {})
    assert record["position"][1] == pytest.approx(0.01 * math.pi)
    assert "0 to 3.142, is taken in plain numbers times 0.01 as `position`: 0 to 31.42 mm" in notes[0]


def test_dotted_paths_of_the_scenario_are_free_numbers() -> None:
    log = heated()
    by_path = fitted(log, "environment.cooling.h=40..120 W/m^2/K", HEATED)
    assert by_path.values == fitted(log, "h=40..120 W/m^2/K", HEATED).values
    resistance = HEATED.replace('kind = "current"', 'kind = "voltage"\nseries_resistance = "1 ohm"')
    wired = replace(
        log, columns=log.columns | {"voltage": [8.0 * x for x in log["current"]]}, units=log.units | {"voltage": "V"}
    )
    scenario = read_scenario(resistance, log=wired)
    fit = fit_logs(scenario, wired, "drive.series_resistance=0.5..2 ohm", columns="position", hold_out="none")
    assert list(fit.numbers) == ["source.series_resistance"]


def test_check_and_params_take_a_scenario_that_follows_a_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("isobaric.toml").write_text(ISOBARIC, encoding="utf-8")
    said = Command("check").fine("isobaric.toml")
    assert "Follows a log: `drive` column `temperature`, `command` column `stress`" in said
    assert "element.law.A_s" in Command("params").fine("isobaric.toml")


def test_fitted_material_that_is_overridden_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_log(isobaric(), "log.csv")
    Path("isobaric.toml").write_text(ISOBARIC, encoding="utf-8")
    Command("fit").fine("log.csv", "--scenario", "isobaric.toml", "--free", FREE, "--out", "mine.toml")
    mine = ISOBARIC.replace('"flexinol-90"', '"./mine.toml"').replace(
        'law = { kind = "liang-rogers", modulus = "mixture" }\n', ""
    )
    assert not any("overridden" in caution for caution in read_scenario(mine, log=isobaric()).cautions)
    other = mine.replace("[mechanism]", '[element.law]\nA_s = "60 degC"\n\n[mechanism]')
    found = [one for one in read_scenario(other, log=isobaric()).cautions if "overridden" in one]
    assert len(found) == 1
    assert "material `mine` are overridden by the scenario: `A_s`" in found[0]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_a_search_with_the_best_so_far(number: int, tmp_path: Path) -> None:
    write_log(repeated(heated(), 20), tmp_path / "log.csv")
    (tmp_path / "heated.toml").write_text(HEATED, encoding="utf-8")
    words = ["fit", "log.csv", "--scenario", "heated.toml", "--free", "h,A_s,A_f,M_s,M_f", "--starts", "200", "--json"]
    words += ["--resume", "state.json"]
    with subprocess.Popen(
        [sys.executable, "-m", "martensite", *words],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        limit = time.monotonic() + 120.0
        while not (tmp_path / "state.json").exists() and time.monotonic() < limit and process.poll() is None:
            time.sleep(0.1)
        process.send_signal(number)
        out, said = process.communicate(timeout=120.0)
    assert process.returncode == 130, said
    assert out, said
    assert json.loads(out)["reason"] == "interrupted"
    assert "the search goes on from `state.json`" in said
