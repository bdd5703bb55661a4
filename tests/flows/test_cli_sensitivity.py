"""`sensitivity` and `pareto`: what they show and write, and how they refuse.

Sources of truth: the same functions called from Python, and the store.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from command import Command
from sweep_cases import AXES, WIRE

from martensite.design.sweep.indices import compute_sensitivity
from martensite.design.sweep.pareto import find_pareto_front
from martensite.design.sweep.reading import read_sweep

SWEEP, SENSITIVITY, PARETO = Command("sweep"), Command("sensitivity"), Command("pareto")
QUICK = "--backend", "serial", "--runtime", "floats"
GOALS = "--minimise", "energy", "--maximise", "stroke"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("wire") / "wire.toml"
    path.write_text(WIRE.replace('"0.1 s"\n', '"0.2 s"\n'), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def store(scenario: Path) -> Path:
    """Blocks of four runs."""
    path = scenario.with_name("blocks.zarr")
    over = "--over", "diameter=0.12..0.2 mm", "--over", "high=5..9 V"
    SWEEP.fine(str(scenario), *over, "--sample", "saltelli:16", "--out", str(path), *QUICK)
    return path


def test_indices_are_shown_the_most_important_first(store: Path) -> None:
    (known,) = compute_sensitivity(read_sweep(store), ["energy"])
    shown = SENSITIVITY.fine(str(store), "--output", "energy")
    lines = [line.split() for line in shown.splitlines()]
    rows = [line for line in lines if line and line[0] in known.names]
    assert [row[0] for row in rows] == [known.names[k] for k in known.order]
    first, total = (known.indices[kind] for kind in ("first", "total"))
    for row, k in zip(rows, known.order, strict=True):
        assert row[1:] == [*first.words(k).split(), *total.words(k).split()]
    assert "64 runs" in shown
    assert "more base samples" in shown


def test_indices_are_told_as_json(store: Path) -> None:
    told = SENSITIVITY.report(str(store))
    known = {one.measure: one for one in compute_sensitivity(read_sweep(store))}
    assert list(told["measures"]) == list(known)
    for name, one in told["measures"].items():
        index = known[name].indices["total"]
        values = [v["value"] for v in one["indices"]["total"].values()]
        assert values == pytest.approx(index.values.tolist())
    assert (told["sample"], told["runs"], told["failed"]) == ("saltelli:16", 64, 0)


def test_a_figure_of_indices_is_written(store: Path, tmp_path: Path) -> None:
    figure = tmp_path / "indices.svg"
    told = SENSITIVITY.fine(str(store), "--figure", str(figure), "--output", "stroke")
    assert f"wrote {figure}" in told
    assert "svg" in figure.read_text(encoding="utf-8")
    assert "is there already" in SENSITIVITY.refused(str(store), "--figure", str(figure))


def test_a_front_is_shown_told_and_saved(store: Path, tmp_path: Path) -> None:
    saved, figure = tmp_path / "front.csv", tmp_path / "front.svg"
    files = "--out", str(saved), "--figure", str(figure)
    told = PARETO.report(str(store), *GOALS, *files)
    found = read_sweep(store)
    front = find_pareto_front(found, ["energy"], ["stroke"])
    assert [one["run"] for one in told["front"]] == front.runs.tolist()
    assert told["goals"] == {"energy": "least", "stroke": "most"}
    with saved.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["run"]) for row in rows] == front.runs.tolist()
    strokes = [float(row["stroke [m]"]) for row in rows]
    assert strokes == found.measures["stroke"].values[front.runs].tolist()
    assert np.all(np.diff(strokes) > 0.0)
    assert figure.is_file()
    shown = PARETO.fine(str(store), *GOALS)
    assert f"{len(front.runs)} of 64 runs are on the Pareto front" in shown
    assert found.measures["stroke"].words(strokes[0]) in shown


def test_a_sweep_draws_what_it_found(scenario: Path, tmp_path: Path) -> None:
    figure, out = tmp_path / "map.svg", tmp_path / "grid.zarr"
    asked = str(scenario), *AXES, "--out", str(out), *QUICK, "--figure", str(figure)
    SWEEP.fine(*asked[:-2])
    figure.write_text("of the last time")
    SWEEP.fine(*asked)  # without a new run
    assert "<svg" in figure.read_text("utf-8")
    assert "must end in" in SWEEP.refused(*asked[:-1], "map.xyz")


@pytest.mark.parametrize(
    ("command", "words", "sentence"),
    [
        (SENSITIVITY, ("--output", "energie"), "Did you mean `energy`"),
        (SENSITIVITY, ("--figure", "x.csv"), "must end in"),
        (PARETO, (), "--minimise"),
        (PARETO, ("--maximise", "strok"), "Did you mean `stroke`"),
        (PARETO, ("--maximise", "stroke", "--minimise", "stroke"), "a goal twice"),
        (PARETO, ("--maximise", "stroke", "--out", "x.json"), "must end in .csv"),
    ],
)
def test_they_refuse(store: Path, command: Command, words: tuple[str, ...], sentence: str) -> None:
    assert sentence in command.refused(str(store), *words)


def test_what_is_no_sweep_is_refused(tmp_path: Path) -> None:
    for command in (SENSITIVITY, PARETO):
        assert "holds no sweep" in command.refused(str(tmp_path / "none.zarr"), "--json")
