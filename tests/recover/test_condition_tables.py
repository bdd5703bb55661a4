"""Fits to tables of conditions: numbers that were put in come back, and a specimen left out is predicted.

Sources of truth: the numbers with which the runs behind the tables were made (`condition_cases`), on other
steps than those of the fit; weights by hand.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from condition_cases import COIL, TRUTH, make_coil, measure_run, write_rows

from martensite.base.errors import DataError, InputError
from martensite.fit.api import build_task, fit_logs
from martensite.fit.condition_fits import pick_rows
from martensite.fit.condition_runs import ConditionExperiment
from martensite.fit.condition_tables import is_condition_table, read_condition_table
from martensite.fit.fit import HELD_OUT, Fit, compute_rms, list_compared
from martensite.fit.problem import Problem
from martensite.scenario.scenario import read_scenario
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march

COILS = {"A": {"element.turns": 13}, "B": {"element.turns": 16}, "C": {"element.turns": 19}}
FREE = "A_s,A_f,h=30..120 W/m^2/K"


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("tables") / "coils.csv"
    lines = write_rows(COILS, (2.4, 2.8, 3.2), columns=["element.turns"], noise=0.005, repeats=2)
    path.write_text("\n".join(lines))
    return path


@pytest.fixture(scope="module")
def fit(table: Path) -> Fit:
    return fit_logs(make_coil(), str(table), FREE, hold_out="B")


def arrange(path: Path, **how: object) -> Problem:
    return build_task(make_coil(), str(path), "A_s").with_changes(step=0.05, **how).arrange().problem  # type: ignore[arg-type]


def write_table(folder: Path, *lines: str) -> Path:
    path = folder / "table.csv"
    path.write_text("\n".join(lines))
    return path


def test_what_was_put_in_is_found(fit: Fit):
    assert fit.reason == "converged"
    for name, true in (("A_s", 339.15), ("A_f", 353.15), ("h", 60.0)):
        low, high = fit.uncertainty.widen_interval(name)
        assert low <= true <= high
    assert fit["A_f"] == pytest.approx(353.15, abs=2.0)


def test_a_specimen_that_was_left_out_is_predicted(fit: Fit):
    held = [one for one in list_compared(fit) if one.record == "B"]
    assert [one.training_rows.any() for one in held] == [False] * 3
    assert compute_rms([one for one in held if one.output == "stroke"], HELD_OUT) < 1e-3  # of 60 mm


def test_derivatives_are_those_of_the_measures(table: Path):
    problem = build_task(make_coil(), str(table), FREE).with_changes(step=0.05).arrange().problem
    point: Any = np.array([0.45, 0.55, 0.5])
    found = problem.evaluate(point, slopes=True)
    assert found is not None
    for k in range(3):
        step = 1e-5 * np.eye(3)[k]
        up, down = problem.evaluate(point + step), problem.evaluate(point - step)
        assert up is not None
        assert down is not None
        slope = (up.residuals - down.residuals) / 2e-5
        assert found.jacobian[:, k] == pytest.approx(slope, rel=1e-3, abs=1e-3 * np.abs(slope).max())
    costs = problem.costs(np.stack([point, point + 0.01]))
    assert costs[0] == pytest.approx(found.cost, rel=1e-9)


def test_rows_are_the_runs_of_their_conditions(table: Path):
    """Against runs of the scenario with the same settings, one by one."""
    problem = build_task(make_coil(**{k.replace(".", "__"): v for k, v in TRUTH.items()}), str(table), "A_s").arrange()
    found = problem.problem.evaluate(problem.problem.start)
    assert found is not None
    stroke, force, time = measure_run({**TRUTH, "element.turns": 19, "drive.waveform.high": "3.2 A"})
    assert found.fitted_records[2].model[2] == pytest.approx([1e-3 * stroke, force, time], rel=5e-3)


PULSES = """
[drive]
kind = "current"
waveform = { kind = "pwm", high = "8 A", frequency = "15 Hz", duty = 0.1 }"""


@pytest.mark.parametrize("samples", [21, 1001])
def test_measures_of_rows_come_from_all_steps(tmp_path: Path, samples: int):
    """Against the measures of a run in the same steps; 180 edges, none of them a sample."""
    text = COIL.replace(COIL[COIL.index("[drive]") : COIL.index("[run]")], f"{PULSES.strip()}\n")
    scenario = read_scenario(text, None, {"run.samples": samples})
    words = ("max(power)", "energy", "max(temperature)")
    heading = "current [A],max(power) [W],energy [J],max(temperature) [degC]"
    path = write_table(tmp_path, heading, "8,80,50,80", "7,60,40,70", "6,45,30,60")
    task = build_task(scenario, str(path), "A_s").with_changes(step=0.02, hold_out="none")
    made: Any = task.arrange().problem.experiments[0]
    rows = made.runner(0.02).run_one(np.array(compile_march(made.system).values(made.system)))
    run = simulate(scenario.system, scenario.waveform, scenario.duration, step=0.02, samples=2)
    places = [list(made.columns).index(one) for one in words]
    (row,) = (k for k, one in enumerate(made.conditions) if 8.0 in one.inputs.values())
    assert rows[row, places] == pytest.approx([run.measure(one) for one in words], rel=1e-6)


def test_repeats_and_spreads_weigh(tmp_path: Path):
    """By hand: means, weights by their number, noise pooled from what they scatter by; n/s² by columns."""
    heading = "current [A],stroke [mm],max(force) [N]"
    rows = ["2.4,10.0,1.0", "2.4,10.2,1.1", "2.4,10.4,1.2", "2.8,20.0,2.0", "2.8,20.2,2.1", "3.2,30,3"]
    one = arrange(write_table(tmp_path, heading, *rows), hold_out="none")
    (made,) = one.experiments
    assert isinstance(made, ConditionExperiment)
    assert made.measured[:, 0] == pytest.approx([10.2e-3, 20.1e-3, 30e-3])
    assert made.row_factors[:, 0] ** 2 == pytest.approx([3.0, 2.0, 1.0])
    assert one.noise["stroke"] == pytest.approx(1e-3 * np.sqrt((0.04 + 0.04 + 0.02) / 3))
    heading = "current [A],stroke [mm],stroke sd [mm],n"
    one = arrange(write_table(tmp_path, heading, "2.4,10,0.1,4", "2.8,20,0.2,1", "3.2,30,,2"), hold_out="none")
    pooled = (0.1**2 + 0.2**2) / 2
    assert one.noise["stroke"] == pytest.approx(1e-3 * np.sqrt(pooled))
    assert one.experiments[0].row_factors[:, 0] ** 2 == pytest.approx([4 * pooled / 0.01, pooled / 0.04, 2.0])


def test_columns_are_understood(tmp_path: Path):
    path = write_table(
        tmp_path,
        "coil,I,current [mA],pulse [s],ambient [degC],preload_gf,temperature rise [degC],steady force [N],remarks",
        "x,1,2400,5,20,61.2,40,2,good",
        "x,2,2800,4,25,61.2,50,2,loud",
    )
    with pytest.raises(InputError, match="column `i` is nothing that the scenario is given, and no measure"):
        read_condition_table(path, make_coil())
    path.write_text(path.read_text().replace(",I,", ",-,"))
    found = read_condition_table(path, make_coil())
    assert {one.path: one.values[1] for one in found.inputs} == pytest.approx(
        {
            "drive.waveform.high": 2.8,
            "drive.waveform.until": 4.0,
            "environment.temperature": 298.15,
            "mechanism.preload": 0.600167,
        }
    )
    assert {one.words: one.values[0] for one in found.measures} == {"change(temperature)": 40.0, "final(force)": 2.0}
    assert found.groups == {"coil": ("x", "x")}
    assert any("holds remarks" in note for note in found.notes)


def test_a_load_as_a_force_is_that_of_a_mass(tmp_path: Path):
    text = COIL.replace('kind = "bias-spring"', 'kind = "dead-weight"').replace('stiffness = "20 N/m"', 'mass = "60 g"')
    scenario = tmp_path / "hung.toml"
    scenario.write_text(text.replace('preload = "0.6 N"\n', ""))
    from martensite.scenario.scenario import load

    path = write_table(tmp_path, "load [gf],stroke [mm]", "50,3", "60,4")
    (found,) = read_condition_table(path, load(scenario)).inputs
    assert (found.path, found.values) == ("mechanism.mass", pytest.approx((0.05, 0.06)))


def test_a_table_is_told_from_a_log(tmp_path: Path):
    for heading, expected in (
        ("current [A],peak stroke [mm]", True),
        ("# note\ncurrent [A]; max(force) [N]", True),
        ("time [s],current [A],peak force [N]", False),
        ("Time (s),peak force (N)", False),
        ("current [A],force [N]", False),
    ):
        assert is_condition_table(write_table(tmp_path, heading, "1,2,3")) is expected
    assert not is_condition_table(tmp_path / "missing.csv")


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        (("current [A],peak stroke", "2,1"), r"`peak stroke` has no unit; write for example `peak stroke \[mm\]`"),
        (("current [A],peak stroke [N]", "2,1"), "column `peak stroke`: .*N"),
        (("curent [A],peak stroke [mm]", "2,1"), "Did you mean `current`"),
        (("current [A],peak stroke [mm]", "2"), "row 2 has 1 cells, but there are 2 columns"),
        (("current [A],peak stroke [mm]", ",1", "2,2"), "row 2: `current` is empty"),
        (("current [A],peak stroke [mm]", "2,x", "2,3"), "`x` is not a number"),
        (("current [A],peak stroke [mm],peak stroke sd [mm]", "2,1,0"), "must be above 0"),
        (("current [A],peak stroke [mm],max(foo) [N]", "2,1,0"), "looks at `foo`"),
        (("current [A],peak stroke [mm],stroke [mm]", "2,1,1"), "both are `stroke`"),
        (("current [A],peak stroke [mm]",), "no rows"),
        (("current [A],peak stroke [mm],n", "2,1,0"), "repeats must be at least 1"),
        (("law.A_s [degC],current [A],peak stroke [mm]", "60,2.4,1", "60,2.8,2"), "a column of the table sets"),
    ],
)
def test_bad_tables_get_a_sentence(tmp_path: Path, lines: tuple[str, ...], sentence: str):
    path = write_table(tmp_path, *lines)
    with pytest.raises(InputError, match=sentence):
        arrange(path, hold_out="none")


def test_tables_and_logs_do_not_mix(tmp_path: Path, table: Path):
    log = write_table(tmp_path, "time [s],position [mm]", "0,1", "1,2")
    with pytest.raises(InputError, match="one after the other"):
        build_task(make_coil(), [str(table), str(log)], "A_s").arrange()


def test_rows_at_the_edge_and_in_the_middle_are_kept_back():
    assert pick_rows(5, 0.2) == [5.0]
    assert pick_rows(10, 0.2) == [6.0, 10.0]
    assert pick_rows(15, 0.2) == [1.0, 8.0, 15.0]
    assert len(pick_rows(40, 0.25)) == 10
    assert pick_rows(1, 0.5) == []


def test_columns_without_headings_are_named_by_number(tmp_path: Path):
    path = write_table(tmp_path, "2.4,8.1", "2.8,9.3")
    named = {"1": "current [A]", "2": "peak stroke [mm]"}
    assert is_condition_table(path, named)
    assert not is_condition_table(path)
    found = read_condition_table(path, make_coil(), named)
    assert found.inputs[0].values == (2.4, 2.8)
    assert found.measures[0].values == pytest.approx((8.1e-3, 9.3e-3))
    with pytest.raises(DataError, match="no column `3`"):
        read_condition_table(path, make_coil(), {"3": "n"})
