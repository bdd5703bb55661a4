"""Numbers that specimens have for themselves, with a spread about a centre; and predictions without a model.

Sources of truth: the posterior of a normal model in closed form; the numbers that tables were made with;
baselines by hand.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from condition_cases import make_coil, write_rows
from fit_cases import ISOBARIC

from martensite.base.errors import InputError
from martensite.fit.api import build_task, fit_logs, read_problem
from martensite.fit.baselines import CYCLE, MEAN, NEAREST, SCALING, pool_baselines, predict_naively, score_baselines
from martensite.fit.drive_lag import refine_period
from martensite.fit.experiment import Experiment
from martensite.fit.fit import HELD_OUT, Fit, compute_rms, list_held_out
from martensite.fit.fit_file import read_fit_file
from martensite.fit.fit_verdicts import describe_predictions, list_fit_warnings
from martensite.fit.problem import Problem
from martensite.signals.records import Record

COILS = {
    "A": {"element.turns": 13, "environment.cooling.h": "52 W/m^2/K"},
    "B": {"element.turns": 16, "environment.cooling.h": "70 W/m^2/K"},
    "C": {"element.turns": 19, "environment.cooling.h": "60 W/m^2/K"},
}


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("own") / "coils.csv"
    path.write_text("\n".join(write_rows(COILS, (2.5, 2.9, 3.3), columns=["element.turns"], noise=0.003)))
    return path


@pytest.fixture
def wire(tmp_path: Path) -> Path:
    path = tmp_path / "wire.toml"
    path.write_text(ISOBARIC)
    return path


@pytest.fixture(scope="module")
def fit(table: Path) -> Fit:
    coil = make_coil(element__law__A_f="80 degC")
    return fit_logs(coil, str(table), "A_s", each="film=62 W/m^2/K ± 20 %", hold_out="B", step=0.05)


def arrange(table: Path, **how: str) -> Problem:
    return read_problem(make_coil(), str(table), how.pop("free", "A_s"), step=0.05, **how)  # type: ignore[arg-type]


def test_own_numbers_with_a_spread_are_found(fit: Fit):
    for name, true in (("A", 52.0), ("C", 60.0)):
        low, high = fit.uncertainty.widen_interval(f"environment.cooling.h@{name}")
        assert low <= true <= high
        assert high - low < 20.0


def test_a_specimen_kept_back_has_the_centre(fit: Fit):
    (kept,) = fit.held_out_records
    assert kept.numbers == {}
    assert next(leaf.value for leaf in kept.experiment.system.leaves() if leaf.path.endswith("cooling.h")) == 62.0
    said = " ".join(describe_predictions(fit))
    assert "has a prior of ± 20 % around 62 W/m^2/K, as declared, which counts as 2 of 20 data" in said
    assert "Held-out data use the centre." in said


def test_a_spread_counts_as_data(table: Path):
    """One residual per number, of one for each spread from the centre; ten spreads are searched."""
    problem = arrange(table, free="A_s", each="h=±0.1 W/m^2/K", hold_out="none")
    noise = {
        name: 1e3 * problem.scale(name) for name in ("stroke", "change(force)", "reach-time(position, share=90 %)")
    }
    known = replace(problem, noise=noise)
    assert known.knows_noise
    point = problem.start
    found = known.evaluate(point, slopes=True)
    assert found is not None
    assert len(found.residuals) == 27 + 3
    assert found.residuals[27:] == pytest.approx(np.zeros(3))
    moved = np.array([0.5, 0.6, 0.5, 0.5])
    up = known.evaluate(moved.tolist())
    assert up is not None
    assert up.residuals[27:] == pytest.approx([1.0, 0.0, 0.0])
    assert found.jacobian[27] == pytest.approx([0.0, 10.0, 0.0, 0.0])
    assert known.costs(moved[None])[0] == pytest.approx(up.cost)


def test_a_common_centre_is_free_too(table: Path):
    problem = arrange(table, free="A_s,h", each="h:by=specimen=±20 %", hold_out="none")
    assert problem.names == ("A_s", "h", "h@A", "h@B", "h@C")
    found = problem.evaluate(problem.start, slopes=True)
    assert found is not None
    assert not found.jacobian[:27, 1].any()  # the centre moves no run, but what is compared with it
    assert (np.sign(found.jacobian[27:, 1]) == -1.0).all()
    held = problem.hold_out(["B"])
    assert held.names == ("A_s", "h", "h@A", "h@C")
    with pytest.raises(InputError, match="both move"):
        arrange(table, free="A_s,h", each="h", hold_out="none")


@pytest.mark.parametrize(
    ("each", "sentence"),
    [
        ("h:by=batch", "belongs to no `batch`; its groups are: `specimen`"),
        ("h=±0 %", "must be above 0"),
        ("h=±3 mm", "mm"),
        ("delay", "no clock"),
    ],
)
def test_wrong_own_numbers_get_a_sentence(table: Path, each: str, sentence: str):
    with pytest.raises(InputError, match=sentence):
        arrange(table, each=each)


def test_a_spread_belongs_under_each(table: Path):
    with pytest.raises(InputError, match="under `each`"):
        arrange(table, free="h=±20 %")


def test_each_specimen_is_left_out_in_turn(table: Path):
    """The transfer error is that of fits to two of three, and beats linear scaling from the nearest."""
    coil = make_coil(element__law__A_f="80 degC")
    fit = fit_logs(coil, str(table), "A_s", each="film=±20 %", step=0.05)
    assert [kept.experiment.name for kept in fit.transfer] == ["A", "B", "C"]
    rows = [one for kept in fit.transfer for one in list_held_out(kept) if one.output == "stroke"]
    naive = pool_baselines(score_baselines(fit), "stroke")
    assert set(naive) == {MEAN, SCALING}
    assert compute_rms(rows, HELD_OUT) < 0.5 * naive[SCALING] < naive[MEAN]
    assert any("held out in turn (A, B and C)" in one for one in describe_predictions(fit))


def make_log(name: str, seed: int = 0, noise: float = 0.0) -> Record:
    """Three like cycles of temperature with a strain that follows them with a lag."""
    times = np.arange(0.0, 300.0, 1.0)
    temperature = 330.0 + 40.0 * np.cos(2.0 * np.pi * times / 100.0)
    strain = 0.02 - 0.018 * np.cos(2.0 * np.pi * times / 100.0 - 0.3)
    strain += noise * np.random.default_rng(seed).standard_normal(len(times))
    columns = {"time": times, "temperature": temperature, "stress": np.full(len(times), 1e8), "strain": strain}
    units = {"time": "s", "temperature": "K", "stress": "Pa", "strain": "1"}
    return Record(name, {key: list(map(float, column)) for key, column in columns.items()}, units)


def test_baselines_of_a_periodic_record_by_hand(wire: Path):
    record = make_log("log", noise=1e-4)
    problem = build_task(wire, record, "A_s").with_changes(hold_out="25 %").arrange().problem
    scores = {one.name: one for one in score_baselines(problem)}
    assert set(scores) == {MEAN, CYCLE}
    (one,) = problem.experiments
    assert refine_period(one) == pytest.approx(100.0, rel=5e-3)
    held = one.held_out_rows
    strain = np.array(record["strain"])
    assert scores[MEAN].rms == pytest.approx(np.sqrt(np.mean((strain[held] - strain[~held].mean()) ** 2)))
    assert scores[CYCLE].rms < 3e-4
    assert scores[CYCLE].samples == held.sum()


def test_baselines_do_not_see_what_is_kept_back(wire: Path):
    """Other numbers in the rows kept back, of the record itself and of others, change no prediction."""
    cycles, loops = [make_log("log")], [make_log("one"), make_log("two")]
    loops = [replace(x, columns={n: c[:100] for n, c in x.columns.items()}) for x in loops]
    named = list[set[str]]()
    for logs, hold_out in ((cycles, "50 %"), (loops, "30 %")):
        fitted = build_task(wire, logs, "A_s").with_changes(hold_out=hold_out).arrange().problem.experiments
        other = [_spoil_held(one) for one in fitted]
        true, spoilt = (predict_naively(ones, ones[0], "strain") for ones in (fitted, other))
        named.append(set(true))
        for name, guess in true.items():
            assert guess == pytest.approx(spoilt[name]), name
    assert named == [{MEAN, CYCLE}, {MEAN, NEAREST}]


def _spoil_held(one: Experiment) -> Experiment:
    strain = np.where(one.held_out_rows, 0.01, np.array(one.record["strain"]))
    return replace(one, record=replace(one.record, columns=one.record.columns | {"strain": strain.tolist()}))


def test_a_fit_that_does_not_beat_the_last_cycle_says_so(wire: Path):
    """The strain is no hysteresis of the law, but repeats itself."""
    fit = fit_logs(wire, make_log("log"), "A_s,A_f,M_s,M_f", hold_out="25 %")
    (found,) = [one for one in list_fit_warnings(fit) if "naive baseline" in one]
    assert "`strain` of the held-out data is not predicted better than without a model" in found
    assert "(last cycle). Do not use the fit for predictions." in found


def test_groups_of_a_fit_file_share_numbers(tmp_path: Path, wire: Path):
    for name in ("one", "two", "three"):
        record = make_log(name)
        rows = zip(record.times, record["temperature"], record["stress"], record["strain"], strict=True)
        lines = [
            "time [s],temperature [K],stress [Pa],strain [1]",
            *(",".join(f"{x:.6g}" for x in row) for row in rows),
        ]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines))
    records = "\n".join(
        f'[[record]]\nfile = "{name}.csv"\ngroup = {{ specimen = "{group}" }}'
        for name, group in (("one", "A"), ("two", "A"), ("three", "B"))
    )
    path = tmp_path / "fit.toml"
    path.write_text(
        f'scenario = "wire.toml"\nfree = ["A_s"]\neach = ["eps_L:by=specimen"]\nhold_out = "none"\n{records}'
    )

    problem = read_fit_file(path).arrange().problem
    assert problem.names == ("A_s", "eps_L@A", "eps_L@B")
    point = [0.5, 0.2, 0.8]
    assert problem.system(0, point).element.law.eps_L == problem.system(1, point).element.law.eps_L
    assert problem.system(2, point).element.law.eps_L > problem.system(0, point).element.law.eps_L
