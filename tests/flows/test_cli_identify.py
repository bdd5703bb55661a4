"""`martensite identify` and `martensite list block`: what is read, printed and written; bad input.

Source of truth: the system that the logs were computed with (`first_order`), and the same
estimation in Python.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command import Command
from first_order import LINE, STRUCTURE, log, pulses, ramps

from martensite.base.errors import InputError
from martensite.cli.commands.identify import ANCHOR, IdentifyOptions
from martensite.identify.blocks.base import BLOCKS
from martensite.identify.chains.estimate import INTERRUPTED, Options
from martensite.identify.chains.stages import identify_stages
from martensite.logs.sampled_files import read_sampled, write_sampled
from martensite.scenario.identify_logs import choose_columns, guess_columns
from martensite.scenario.model_files import read_model
from martensite.show.summaries.identification import collect_warnings

IDENTIFY = Command("identify")
SIGNALS = ("--input", "duty", "--unit", "duty=%", "--starts", "3")
ONE = (*SIGNALS, "--output", "temperature", "--stage", STRUCTURE)
TWO = (*SIGNALS, "--output", "position", "--stage", STRUCTURE, "--stage", LINE)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_sampled(log("pulses", pulses(1)), "pulses.csv")
    write_sampled(log("ramps", ramps(), seed=2), "ramps.csv")
    return tmp_path


# ---------------------------------------------------------------- what is found


def test_a_single_stage() -> None:
    text = IDENTIFY.fine("pulses.csv", *ONE, "--validate", "ramps.csv")
    assert "Model: `duty` -> `temperature`: poly(2) | oe(1,1,1)" in text
    assert "free runs (no feedback of measured outputs)" in text
    assert "3 of 3 refined searches agree" in text
    assert "estimation" in text
    assert "validation" in text
    assert "prediction error is unknown" not in text
    assert "optimum may be local" not in text


def test_columns_of_which_there_is_no_choice_need_not_be_named() -> None:
    rows = Path("pulses.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].split(",")[3].startswith("position")
    two = [",".join(row.split(",")[:3]) for row in rows]
    Path("two.csv").write_text("\n".join([*two, ""]), encoding="utf-8")
    assert choose_columns("two.csv", [], None, []) == (["duty"], "temperature")
    assert choose_columns("two.csv", [], "temperature", []) == (["duty"], "temperature")
    assert choose_columns("pulses.csv", [], None, ["temperature", "position"]) == (["duty"], "position")
    assert choose_columns("pulses.csv", ["duty"], None, ["temperature"]) == (["duty"], "temperature")
    with pytest.raises(InputError, match="--input, a column of the logs: `duty`, `temperature`"):
        choose_columns("pulses.csv", [], None, [])
    with pytest.raises(InputError, match="--output"):
        choose_columns("pulses.csv", ["duty"], None, [])


def test_a_log_alone_is_enough() -> None:
    text = IDENTIFY.fine("pulses.csv", "--unit", "duty=%", "--out", "model.json", "--report", "page.md")
    assert "Input `duty`, output `position`: by their names, of `duty`, `temperature`, `position`" in text
    assert "predicts: fit" in text
    assert "chosen" in text
    assert read_model("model.json").output_names == ("position",)
    page = Path("page.md").read_text(encoding="utf-8")
    assert "## Next recordings" in page
    assert "held-out" in page
    assert Path("page_figures/held0.png").is_file()
    assert "is there already" in IDENTIFY.refused("pulses.csv", "--report", "page.md")
    assert "must end in" in IDENTIFY.refused("pulses.csv", "--report", "page.txt")


def test_a_log_that_cannot_tell_is_exit_code_1() -> None:
    step = log("step", np.concatenate([np.zeros(50), np.full(150, 20.0)]))
    write_sampled(step, "step.csv")
    done = IDENTIFY("step.csv", "--unit", "duty=%")
    assert done.exit_code == 1
    assert "moves once" in done.stdout
    assert guess_columns("step.csv", ["duty"], None)[:2] == (["duty"], "position")


def test_without_another_record_nothing_is_proved() -> None:
    text = IDENTIFY.fine("pulses.csv", *ONE)
    assert "the prediction error is unknown" in text
    assert "another time scale" in text


def test_json_holds_what_python_finds() -> None:
    found = IDENTIFY.report("pulses.csv", *ONE, "--validate", "ramps.csv")
    records = [
        read_sampled(f"{name}.csv", ["duty"], ["temperature"], units={"duty": "%"}) for name in ("pulses", "ramps")
    ]
    same = identify_stages(records[0], STRUCTURE, records[1], options=Options(starts=3, anchor=0.1))
    fits = {score["role"]: score["fit"] for score in found["scores"]}
    assert fits["validation"] == pytest.approx(same.fit()[0], abs=1e-6)
    assert fits["validation"] > 98.0
    assert found["free_run"] is True
    assert found["stages"][0]["agreeing"] == 3
    assert set(found["stages"][0]["numbers"]) == set(found["stages"][0]["standard_errors"]) == set(same.model.names())


def test_stages_in_series_are_saved_and_drawn(folder: Path) -> None:
    wanted = ("--out", "model.json", "--figure", "model.svg")
    text = IDENTIFY.fine("pulses.csv", *TWO, "--other", "ramps.csv", *wanted)
    assert "Stage 2: `temperature` -> `position`: poly(1)" in text
    assert "series" in text
    assert sorted(p.name for p in folder.iterdir() if p.suffix != ".csv") == [
        "model.json",
        "model.stage1.json",
        "model.stage2.json",
        "model.svg",
    ]
    model = read_model("model.json")
    slow = read_sampled("ramps.csv", ["duty"], ["position"], units={"duty": "%"})
    assert abs(model.simulate(slow) - slow.outputs).max() < 0.06
    written = json.loads(Path("model.json").read_text())
    assert len(written["provenance"]["stages"]) == 2
    assert "is there already" in IDENTIFY.refused("pulses.csv", *TWO, *wanted)


def test_few_searches_that_agree_are_warned_of() -> None:
    one = log("pulses", pulses(1))
    few = identify_stages(one, [STRUCTURE, LINE], one, options=Options(starts=2, refined=2))
    assert any("only 2 of 2 refined searches" in s for s in collect_warnings(few, [one]))


def test_an_interrupted_search_exits_with_1(monkeypatch: pytest.MonkeyPatch) -> None:
    from martensite.identify.chains import stages

    whole = stages.identify_stages

    def interrupted(*arguments: object) -> object:
        arguments[-1](f"stage 1: {INTERRUPTED}", 0.5)  # type: ignore[operator]
        return whole(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(stages, "identify_stages", interrupted)
    done = IDENTIFY("pulses.csv", *ONE)
    assert done.exit_code == 130
    assert "best so far" in done.stderr
    assert "temperature" in done.stdout


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("absent.csv", *ONE), "There is no file `absent.csv`"),
        (("pulses.csv", "--input", "dutty", "--output", "temperature", "--stage", "poly1"), "Did you mean `duty`"),
        (("pulses.csv", "--output", "temperature", "--stage", "poly1"), "needs --input"),
        (("pulses.csv", "--input", "duty", "--stage", "poly1"), "needs --output"),
        (("pulses.csv", *SIGNALS, "--output", "temperature", "--stage", "poly{1,2}"), "poly{1,2}"),
        (("pulses.csv", *SIGNALS, "--output", "temperature", "--stage", "polly1"), "There is no block `polly`"),
        (("pulses.csv", *SIGNALS, "--output", "position", "--stage", STRUCTURE), "The last stage gives `temperature`"),
        (("pulses.csv", *SIGNALS, "--output", "position", "--stage", "poly1", "--stage", "poly1"), "names no output"),
        (("pulses.csv", *ONE, "--initial", "resting"), "Did you mean `rest`"),
        (("pulses.csv", *ONE, "--interval", "20"), "`--interval`"),
        (("pulses.csv", *ONE, "--interval", "0 s"), "above 0 s"),
        (("pulses.csv", *ONE, "--unit", "duty"), "write `COLUMN=UNIT`"),
        (("pulses.csv", *ONE, "--unit", "temperature=mm"), "cannot be converted"),
        (("pulses.csv", *ONE, "--skip", "1000 s"), "no known samples that count"),
        (("pulses.csv", *ONE, "--out", "model.txt"), "must end in .json"),
    ],
)
def test_bad_input(arguments: tuple[str, ...], words: str) -> None:
    assert words in IDENTIFY.refused(*arguments)


def test_the_anchor_is_on_where_a_record_begins_at_rest() -> None:
    def given(initial: str, anchor: float | None) -> float:
        one = IdentifyOptions(initial=initial, anchor=anchor)
        return one.choose_search(0.1).anchor

    assert given("rest", None) == ANCHOR
    assert given("zero", None) == 0.0
    assert given("estimate", 0.5) == 0.5


# ---------------------------------------------------------------- blocks


def test_blocks_are_listed_and_described() -> None:
    text = Command("list", "block").fine()
    for name in BLOCKS.names():
        assert name in text
    assert "oe(nb,nf,nk)" in text
    listed = Command("list", "block").report()
    assert {row["name"] for row in listed} == set(BLOCKS.names())  # type: ignore[index]
    for name in ("transfer-function", "oe"):
        assert "number of poles" in Command("list", "block").fine(name)
    assert "Did you mean `polynomial`" in Command("list", "block").refused("polynomal")
