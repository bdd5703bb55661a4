"""The benchmark page is what its numbers say, and the parts that make numbers still run.

Source of truth: the committed numbers for the committed page; toy engines for the comparison at
equal error. Times say nothing here.
"""

import copy
import json
import math
import re
from importlib import import_module
from xml.etree import ElementTree

import pytest
from benchmarks import page, page_laws, page_parts, sections_sweep, sweep_once, write_once
from benchmarks.equal_error import Contender, equal_error
from benchmarks.page_text import FOLDER, FORMAT, render
from benchmarks.peers import sma_react_path
from benchmarks.process import Usage
from benchmarks.report import Table
from benchmarks.sections import SECTIONS, Options

from martensite.kernels.compiler import find_compiler

needs_c = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
ENGINES = [
    {"engine": "martensite, C", "setting": "dt 20 ms", "err": 1e-6, "spread": 0.01, "ratio": 1.0},
    {"engine": "other", "setting": "rtol 1e-6", "err": 2e-5, "spread": 0.05, "ratio": 123.4},
    {"engine": "coarse", "setting": "none reaches it", "err": None, "spread": None, "ratio": None},
]
BATCH = [{"engine": "C lanes", "setting": "", "runs": 64, "err": 1e-6, "ratio": 1.0, "rate": 0.5}]
SWEEP = [
    {"runs": 1, "failed": 0, "spread": 0.1, "memory": 1.0, "ratio": 50.0},
    {"runs": 10, "failed": 0, "spread": None, "memory": 1.02, "ratio": 1.0},
]
STEPS = [{"step": "pid", "median": 3e-5, "p99": 1e-4, "p99.9": 2e-3}]


def part(title, rows, note=""):
    tables = [{"title": title, "rows": rows, "note": note}]
    return {"made": "2026-01-02", "load": 0.1, "tables": tables}


NUMBERS = {
    "format": FORMAT,
    "options": {"quick": True, "most": 10},
    "machine": {
        "processor": "A processor",
        "cores": 2,
        "system": "Linux x86_64",
        "compiler": "gcc 12.2",
        "flags": "-O3",
        "packages": {"Python": "3.11.7", "scipy": "1.17.1"},
    },
    "missing": ["A GPU: there was none."],
    "parts": {
        "wire": part("Error of at most 1e-04", ENGINES),
        "batches": part("Throughput, coupled wire, 3000 steps, batch of 64", BATCH),
        "sweep": part("Sweep", SWEEP, "Left out for want of time: 100 runs and more."),
        "control": part("Control step", STEPS),
    },
}


@pytest.fixture
def files():
    return render(NUMBERS)


def test_the_page_says_what_was_measured_and_what_is_missing(files):
    text = files[f"{FOLDER}.md"]
    assert "| other | rtol 1e-6 | 2.0e-05 | 5 % | 123 |" in text
    assert "| coarse | none reaches it | - | - | - |" in text
    assert "- A GPU: there was none." in text
    assert "not quiet" not in text
    busy = copy.deepcopy(NUMBERS)
    busy["parts"]["wire"]["load"] = 1.9
    assert "not quiet" in render(busy)[f"{FOLDER}.md"]


def test_the_drawings_are_drawings_of_the_numbers(files):
    names = {f"{FOLDER}/{name}.svg" for name in ("cost", "memory", "throughput")}
    assert files.keys() == names | {f"{FOLDER}.md"}
    for name in names:
        ElementTree.fromstring(files[name])
        assert f"]({name})" in files[f"{FOLDER}.md"]
    assert files[f"{FOLDER}/cost.svg"].count("<circle") == len(SWEEP) + 1  # and the legend
    fewer = {**NUMBERS, "parts": {"wire": NUMBERS["parts"]["wire"]}}
    assert render(fewer).keys() == {f"{FOLDER}.md"}


def test_another_number_is_another_page(files):
    other = copy.deepcopy(NUMBERS)
    other["parts"]["sweep"]["tables"][0]["rows"][0]["ratio"] = 51.0
    found = render(other)
    changed = {name for name in files if found[name] != files[name]}
    assert changed == {f"{FOLDER}.md", f"{FOLDER}/cost.svg"}
    assert render(NUMBERS) == files


def test_numbers_of_another_format_are_refused():
    with pytest.raises(ValueError, match="format 0"):
        render({**NUMBERS, "format": 0})


# ---------------------------------------------------------------- what is committed


def committed():
    folder = page.PAGE.parent / FOLDER
    return json.loads((folder / page.NUMBERS).read_text(encoding="utf-8"))


def test_the_committed_page_is_that_of_the_committed_numbers():
    folder = page.PAGE.parent / FOLDER
    expected = render(committed())
    there = {f"{FOLDER}/{path.name}" for path in folder.iterdir()} | {page.PAGE.name}
    # of other pages, with tests of their own
    others = {f"{FOLDER}/{name}.json" for name in ("machines", "control", "guards")}
    assert there - others == expected.keys() | {f"{FOLDER}/{page.NUMBERS}"}
    for name, text in expected.items():
        assert (page.PAGE.parent / name).read_text(encoding="utf-8") == text, name


def test_the_committed_numbers_name_no_machine_and_have_no_times():
    numbers = committed()
    told = json.dumps(numbers)
    assert not re.search(r"/(home|tmp|work|root|usr)\b", told)
    for each in numbers["parts"].values():
        for table in each["tables"]:
            assert [row for row in table["rows"] if page_parts.UNITS.search(" ".join(row))] == []


def test_it_is_written_again_from_its_numbers(tmp_path):
    source = tmp_path / "given.json"
    source.write_text(json.dumps(NUMBERS))
    page.main(["--from", str(source), "--out", str(tmp_path / "docs" / "benchmarks.md")])
    assert (tmp_path / "docs/benchmarks.md").read_text() == render(NUMBERS)[f"{FOLDER}.md"]
    assert json.loads((tmp_path / "docs" / FOLDER / page.NUMBERS).read_text()) == NUMBERS
    with pytest.raises(SystemExit, match="no numbers"):
        page.main(["--from", str(tmp_path / "none.json"), "--out", str(tmp_path / "x.md")])


def test_parts_of_two_machines_do_not_stand_side_by_side():
    assert page.kept(NUMBERS, NUMBERS).keys() == NUMBERS["parts"].keys()
    other = {**NUMBERS, "machine": {**NUMBERS["machine"], "cores": 64}}
    with pytest.raises(SystemExit, match="another machine"):
        page.kept(other, NUMBERS)


# ---------------------------------------------------------------- what makes numbers


def test_absolute_columns_leave_with_their_units():
    row = {
        "engine": "x",
        "err": 1.0,
        "cpu [us/run]": 2.0,
        "runs/s (wall)": 3.0,
        "wall [s]": 1.0,
        "peak [MB]": 4.0,
        "stroke [mm]": 5.0,
        "cpu [ms]": 6.0,
        "of memory [%]": 7.0,
        "operations/step": 8,
        "Gop/s": 9.0,
    }
    assert page_parts.without_units(row).keys() == {"engine", "err", "of memory [%]", "operations/step"}


def test_rates_and_memory_are_shares():
    wires = [
        Table(
            f"Throughput, coupled wire, batch of {size}",
            [
                {"engine": "C lanes", "runs": size, "runs/s (wall)": rate},
                {"engine": "C one by one", "runs": size, "runs/s (wall)": 0.5 * rate},
            ],
        )
        for size, rate in ((1, 10.0), (64, 40.0))
    ]
    memory = Table("Cost", [{"runs": 1, "peak [MB]": 50.0}, {"runs": 10, "peak [MB]": 51.0}])
    small, large, grown = page_parts.rated([*wires, memory])
    assert [row["rate"] for row in (*small.rows, *large.rows)] == [0.25, 0.125, 1.0, 0.5]
    assert [row["memory"] for row in grown.rows] == [1.0, 1.02]
    assert "peak [MB]" not in grown.rows[0]


def test_equal_error_takes_the_coarsest_setting_within():
    def made(value):
        return lambda: lambda: value

    settings = {"coarse": made(1e-2), "middle": made(1e-5), "fine": made(1e-9)}
    contenders = [
        Contender("base", {"only": made(1e-7)}, lambda x: x),
        Contender("other", settings, lambda x: x),
        Contender("never", {"coarse": made(1.0)}, lambda x: x),
        Contender("broken", {"coarse": made(math.nan)}, lambda x: x),
    ]
    base, other, *rest = equal_error(contenders, 1e-4, 2, "base")
    assert (base["ratio"], base["setting"]) == (1.0, "only")
    assert (other["setting"], other["err"]) == ("middle", 1e-5)
    assert other["ratio"] > 0.0
    assert [row["ratio"] for row in rest] == [None, None]


def test_a_sweep_ends_where_its_time_ends(monkeypatch):
    asked = []

    def run_process(command):
        count = int(command[-1])
        asked.append(count)
        seconds = 1.0 + 1e-3 * count
        answer = {"cpu": seconds, "wall": seconds, "before": 100.0, "after": 100.0 + count / 1e4}
        return Usage(0.0, 0.0, 0.0, {**answer, "failed": 0, "stroke": 4e-3})

    monkeypatch.setattr(sections_sweep, "run_process", run_process)
    options = Options([], repeats=1, most=1_000_000, budget=50.0)
    (table,) = sections_sweep.sweep(options)
    assert asked == [1, 10, 100, 1_000, 10_000]
    assert "Left out for want of time: 100,000 runs and more" in table.note
    rows = {row["runs"]: row for row in table.rows}
    assert rows[1_000]["ratio"] == 1.0
    assert rows[10_000]["ratio"] == pytest.approx(11.0 / 20.0)
    assert rows[10_000]["memory"] == pytest.approx(1.01)
    assert "Left out" not in sections_sweep.sweep(options._replace(most=100))[0].note


@needs_c
def test_writing_is_measured_beside_small_sweeps(monkeypatch, capsys):
    pytest.importorskip("zarr")
    monkeypatch.setattr(write_once, "BASE", 20)
    monkeypatch.setattr(write_once, "TENTHS", 2)

    def run_process(command):
        write_once.main(int(command[-1]), "sobol")
        return Usage(0.0, 0.0, 0.0, json.loads(capsys.readouterr().out))

    monkeypatch.setattr(sections_sweep, "run_process", run_process)
    (table,) = sections_sweep.writing(Options([], most=1_000))
    assert [row["part"] for row in table.rows] == ["all", "first tenth", "last tenth"]
    assert all(row["ratio"] > 0.0 for row in table.rows[::2])


@needs_c
def test_the_short_sweep_moves(tmp_path):
    pytest.importorskip("zarr")
    failed, stroke = sweep_once.sweep(3, str(tmp_path))
    assert failed == 0
    assert 3e-3 < stroke < 5e-3


@pytest.mark.slow
def test_the_law_of_the_peers_is_ours():
    if sma_react_path.checkout() is None:
        pytest.skip("no checkout of SMA_REACT is named")
    loop = sma_react_path.thermal_path(100, page_laws.LINEAR, repeats=1)
    case = page_laws.Case(page_laws.law_of(page_laws.LINEAR), 50, page_laws.COLD, page_laws.HOT)
    mine = page_laws.law_paths.single(case, "floats")()
    assert page_laws.apart(loop.strain, mine) < 1e-12


def test_every_section_is_entered():
    import_module("benchmarks.__main__")
    wanted = "cells chain_memory chains derivatives fits laws machines mas realtime records"
    assert {*wanted.split(), "searches", "sweep", "throughput"} <= set(SECTIONS)
