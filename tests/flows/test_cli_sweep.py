"""`sweep`: what it shows and writes, how it goes on, and how it refuses.

Source of truth: the store that it writes, and the same sweep from Python.
"""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import pytest
from command import Command
from sweep_cases import AXES, WIRE, arrays, undisturbed

from martensite.base.status import Status
from martensite.design.sweep.plan import SweepPlan
from martensite.design.sweep.store import Store

SWEEP = Command("sweep")
QUICK = "--runtime", "floats", "--backend", "serial", "--chunk-size", "3"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the scenario, which is the present one."""
    (tmp_path / "wire.toml").write_text(WIRE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_shows_what_the_store_holds(here: Path) -> None:
    shown = SWEEP.fine("wire.toml", *AXES, *QUICK)
    stroke = Store(here / "wire.zarr").group["stroke"][:]
    (row,) = (line.split() for line in shown.splitlines() if line.startswith("stroke"))
    assert float(row[1]) == pytest.approx(1e3 * stroke.min(), rel=1e-5)
    assert float(row[5]) == pytest.approx(1e3 * stroke.max(), rel=1e-5)
    assert "12 of 12 runs, 12 of them now, in steps of at most 0.1 s on `floats`" in shown
    assert "wrote wire.zarr" in shown
    assert "0 of them now" in SWEEP.fine("wire.toml", *AXES, *QUICK)


def test_it_is_the_function(here: Path) -> None:
    expected = undisturbed(here / "whole.zarr", traces=(("position", 6),))
    report = SWEEP.report("wire.toml", *AXES, *QUICK, "--trace", "position:6", "--out", "s.zarr")
    assert dict(arrays(here / "s.zarr")) == expected
    assert (report["runs"], report["done"], report["made"], report["chunks"]) == (12, 12, 12, [4, 4])
    assert report["status"] == {s.name.lower(): 12 * (s is Status.OK) for s in Status}
    stroke = Store(here / "s.zarr").group["stroke"][:]
    assert report["measures"]["stroke"]["highest"] == stroke.max()
    assert (report["cautions"], report["remarks"]) == ([], [])


def test_parts_of_a_job_array_and_then_the_rest(here: Path) -> None:
    parts = [SWEEP.report("wire.toml", *AXES, *QUICK, "--chunk", f"{i}/3")["done"] for i in (1, 3, 1)]
    assert parts == [6, 3, 6]
    assert SWEEP.report("wire.toml", *AXES, *QUICK)["made"] == 3


def test_options_change_what_is_swept(here: Path) -> None:
    words = "--sample", "latin-hypercube:6", "--seed", "4", "--output", "max(stress)"
    more = "--step", "50 ms", "--set", "run.duration=1 s", "--over", "diameter=0.12..0.2 mm"
    report = SWEEP.report("wire.toml", *more, *words, *QUICK)
    assert (report["runs"], report["step"], list(report["measures"])) == (6, 0.05, ["max(stress)"])
    spec = Store(here / "wire.zarr").spec
    assert (spec["seed"], spec["sample"]) == (4, "latin-hypercube:6")
    assert "duration = " in spec["scenario"]


def test_failed_runs_are_named(here: Path) -> None:
    shown = SWEEP.fine("wire.toml", "--over", "A_s=68, 99, 98 degC", *QUICK)
    assert "Warning: 2 runs: A parameter is out of its range" in shown
    assert "(run 1, 2)" in shown
    assert "3 of 3 runs" in shown


def test_modules_of_ones_own_are_found_by_the_workers(here: Path) -> None:
    (here / "twice_as_much.py").write_text(
        "from martensite.simulate.measures.base import MEASURES\n"
        "from martensite.simulate.measures.extremes import Largest\n"
        "@MEASURES.register('twice')\n"
        "class Twice(Largest):\n"
        "    def value(self, table):\n"
        "        return 2.0 * super().value(table)\n"
    )
    outputs = "--output", "twice(stress)", "--output", "max(stress)"
    words = *AXES, *outputs, "--import", "twice_as_much.py", "--runtime", "floats", "--workers", "1"
    try:
        SWEEP.fine("wire.toml", *words)
        group = Store(here / "wire.zarr").group
        assert (group["twice(stress)"][:] == 2.0 * group["max(stress)"][:]).all()
    finally:
        from martensite.simulate.measures.base import MEASURES

        MEASURES._entries.pop("twice", None)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "Add `--over`"),
        (("--over", "diametr=0.1..0.2 mm:2"), "Did you mean"),
        (("--over", "diameter"), "is no free parameter"),
        (("--over", "diameter=0.1..0.2:2"), "`element.diameter`: "),
        (("--over", "diameter=0.1..0.2 mm"), "no levels"),
        ((*AXES, "--output", "strke"), "Did you mean `stroke`"),
        ((*AXES, "--output", "max(temprature)"), "Did you mean `temperature`"),
        ((*AXES, "--trace", "positon:11"), "Did you mean `position`"),
        ((*AXES, "--trace", "position"), "is no trace"),
        ((*AXES, "--trace", "position:1"), "is no trace"),
        ((*AXES, "--sample", "sobl:8"), "Did you mean `sobol`"),
        ((*AXES, "--step", "5 mm"), "Option `--step`"),
        ((*AXES, "--chunk", "5/4"), "between 1/4 and 4/4"),
        ((*AXES, "--workers", "2"), "no effect on the backend `serial`"),
        ((*AXES, "--scheduler", "tcp://a:1"), "no effect on the backend `serial`"),
        ((*AXES, "--backend", "dsk"), "Did you mean `dask`"),
        ((*AXES, "--import", "no_such_module"), "Cannot import"),
    ],
)
def test_it_refuses(here: Path, words: tuple[str, ...], sentence: str) -> None:
    assert sentence in SWEEP.refused("wire.toml", *QUICK, *words)
    assert [path.name for path in here.iterdir()] == ["wire.toml"]


def test_another_sweep_in_the_store_is_refused_and_replaced_by_force(here: Path) -> None:
    SWEEP.fine("wire.toml", *AXES, *QUICK)
    other = "wire.toml", *AXES, *QUICK, "--seed", "3"
    said = SWEEP.refused(*other)
    assert "holds another sweep: seed `0` there, `3` here" in said
    assert "--force" in said
    assert SWEEP.report(*other, "--force")["made"] == 12


def test_a_full_disk_exits_with_1_and_the_command_goes_on(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = undisturbed(here / "whole.zarr")
    write = Store.write

    def full(store: Store, chunk: int, *rest: Any) -> None:
        if chunk == 2:
            monkeypatch.setattr("zarr.storage._local._put", no_room)
        write(store, chunk, *rest)

    def no_room(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Store, "write", full)
        done = SWEEP("wire.toml", *AXES, *QUICK)
    monkeypatch.undo()
    monkeypatch.chdir(here)
    assert (done.exit_code, done.stdout) == (1, "")
    assert "the disk is full. What was written before is kept" in done.stderr
    assert done.stderr.count("\n") == 1
    assert SWEEP.report("wire.toml", *AXES, *QUICK)["made"] == 6
    assert dict(arrays(here / "wire.zarr")) == expected


def test_an_interruption_is_a_sentence(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compute = SweepPlan.compute

    def interrupted(plan: SweepPlan, rows: range) -> Any:
        if rows.start == 6:
            raise KeyboardInterrupt
        return compute(plan, rows)

    monkeypatch.setattr(SweepPlan, "compute", interrupted)
    done = SWEEP("wire.toml", *AXES, *QUICK)
    assert done.exit_code == 130
    assert "Interrupted when 6 of 12 runs were there" in done.stderr
    monkeypatch.undo()
    monkeypatch.chdir(here)
    assert SWEEP.report("wire.toml", *AXES, *QUICK)["made"] == 6


def test_a_folder_that_is_not_there_is_not_made(here: Path) -> None:
    said = SWEEP.refused("wire.toml", *AXES, *QUICK, "--out", "nowhere/x.zarr")
    assert "There is no folder `nowhere` to write `x.zarr` into." in said
    assert [one.name for one in here.iterdir()] == ["wire.toml"]
