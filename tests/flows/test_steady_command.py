"""`martensite steady`: what it says, what it draws, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command import Command

ROOT = Path(__file__).parents[2]
WIRE, BEAM = (str(ROOT / "examples" / f"{name}.toml") for name in ("pwm_bias_spring", "sommerfeld_beam"))
STEADY = Command("steady")


def test_a_rest_says_where_it_is_and_what_is_neutral() -> None:
    text = STEADY.fine(WIRE, "--drive", "1.2 V")
    assert "54.91  °C" in text and "from the cold" in text and "Neutral directions: 4" in text
    hot, cold = (
        STEADY.report(WIRE, "--drive", "1.5 V", *more, "--json") for more in (("--from", "hot", "--high", "4 V"), ())
    )
    assert hot["outputs"]["position"] > cold["outputs"]["position"] and hot["stable"] is True


def test_a_cycle_is_shot_for_and_drawn(tmp_path: Path) -> None:
    figure = tmp_path / "cycle.svg"
    done = STEADY(WIRE, "--cycle", "--json", "--figure", str(figure))
    found = json.loads(done.stdout)
    assert done.exit_code == 1 and [one["limit"] for one in found["limits"]["exceeded"]] == [413.15]
    assert found["period"] == pytest.approx(0.1) and found["stable"] is True
    assert found["outputs"]["temperature"] == pytest.approx([412.771, 413.736], abs=2e-3)
    assert figure.stat().st_size > 1000


def test_a_curve_with_its_fold_runs_and_a_boundary(tmp_path: Path) -> None:
    figure = tmp_path / "curve.svg"
    more = (
        "--against",
        "damping=0.2..0.25 N*s/m",
        "--runs",
        "3",
        "--hold",
        "4 s",
        "--steps",
        "128",
        "--figure",
        str(figure),
    )
    found = STEADY.report(BEAM, "--over", "motor=2..8 V", *more, "--json", "--speed", "Hz")
    (fold,) = found["folds"]
    assert fold["parameter"] == pytest.approx(6.3919, abs=3e-3) and fold["speed_shown"].startswith("8.36")
    assert found["boundaries"][0]["second"][0] == pytest.approx(0.2)
    assert [len(run["speed"]) for run in found["runs"]] == [3, 3]
    drawn = figure.read_text("utf-8")
    assert "run up" in drawn or drawn.count("<path") > 20


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((WIRE,), "changes in time"),
        ((WIRE, "--drive", "2 A"), "A"),
        ((WIRE, "--drive", "motr=2 V"), "`motr`"),
        ((WIRE, "--over", "drive=1..2 V"), "Nothing turns"),
        ((BEAM, "--over", "motor"), "is no free parameter"),
        ((BEAM, "--over", "motr=1..2 V"), "`motr`"),
        ((BEAM, "--over", "motor=2..1 V"), "must rise"),
        ((BEAM, "--cycle"), "has no period"),
        ((WIRE, "--cycle", "--drive", "2 V"), "`--drive` has no effect"),
        ((WIRE, "--against", "duty=0.1..0.2"), "`--against` has no effect"),
        ((BEAM, "--over", "motor=1..2 V", "--runs", "3"), "--hold"),
        ((BEAM, "--over", "motor=1..2 V", "--speed", "rph"), "rpm"),
    ],
)
def test_what_makes_no_sense_is_refused(words: tuple[str, ...], sentence: str) -> None:
    assert sentence in STEADY.refused(*words)
