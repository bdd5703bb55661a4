"""`martensite fit tangents`: what is read, printed and drawn, and one sentence on bad input.

Source of truth: the options as documented, and `martensite.characterise.tangent_points`, which is
tested by what it recovers.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from isobaric_cases import Bent
from typer.testing import CliRunner, Result

from martensite.characterise.tangent_fit import fit_tangents
from martensite.characterise.tangent_points import find_tangent_points
from martensite.cli import app
from martensite.logs import datasets
from martensite.show.figures.laboratory import MOST_PANELS, plot_tangents

SAMPLE = Bent()
STRESSES = (50e6, 100e6, 200e6)
FLEXINOL = [f"data:flexinol-isobaric/isobaric_{mpa}MPa.txt" for mpa in (50, 100, 172, 200)]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["fit", "tangents", *arguments])


def fine(*arguments: str) -> str:
    done = call(*arguments)
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    return done.stdout


def numbers(*arguments: str) -> dict[str, Any]:
    return json.loads(fine(*arguments, "--json"))


def refused(*arguments: str) -> str:
    done = call(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr


def log(stress: float, name: str, held: bool = True, cycles: int = 1) -> str:
    """A file with headings and everyday units; without a column of stress unless it is `held`."""
    lines = ["time [min],temperature [degC],strain [%]" + (",stress [MPa]" if held else "")]
    cycle = SAMPLE.cycle(stress)
    rows = list(zip(cycle["temperature"], cycle["strain"], strict=True)) * cycles
    for k, (kelvin, strain) in enumerate(rows):
        cells = [k / 60.0, kelvin - 273.15, 100.0 * strain, stress / 1e6][: 3 + held]
        lines.append(",".join(f"{cell:.15g}" for cell in cells))
    Path(name).write_text("\n".join(lines), encoding="utf-8")
    return name


def logs(held: bool = True) -> list[str]:
    return [log(stress, f"{stress / 1e6:.0f}.csv", held) for stress in STRESSES]


# ---------------------------------------------------------------- what is found


def test_points_and_summary() -> None:
    text = fine(*logs())
    at = SAMPLE.at(100e6)
    for value in at.values():
        assert f"{value - 273.15:.2f}" in text
    assert "56.85" in text and "8 " in text and "MPa/K" in text  # A_s at zero stress, C_A
    for name in ("C_A", "C_M", "eps_L", "A_f", "M_f"):
        assert name in text
    assert "H_k" not in text and "100.csv" not in text.replace("100 ", "")


def test_json_holds_what_python_finds() -> None:
    found = numbers(*logs())
    fit = fit_tangents([SAMPLE.cycle(stress) for stress in STRESSES])
    assert found["guess"] == pytest.approx(fit.guess(), rel=1e-9)
    assert [level["stress"] for level in found["levels"]] == pytest.approx(STRESSES)
    assert found["levels"][1]["A_half"] == pytest.approx(SAMPLE.half(100e6, False), abs=1e-6)
    assert found["reverse"]["slope"] == pytest.approx(8e6, rel=1e-9)
    assert set(found["reverse"]["separately"]) == {"A_s", "A_f", "A_half"}
    assert found["transformation_strain"]["form"] == "constant"
    assert (found["files"], found["remarks"]) == ([], [])


def test_stresses_of_logs_that_have_none() -> None:
    given = [text for s in STRESSES for text in ("--stress", f"{s / 1e6:g} MPa")]
    found = numbers(*logs(held=False), *given)
    assert found["guess"]["C_M"] == pytest.approx(SAMPLE.C_M, rel=1e-9)
    given[1] = "5e7 Pa"
    assert numbers(*logs(held=False), *given)["guess"] == pytest.approx(found["guess"], rel=1e-9)


def test_one_log() -> None:
    name = log(100e6, "one.csv")
    text = fine(name)
    assert "Tangents of 1 isobaric cycle\n" in text
    assert "need cycles at two or more stresses" in text and "eps_L" not in text
    found = numbers(name)
    assert set(found) == {"levels", "files"}
    assert found["levels"][0]["A_s"] == pytest.approx(SAMPLE.at(100e6)["A_s"], abs=1e-9)


def test_several_cycles_in_a_log() -> None:
    name = log(100e6, "two.csv", cycles=2)
    assert "Cycle 2 of 2 is used." in fine(name)
    assert "Cycle 1 of 2 is used." in fine(name, "--cycle", "1")
    assert "must be from 1 to 2" in refused(name, "--cycle", "3")
    assert "counts from 1 on, or is `all`, but is 0" in refused(name, "--cycle", "0")
    told = fine(name, "--cycle", "all")
    assert "median" in told
    assert "drift" in told
    assert "takes one LOG" in refused(name, name, "--cycle", "all")


@pytest.mark.skipif(
    not all(datasets.is_here(name.removeprefix("data:")) for name in FLEXINOL),
    reason="data set flexinol-isobaric is not on this machine",
)
def test_published_logs() -> None:
    text = fine(*FLEXINOL)
    assert "8.069" in text and "7.669 to 8.513" in text and "7.58" in text
    assert "A_s and A_f rise differently with stress" in text


# ---------------------------------------------------------------- the figure


def test_the_figure(folder: Path) -> None:
    text = fine(*logs(), "--figure", "tangents.svg")
    assert "wrote tangents.svg" in text
    assert "is there already" in refused(*logs(), "--figure", "tangents.svg")
    fine(*logs(), "--figure", "tangents.svg", "--force")
    fine(log(100e6, "one.csv"), "--figure", "one.png")
    assert sorted(p.suffix for p in folder.iterdir()) == [".csv"] * 4 + [".png", ".svg"]


def test_what_is_drawn() -> None:
    fit = fit_tangents([SAMPLE.cycle(stress) for stress in STRESSES])
    axes = plot_tangents(fit).axes
    assert len(axes) == len(STRESSES) + 2
    for points, panel in zip(fit.levels, axes, strict=False):
        drawn = [np.ravel(np.asarray(line.get_xdata())) for line in panel.lines]
        marks = [float(x[0]) + 273.15 for x in drawn if x.size == 1]
        assert marks == pytest.approx([points.A_s, points.A_f, points.M_f, points.M_s])
        assert sum(x.size == 2 for x in drawn) == 6  # tangents
        assert sum(x.size > 2 for x in drawn) == 2  # branches
    diagram, strain = axes[-2:]
    assert "C_A" in diagram.get_title(loc="left") and diagram.get_ylim()[0] == 0.0
    assert strain.get_ylabel().endswith("[%]")
    (alone,) = plot_tangents(find_tangent_points(SAMPLE.cycle(100e6))).axes
    assert "100 MPa" in alone.get_title(loc="left")
    many = fit_tangents([SAMPLE.cycle(1e6 * s, rows=60) for s in range(20, 200, 20)])
    assert len(plot_tangents(many).axes) == MOST_PANELS + 2


# ---------------------------------------------------------------- bad input


def test_bad_input() -> None:
    good = log(100e6, "good.csv")
    assert "There is no file `absent.csv`" in refused("absent.csv")
    assert "all at 100 MPa" in refused(good, good)
    assert "stresses: 1, logs: 2" in refused(good, good, "--stress", "1 MPa")
    assert "has no unit" in refused(good, "--stress", "100")
    assert "`--stress`" in refused(good, "--stress", "100 K")
    assert "must end in .png" in refused(good, "--figure", "f.csv")
    assert "has no column `stress`" in refused(log(100e6, "bare.csv", held=False))
    Path("cold.csv").write_text("temperature [degC],strain [1]\n" + "20,0.01\n" * 30)
    assert "no full cycle" in refused("cold.csv", "--stress", "1 MPa")
    Path("swapped.csv").write_text("strain [1],temperature [K]\n" + "300,0.01\n" * 30)
    assert "columns swapped?" in refused("swapped.csv", "--stress", "1 MPa")
    assert "No data set named" in refused("data:flexinol/isobaric_50MPa.txt")


def test_a_wrong_number_would_be_noticed() -> None:
    """The comparison with Python above fails for a log of another sample."""
    found = numbers(*logs()[:2], log(210e6, "200.csv"))
    fit = fit_tangents([SAMPLE.cycle(stress) for stress in STRESSES])
    assert found["levels"][2]["A_s"] != pytest.approx(fit.levels[2].A_s, rel=1e-9)
