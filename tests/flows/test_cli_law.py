"""`martensite law`: runs for every law, says what is wrong, writes nothing then.

Source of truth: the registries, and numbers of the result read back from what was printed.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from martensite.cli import app
from martensite.logs.reader import read_table
from martensite.physics.laws.base import LAWS
from martensite.simulate.paths import PATHS

QUICK = ("--tolerance", "0.05")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["law", *arguments])


def fine(*arguments: str) -> str:
    done = call(*arguments)
    assert (done.exit_code, done.stderr) == (0, ""), done.output
    return done.stdout


def report(*arguments: str) -> Any:
    return json.loads(fine(*arguments, "--json"))


def refused(*arguments: str) -> str:
    done = call(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


# ---------------------------------------------------------------- what it says


LONG = ("isobaric", "mas-polycrystal")
"""Its other path is with the quick tests."""


@pytest.mark.parametrize(
    ("path", "name"),
    [
        pytest.param(path, name, marks=[pytest.mark.slow] if (path, name) == LONG else [])
        for path in ("superelastic", "isobaric")
        for name in LAWS.names()
    ],
)
def test_every_law_runs_and_transforms(name: str, path: str) -> None:
    found = report(name, "--path", path, *QUICK)
    (law,) = found["laws"]
    assert law["name"] == name
    assert law["material"]
    assert {one["status"] for one in law["paths"]} <= {"OK", "LONG_STEP"}
    assert all(len(one["legs"]) == 2 for one in law["paths"])
    assert max(abs(leg["martensite"]) for one in law["paths"] for leg in one["legs"]) > 0.9


@pytest.mark.parametrize("path", PATHS)
def test_every_path_runs_as_text(path: str) -> None:
    printed = fine("liang-rogers", "--path", path)
    assert f"on the path {path}, material benchmark-liang-rogers" in printed
    assert "forward" in printed
    assert "residual strain" in printed


def test_numbers_of_a_loop_follow_from_the_parameters() -> None:
    (law,) = report(
        "liang-rogers",
        "--at",
        "75 degC",
        "--stress",
        "600 MPa",
        "--set",
        "C_A=7 MPa/K",
        "--set",
        "C_M=7 MPa/K",
        "--set",
        "A_s=40 degC",
        "--set",
        "A_f=50 degC",
        "--set",
        "M_s=30 degC",
        "--set",
        "M_f=20 degC",
    )["laws"]
    (one,) = law["paths"]
    up, down = one["legs"]
    assert up["spots"][1]["stress"] == pytest.approx(7e6 * (75 - 25), rel=5e-3)
    assert down["spots"][1]["stress"] == pytest.approx(7e6 * (75 - 45), rel=5e-3)
    assert up["end"]["stress"] == 600e6
    assert one["residual_strain"] == pytest.approx(0.0, abs=1e-12)
    assert one["label"] == "75 °C"
    assert one["work"] > 1e6


def test_the_material_is_said_and_can_be_chosen() -> None:
    assert report("brinson", *QUICK)["laws"][0]["material"] == "niti-brinson-1993"
    chosen = report("liang-rogers", "--material", "flexinol-90", *QUICK)
    assert chosen["laws"][0]["material"] == "flexinol-90"


def test_several_laws_share_a_material_that_has_the_numbers_of_all() -> None:
    found = report("liang-rogers", "brinson", "--set", "brinson.sigma_s=90 MPa", *QUICK)
    assert [law["material"] for law in found["laws"]] == ["niti-brinson-1993"] * 2
    mixed = report("liang-rogers", "mas", *QUICK)
    assert mixed["laws"][0]["material"] != mixed["laws"][1]["material"]


def test_start_and_rate_reach_the_path() -> None:
    twinned = report("brinson", "--path", "free-recovery", "--from", "austenite", *QUICK)
    usual = report("brinson", "--path", "free-recovery", *QUICK)
    first = [r["laws"][0]["paths"][0]["legs"][0]["process"] for r in (twinned, usual)]
    assert first == ["forward", "orientation"]
    slow, fast = (
        report("mas", "--at", "70 degC", "--rate", rate, *QUICK)["laws"][0]["paths"][0]
        for rate in ("0.001 MPa/s", "1000 MPa/s, 1 K/s, 0.1 %/s")
    )
    starts = [one["legs"][0]["spots"][0]["stress"] for one in (slow, fast)]
    assert starts[1] > starts[0] + 0.5e6


# ---------------------------------------------------------------- what it writes


def test_figure_and_table_are_written_and_not_overwritten(folder: Path) -> None:
    wanted = "--figure", "a.png", "--out", "a.csv"
    printed = fine("liang-rogers", "tanaka", "--at", "70 degC", *QUICK, *wanted)
    assert "wrote a.csv" in printed
    assert "wrote a.png" in printed
    assert (folder / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert {p.name for p in folder.iterdir()} == {"a.png", "a.csv"}
    before = (folder / "a.csv").read_text(encoding="utf-8")
    assert before.startswith("# case 0: liang-rogers, 70 °C\n# case 1: tanaka, 70 °C\ncase [1],")
    assert "use --force" in refused("liang-rogers", *QUICK, *wanted)
    assert (folder / "a.csv").read_text(encoding="utf-8") == before
    fine("liang-rogers", *QUICK, *wanted, "--force")
    assert (folder / "a.csv").read_text(encoding="utf-8") != before


def test_the_table_of_one_path_is_a_measured_table(folder: Path) -> None:
    fine("liang-rogers", "--at", "75 degC", "--stress", "450 MPa", "--out", "loop.csv")
    record = read_table(folder / "loop.csv")
    assert max(record["stress"]) == pytest.approx(450e6)
    assert record["temperature"][0] == pytest.approx(348.15)
    assert max(record["martensite_fraction"]) > 0.0
    assert record["time"][-1] == pytest.approx(90.0)


# ---------------------------------------------------------------- what it refuses


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("brinsn",), "No law named `brinsn`. Did you mean `brinson`?"),
        (("tanaka", "--path", "isobarc"), "No path named `isobarc`. Did you mean `isobaric`?"),
        (("tanaka", "--material", "flexinol-91"), "Did you mean `flexinol-90`?"),
        (("brinson", "--material", "flexinol-90"), "material `flexinol-90` does not hold it"),
        (("tanaka", "--set", "A_ff=3"), "Did you mean `A_f`?"),
        (("tanaka", "brinson", "--set", "sigma_q=3"), "reaches none of the laws"),
        (("tanaka", "--set", "A_f"), "is not a setting"),
        (("tanaka", "--at", "30"), "Option `--at`: `30` has no unit"),
        (("tanaka", "--stress", "-3 MPa"), "values of at least 0"),
        (("tanaka", "--path", "tension", "--strain", "1 %, 2 %"), "takes one strain"),
        (("tanaka", "--path", "isobaric", "--at", "30 degC"), "takes no temperatures"),
        (("tanaka", "--from", "austenit"), "Did you mean `austenite`?"),
        (("tanaka", "--rate", "3 m/s"), "is no rate above 0"),
        (("tanaka", "--runtime", "fortran"), "No runtime named `fortran`"),
        (("tanaka", "--tolerance", "0"), "`tolerance` must be above 0"),
        (("tanaka", "--out", "a.nc"), "must end in .csv"),
        (("tanaka", "--figure", "a.gif"), "must end in"),
        (("tanaka", "--figure", "nowhere/a.png"), "no folder `nowhere`"),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(folder: Path, arguments: tuple[str, ...], sentence: str) -> None:
    wanted = () if {"--out", "--figure"} & set(arguments) else ("--out", "a.csv")
    assert sentence in refused(*arguments, *wanted)
    assert list(folder.iterdir()) == []


def test_a_law_without_a_material_says_what_is_missing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("martensite.scenario.laws.material_names", lambda: ["flexinol-90"])
    said = refused("brinson")
    assert "`flexinol-90` comes nearest and lacks `sigma_s`, `sigma_f`" in said
    assert report("brinson", "--set", "sigma_s=100 MPa", "--set", "sigma_f=170 MPa", *QUICK)


# ---------------------------------------------------------------- beside a log


def write_log(path: str, *arguments: str) -> str:
    """A log that a law has written, with another zero of its strain: its truth is known."""
    fine("liang-rogers", "--path", path, *arguments, "--out", f"{path}.csv")
    record = read_table(f"{path}.csv")
    rows = zip(*(record[name] for name in ("time", "temperature", "stress", "strain")), strict=True)
    lines = [f"{t},{T - 273.15},{s / 1e6},{100 * e + 1.0}" for t, T, s, e in rows]
    Path("log.csv").write_text("time [s],temperature [degC],stress [MPa],strain [%]\n" + "\n".join(lines) + "\n")
    return "log.csv"


@pytest.mark.parametrize(
    ("path", "compared", "how"),
    [("isobaric", "strain", ("--stress", "150 MPa")), ("superelastic", "stress", ("--at", "90 degC"))],
)
def test_a_law_meets_the_log_that_it_wrote_and_another_law_does_not(
    path: str, compared: str, how: tuple[str, ...]
) -> None:
    log = write_log(path, *how)
    own, other = report("liang-rogers", "tanaka", "--log", log, "--figure", "log.svg")["laws"]
    assert own["compared"] == other["compared"] == compared
    assert own["largest"] < 1e-6 < 0.05 < other["largest"]
    assert own["rms"] <= own["largest"]
    assert abs(own["shift"]) == pytest.approx(0.01, abs=1e-9)
    assert "liang-rogers, RMS" in Path("log.svg").read_text()


def test_a_constant_that_a_log_lacks_is_given() -> None:
    log = Path(write_log("isobaric", "--stress", "150 MPa"))
    log.write_text(
        "\n".join(",".join(line.split(",")[:2] + line.split(",")[3:]) for line in log.read_text().splitlines())
    )
    assert "has no column `stress`" in refused("liang-rogers", "--log", "log.csv")
    (own,) = report("liang-rogers", "--log", "log.csv", "--stress", "150 MPa")["laws"]
    assert own["largest"] < 1e-6


def test_what_has_no_effect_beside_a_log_is_refused() -> None:
    log = write_log("isobaric", "--stress", "150 MPa")
    assert "a constant one has no effect" in refused("liang-rogers", "--log", log, "--stress", "1 MPa")
    assert "`--path` has no effect" in refused("liang-rogers", "--log", log, "--path", "isobaric")
    assert "`--as` has no effect" in refused("liang-rogers", "--as", "1=time[s]")
