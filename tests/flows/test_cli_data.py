"""`data show FILE` and commands that read logs: what an instrument wrote is understood, corrected and kept.

Source of truth: numbers put into the files here.
"""

from pathlib import Path

import numpy as np
import pytest
from command import Command

from martensite.logs.reader import read_table

SHOW = Command("data", "show")
LOOP = [*range(40), *range(40, -1, -1)]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A lab's loop with two title lines and foreign headings, and one with none."""
    monkeypatch.chdir(tmp_path)
    ways = [8.0 if n < 40 else -8.0 for n in range(len(LOOP))]
    strains = [2.0 * (1.0 - np.tanh((2.0 * k - 40.0 - way) / 6.0)) for k, way in zip(LOOP, ways, strict=True)]
    rows = [(20.0 + 2.0 * k, e, 172.0 + k % 3) for k, e in zip(LOOP, strains, strict=True)]
    text = "".join(f"{t};{e:.3f};{s}\n" for t, e, s in rows).replace(".", ",")
    (tmp_path / "loop.csv").write_text(f"Wire 3\nChamber B\nTemp (C);Strain (%);Load level\n{text}", "utf-8")
    (tmp_path / "plain.txt").write_text("".join(f"{np.sin(k):.4f} {np.cos(3 * k):.4f}\n" for k in range(30)))
    return tmp_path


def test_one_screen_says_what_was_understood() -> None:
    shown = SHOW.fine("loop.csv")
    assert "Text, separated by semicolons, decimal commas, 3 heading lines." in shown
    assert max(map(len, shown.splitlines()[:8])) <= 80
    (row,) = [line.split() for line in shown.splitlines() if "temperature" in line]
    assert row == ["1", "Temp", "(C)", "°C", "temperature", "20", "100", "°C", "heading"]
    assert "Column 3 `Load level` is taken for force in N by its values alone" in shown


def test_columns_are_corrected_and_the_table_is_saved(folder: Path) -> None:
    given = ("loop.csv", "--as", "Load level=stress[MPa]", "--out", "clean.csv")
    SHOW.fine(*given)
    assert "--force" in SHOW.refused(*given)
    record = read_table(folder / "clean.csv")
    assert (record["stress"][0], record["temperature"][0]) == pytest.approx((172e6, 293.15))
    (answer,) = SHOW.report("loop.csv", "--as", "3=-")["tables"]
    assert [one["name"] for one in answer["columns"]] == ["temperature", "strain", "-"]
    assert answer["columns"][2]["low"] is None


def test_what_cannot_be_told_is_a_sentence_that_says_what_to_write() -> None:
    assert "--as 1=stress[MPa]" in SHOW.refused("plain.txt")
    assert "does not say which column" in SHOW.refused("plain.txt", "--as", "stress")
    assert "There is no file" in SHOW.refused("absent.txt")
    assert "join them by --merge" in SHOW.refused("loop.csv", "loop.csv", "--out", "a.csv")
    assert "there is one file only" in SHOW.refused("loop.csv", "--merge")
    assert "has no times" in SHOW.refused("loop.csv", "loop.csv", "--merge")


def test_tangents_are_found_in_a_file_with_foreign_headings() -> None:
    done = Command("fit", "tangents")("loop.csv", "--stress", "172 MPa")
    assert done.exit_code == 0, done.output
    assert "loop.csv: text, separated by semicolons" in done.stderr


def test_identify_takes_what_columns_are(folder: Path) -> None:
    rng = np.random.default_rng(3)
    drive, answer, lines = 0.0, 0.0, ["Versuch 7"]
    for k in range(300):
        drive = float(rng.integers(0, 5)) if k % 10 == 0 else drive
        answer += 0.2 * (drive - answer)
        lines.append(f"{0.1 * k:.1f}\t{drive:.1f}\t{20.0 + answer:.5f}")
    (folder / "run.txt").write_text("\n".join(lines))
    named = [part for text in ("1=time[s]", "2=voltage[V]", "3=temperature[degC]") for part in ("--as", text)]
    options = ("--stage", "oe(1,1,0)", "--output", "temperature", "--starts", "1")
    done = Command("identify")("run.txt", *named, *options)
    assert done.exit_code == 0, done.output
    assert "run.txt: text, separated by tabs" in done.stderr
