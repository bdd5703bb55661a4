"""`python -m benchmarks.control`: a stored row recomputed, controllers of your own, ranking, guards, refusals.

Source of truth: the table on the docs page, a proportional law written three ways, and rows made up for the ranking.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.control.commands import benchmark
from benchmarks.control.competition import (
    BenchmarkRow,
    BenchmarkTable,
    EntryRuns,
    compare_pairs,
    make_digest,
    rank_entries,
    read_table,
    run_benchmark,
)
from benchmarks.control.entries import find_entry, load_entries, load_gains
from benchmarks.control.guard_runs import run_guards
from benchmarks.control.strangers import read_stranger
from benchmarks.control.tasks import find_task, load_plant, load_tasks
from benchmarks.control.wires import SEED, draw_wires
from typer.testing import CliRunner

STORED = Path(__file__).parents[2] / "docs" / "reference" / "benchmarks" / "control.json"
STRANGERS = {
    "law.c": """
void control_step(double *memory, double reference, const double *readings, double dt, double *signals) {
  double duty = 400.0 * (reference - readings[0]);
  signals[0] = duty < 0.0 ? 0.0 : duty > 1.0 ? 1.0 : duty;
}
""",
    "law.py": """
from martensite.base.parameters import param
from martensite.control.controllers.base import AbstractController

class Proportional(AbstractController):
    gain = param("1", "gain", default=400.0)

    def answer(self, xp, memory, reference, readings, dt):
        return xp.clip(self.gain * (reference - readings[self.measured]), 0.0, 1.0), ()

class Agent:
    plants = ("wire",)

    def predict(self, seen):  # a duty of 400 (r - y), for a range of 6 mm
        return 2.0 * 400.0 * 0.5 * 6e-3 * (seen[:, 1:2] - seen[:, 0:1]) - 1.0
""",
}


def invoke(*words: str) -> tuple[int, str]:
    found = CliRunner().invoke(benchmark, words)
    return found.exit_code, found.output


def test_a_stored_row_is_computed_anew() -> None:
    """Open loop, to rounding: under feedback wires swing at other times with another compiler."""
    stored = read_table(STORED)
    assert stored.digest == make_digest()
    (one,) = run_benchmark([EntryRuns(find_entry("direct"))], [find_task("hold")]).rows[:1]
    (row,) = stored.select(entry="direct", task="hold", fault="none")
    for key in ("error_median", "error_90", "hottest", "energy", "above", "failed", "alarms"):
        assert getattr(one, key) == pytest.approx(getattr(row, key), rel=1e-3, abs=1e-3), key


def test_entries_have_numbers_for_every_plant_and_rows_for_every_task_and_fault() -> None:
    stored = read_table(STORED)
    for one in load_entries().values():
        tasks = [task.name for task in load_tasks().values() if task.plant in one.plants]
        for plant in one.plants:
            assert set(load_gains(one.name, plant)) == {free.name for free in one.free}
        rows = stored.select(entry=one.name)
        assert len(rows) == 13 * len(tasks) and {row.task for row in rows} == set(tasks)
    assert all(row.above == 0.0 and row.failed == 0.0 for row in stored.select(fault="none"))


def test_controllers_of_three_kinds_do_the_same(tmp_path: Path) -> None:
    for name, text in STRANGERS.items():
        (tmp_path / name).write_text(text)
    found = [read_stranger(str(tmp_path / name)) for name in ("law.c", "law.py:Proportional", "law.py:Agent")]
    table = run_benchmark(found, [find_task("sine")], [], 2)
    in_c, kernel, agent = (one["error"] for one in table.measures.values())
    np.testing.assert_allclose(in_c, kernel, rtol=2e-3)
    np.testing.assert_allclose(in_c, agent, rtol=2e-3)


def test_another_seed_gives_other_wires_and_noise_and_pairs_are_compared_wire_by_wire() -> None:
    """The truth of the difference is the mean of the errors of all wires; its interval is that of paired samples."""
    entries, tasks = [EntryRuns(find_entry(name)) for name in ("direct", "two-level")], [find_task("hold")]
    known, other = (run_benchmark(entries, tasks, [], 4, seed=seed) for seed in (SEED, 7))
    key = ("direct", "hold", "none")
    assert not np.allclose(known.measures[key]["error"], other.measures[key]["error"])
    ((one, second, mean, half),) = compare_pairs(known)
    errors = [np.minimum(known.measures[name, "hold", "none"]["error"], 1.0) for name in (one, second)]
    difference = errors[1] - errors[0]
    assert mean == pytest.approx(difference.mean())
    assert half == pytest.approx(1.96 * difference.std(ddof=1) / 2.0)
    assert all(row.activity >= 0.0 and row.itae > 0.0 and row.cost > 0.0 for row in known.rows)


def test_a_wire_above_its_limit_puts_an_entry_last() -> None:
    rows = [
        BenchmarkRow(name, "hold", "none", 4, 0.0, error, 0.0, 0.0, 0.0, 300.0, above, 0.0, 0.0)
        for name, error, above in (("burner", 0.01, 0.25), ("slow", 0.5, 0.0), ("lost", 3.0, 0.0))
    ]
    rows += [BenchmarkRow("slow", "sine", "none", 4, 0.0, 0.3, 0.0, 0.0, 0.0, 300.0, 0.0, 0.0, 0.0)]
    ranked = rank_entries(BenchmarkTable(tuple(rows), {}, "0", "0"))
    assert [name for name, _ in ranked] == ["slow", "lost", "burner"]
    assert dict(ranked)["slow"] == pytest.approx(0.4) and dict(ranked)["lost"] == 1.0


def test_fewer_wires_are_the_first_of_all() -> None:
    few, many = (draw_wires(load_plant("pair"), count) for count in (4, 64))
    for path, row in many.items():
        np.testing.assert_array_equal(few[path], row[:4])
    film = many["plant.group.antagonist.environment.cooling.h"] / 120.0
    assert 0.5 <= film.min() < 0.55 and 1.85 < film.max() <= 2.0


def test_the_default_guard_limits_and_keeps_the_wire_of_the_sheet_within_its_limit() -> None:
    """Open loop at a supply that is too high: no cut, and a bound that holds nothing where the wire cools less."""
    (row,) = run_guards([replace(find_entry("direct"), plants=("wire",))], ["default"], ["supply-surge"], duration=8.0)
    limit = load_plant("wire").plant.value_of("temperature_limit")
    assert row.cuts == row.false_alarms == 0 and row.hours == pytest.approx(2 * 8.0 / 3600.0)
    assert 350.0 < row.hottest_sheet <= limit < row.hottest_wires


def test_the_command_lists_runs_and_refuses(tmp_path: Path) -> None:
    code, said = invoke("control", "--list", "--json")
    assert code == 0 and json.loads(said)["tasks"] == list(load_tasks())
    words = ["control", "--entry", "direct", "--task", "hold", "--fault", "stuck-on", "--wires", "2"]
    code, said = invoke(*words, "--save", str(tmp_path / "table.csv"), "--figure", str(tmp_path / "table.svg"))
    assert code == 0 and "stuck-on" in said and (tmp_path / "table.svg").stat().st_size > 1000
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 4
    for wrong, valid in (("--entry", "pid"), ("--task", "hold"), ("--fault", "drift"), ("--controller", "FILE.py")):
        code, said = invoke("control", wrong, "nothing")
        assert code == 2 and said.startswith("error: ") and valid in said
