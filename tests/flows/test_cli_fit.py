"""`martensite fit LOG...`: what is printed and written, one sentence on bad input, interrupts.

Source of truth: the options as documented, and logs made with known numbers.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import fit_cases
import pytest
from command import Command
from fit_cases import HEATED, ISOBARIC, Rows, edited, heated, isobaric, read_rows, write_log

from martensite.cli.commands.fit import logs as fit_logs
from martensite.fit.search_monitor import SearchNote, Tell
from martensite.scenario.scenario import load
from martensite.show import html

FIT = Command("fit")
SMALL = ("log.csv", "--scenario", "isobaric.toml", "--free", "A_s,A_f")
HEAT = ("--scenario", "heated.toml", "--free", "h=30..200 W/m^2/K")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("isobaric.toml").write_text(ISOBARIC, encoding="utf-8")
    Path("heated.toml").write_text(HEATED, encoding="utf-8")
    write_log(isobaric(), "log.csv", begin=3.0)
    return tmp_path


@pytest.fixture
def hot() -> str:
    """A log of a heated wire."""
    return write_log(heated(), "hot.csv")


def change(cells: Callable[[int, list[str]], list[str]]) -> Callable[[Rows], Rows]:
    """A change of every row of numbers."""
    return lambda rows: [rows[0], *(cells(k, row) for k, row in enumerate(rows[1:]))]


@cache
def fit_small() -> dict[str, Any]:
    """The usual fit; not to be changed."""
    return FIT.report(*SMALL)


# ---------------------------------------------------------------- what is found


def test_report_holds_the_truth_and_how_far_to_trust_it() -> None:
    found = fit_small()
    for name, true in fit_cases.TRUE.items():
        one = found["parameters"][name]
        assert one["low"] < true < one["high"]
        assert one["bounds"][0] < one["start"] < one["bounds"][1]
        assert not one["at_bound"]
    assert found["reason"] == "converged"
    assert {score["part"] for score in found["scores"]} == {"training", "held-out"}
    assert len(found["held_out"]["log"]) == 4
    assert found["identifiability"]["determined"]
    assert found["simulations"] > 0
    assert found["warnings"] == []


def test_text_names_parameters_scores_and_effort() -> None:
    text = FIT.fine(*SMALL)
    for words in ("A_s", "95 % interval", "°C", "held out", "are determined"):
        assert words in text
    assert "Residuals are white in 1 of 1" in text
    assert re.search(r"converged after \d+ runs \(\d+ with derivatives\)", text)


def test_command_may_be_named_and_the_others_still_answer() -> None:
    assert FIT.report("logs", *SMALL)["reason"] == "converged"
    assert "tangents" in FIT.fine("--help")
    assert "film coefficient" in FIT.fine("h", "--help")
    done = FIT("vibratoin", "log.csv")
    assert (done.exit_code, "No such command" in done.stderr) == (2, True)


def test_profile_brackets_the_truth() -> None:
    found = FIT.report(*SMALL, "--profile", "A_f")
    (profile,), linear = found["profiles"], found["parameters"]["A_f"]
    low, high = profile["interval"]
    assert low < fit_cases.TRUE["A_f"] < high
    assert high - low == pytest.approx(linear["high"] - linear["low"], rel=0.1)
    assert "A_f" in profile["sentence"]


def test_direction_that_the_data_leave_open_is_told_and_warned_of() -> None:
    """A stress that is prescribed moves with its section: only the quotient counts."""
    found = FIT.report(
        "log.csv", "--scenario", "isobaric.toml", "--free", "C_A=4..16 MPa/K,A_s,A_f", "--hold-out", "none"
    )
    assert not found["identifiability"]["determined"]
    assert any("The data determine only a combination" in w for w in found["warnings"])
    assert "weak" in FIT.fine(
        "log.csv", "--scenario", "isobaric.toml", "--free", "C_A=4..16 MPa/K,A_s,A_f", "--hold-out", "none"
    )


def test_parameter_that_ends_at_a_bound_is_marked() -> None:
    free = ("log.csv", "--scenario", "isobaric.toml", "--free", "A_s=60..68 degC,A_f")
    assert "at a bound" in FIT.fine(*free)
    warnings = FIT.report(*free)["warnings"]
    assert any("`A_s` ended on its upper bound, 68 degC" in warning for warning in warnings)


def test_columns_of_other_names_and_logs_without_headings() -> None:
    rows = read_rows("log.csv")
    other = [["time [s]", "chamber [degC]", "machine [MPa]", "gauge"], *rows[1:]]
    fit_cases.write_rows("other.csv", other)
    same = ("--set", "drive.waveform.column=chamber", "--set", "signals.command.column=machine")
    found = FIT.report("other.csv", *SMALL[1:], *same, "--column", "strain=gauge*0.01")
    right = fit_small()
    assert found["parameters"]["A_s"]["value"] == pytest.approx(right["parameters"]["A_s"]["value"], abs=1e-3)
    fit_cases.write_rows("bare.csv", [row[1:] for row in rows[1:]])
    named = ("--as=1=temperature[degC]", "--as=2=stress[MPa]", "--as=3=strain[%]")
    bare = FIT.report("bare.csv", *SMALL[1:], *named, "--interval", "1 s")
    assert bare["parameters"]["A_s"]["value"] == pytest.approx(right["parameters"]["A_s"]["value"], abs=1e-3)


def test_offsets_noise_loss_and_steps_are_passed_on() -> None:
    found = FIT.report(
        *SMALL,
        "--each",
        "offset",
        "--noise",
        "strain=0.05 %",
        "--loss",
        "huber",
        "--step",
        "0.5 s",
        "--starts",
        "1",
        "--hold-out",
        "25 %",
        "--set",
        "element.law.E_M=28 GPa",
    )
    assert "offset.strain@log" in found["parameters"]
    assert found["loss"] == "huber"
    assert len(found["held_out"]["log"]) == 1


def test_coordinate_search_takes_more_runs_for_the_same() -> None:
    few, many = fit_small(), FIT.report(*SMALL, "--method", "coordinate")
    assert many["method"] == "coordinate"
    assert many["simulations"] > 3 * few["simulations"]
    assert many["cost"] == pytest.approx(few["cost"], rel=0.05)


def test_missing_samples_are_passed_over_and_told() -> None:
    holes = change(lambda k, row: [*row[:3], "" if k % 5 == 0 else row[3]])
    found = FIT.report(edited("log.csv", holes), *SMALL[1:])
    assert found["parameters"]["A_s"]["low"] < fit_cases.TRUE["A_s"]
    assert any("of `strain` in record `edited` are missing" in note for note in found["notes"])
    assert found["uncertainty"]["samples"] < 90


def test_wire_that_is_heated_is_fitted_to_what_moves(hot: str) -> None:
    found = FIT.report(hot, *HEAT, "--step", "0.02 s")
    one = found["parameters"]["h"]
    assert abs(one["value"] - 80.0) < 0.75 * (one["high"] - one["low"])  # 3 standard errors; this noise takes 2 of them
    assert {score["output"] for score in found["scores"]} == {"position", "resistance"}


# ---------------------------------------------------------------- a fit file


def test_fit_file_stands_alone() -> None:
    text = 'scenario = "isobaric.toml"\nfree = ["A_s", "A_f"]\n[[record]]\nfile = "log.csv"\n'
    Path("fit.toml").write_text(text, encoding="utf-8")
    found = FIT.report("fit.toml", "--set", "element.law.E_M=28 GPa", "--starts", "1")
    assert list(found["parameters"]) == ["A_s", "A_f"]
    assert "the fit file sets it" in FIT.refused("fit.toml", "--free", "A_s")
    assert "lists its own records" in FIT.refused("fit.toml", "log.csv")


# ---------------------------------------------------------------- files


def test_material_can_be_used_at_once() -> None:
    text = FIT.fine(*SMALL, "--out", "mine.toml")
    assert "wrote mine.toml" in text
    mine = ISOBARIC.replace('"flexinol-90"', '"./mine.toml"')
    Path("mine_scenario.toml").write_text(mine, encoding="utf-8")
    scenario = load("mine_scenario.toml", log=isobaric())
    (value,) = [x.value for x in scenario.system.leaves() if x.path.endswith("law.A_s")]
    assert value == pytest.approx(fit_cases.TRUE["A_s"], abs=1.0)


def test_report_is_written_with_its_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """The figures of the second one are the same."""
    found = FIT.report(*SMALL, "--report", "page.md", "--profile", "A_f")
    assert found["files"][0] == "page.md"
    assert len(found["files"]) > 1
    for name in found["files"]:
        assert Path(name).stat().st_size > 0
    monkeypatch.setattr(html, "format_svg", lambda _: "<svg/>")
    assert "wrote page.html" in FIT.fine(*SMALL, "--report", "page.html")


def test_nothing_is_overwritten_without_force() -> None:
    Path("mine.toml").write_text("precious", encoding="utf-8")
    assert "use --force" in FIT.refused(*SMALL, "--out", "mine.toml")
    assert Path("mine.toml").read_text(encoding="utf-8") == "precious"
    FIT.fine(*SMALL, "--out", "mine.toml", "--force")
    assert "fitted" in Path("mine.toml").read_text(encoding="utf-8")
    Path("page.md").write_text("precious", encoding="utf-8")
    assert "use --force" in FIT.refused(*SMALL, "--report", "page.md")
    Path("page_figures").mkdir()
    Path("page.md").unlink()
    assert "`page_figures` is there already" in FIT.refused(*SMALL, "--report", "page.md")


@pytest.mark.parametrize(
    ("option", "file", "words"),
    [
        ("--out", "mine.yaml", "must end in .toml"),
        ("--report", "page.pdf", "must end in .md or .html"),
        ("--out", "nowhere/mine.toml", "There is no folder"),
        ("--resume", "nowhere/state.json", "There is no folder"),
    ],
)
def test_files_are_checked_before_the_search(option: str, file: str, words: str) -> None:
    assert words in FIT.refused(*SMALL, option, file)


# ---------------------------------------------------------------- interrupts


def interrupting(after: int, monkeypatch: pytest.MonkeyPatch) -> list[SearchNote]:
    """Let the search be interrupted, as by Ctrl-C, after so many notes; gives all notes."""
    notes: list[SearchNote] = []

    def tell(note: SearchNote) -> None:
        notes.append(note)
        if len(notes) == after:
            raise KeyboardInterrupt

    @contextmanager
    def bar(describe: Callable[[SearchNote], str]) -> Iterator[Tell | None]:
        yield tell

    monkeypatch.setattr(fit_logs, "show_search", bar)
    return notes


def test_interrupted_search_keeps_the_best_and_is_taken_up_again(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        notes = interrupting(5, patch)
        done = FIT(*SMALL, "--resume", "state.json", "--json")
    assert done.exit_code == 130
    found = json.loads(done.stdout)
    assert found["reason"] == "interrupted"
    assert any("interrupted" in warning for warning in found["warnings"])
    assert found["cost"] == pytest.approx(notes[-1].cost)
    kept = json.loads(Path("state.json").read_text(encoding="utf-8"))
    assert kept["values"] == pytest.approx(list(notes[-1].values))
    whole = fit_small()
    later = interrupting(1000, monkeypatch)
    resumed = FIT.report(*SMALL, "--resume", "state.json")
    assert resumed["reason"] == "converged"
    assert resumed["cost"] == pytest.approx(whole["cost"], rel=1e-4)
    assert later[0].cost == pytest.approx(notes[-1].cost)


def test_interrupted_profile_does_not_lose_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    from martensite.fit import profiling

    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(profiling, "profile_likelihood", interrupted)
    done = FIT(*SMALL, "--profile", "A_s", "--json")
    assert done.exit_code == 130
    found = json.loads(done.stdout)
    assert (found["reason"], found["profiles"]) == ("converged", [])


def test_state_of_another_problem_is_refused() -> None:
    FIT.fine(*SMALL, "--resume", "state.json")
    sentence = FIT.refused(*SMALL[:-1], "A_s", "--resume", "state.json")
    assert "state of another problem" in sentence
    Path("state.json").write_text("{}", encoding="utf-8")
    assert "does not hold the state" in FIT.refused(*SMALL, "--resume", "state.json")


# ---------------------------------------------------------------- bad input


def test_too_few_samples() -> None:
    assert "holds 5 measured numbers; a fit needs at least 8" in FIT.refused(
        edited("log.csv", lambda rows: rows[:6]), *SMALL[1:]
    )
    few = edited("log.csv", lambda rows: [rows[0], *rows[41:50]])
    assert "9 samples are too few for 9 free parameters" in FIT.refused(
        few, *SMALL[1:], "--free", "M_s,M_f,C_A,C_M,eps_L,E_M,E_A", "--hold-out", "none"
    )


def test_constant_column() -> None:
    still = edited("log.csv", change(lambda k, row: [*row[:3], "1.0"]))
    assert "Column `strain` of record `edited` is constant (0.01)" in FIT.refused(still, *SMALL[1:])


def test_swapped_columns(hot: str) -> None:
    swapped = edited(
        "log.csv", lambda rows: [["time [s]", "strain [%]", "stress [MPa]", "temperature [degC]"], *rows[1:]]
    )
    assert "swapped" in FIT.refused(swapped, *SMALL[1:])
    swapped = edited(hot, lambda rows: [["time [s]", "position [mm]", "current [A]", "resistance [ohm]"], *rows[1:]])
    sentence = FIT.refused(swapped, *HEAT, "--column", "position", "--hold-out", "25 %")
    assert "`current` and `position` exchanged" in sentence


def headed(old: str, new: str) -> Callable[[Rows], Rows]:
    """A change of one heading."""
    return lambda rows: [[new if cell == old else cell for cell in rows[0]], *rows[1:]]


def test_unit_that_is_off_by_a_thousand(hot: str) -> None:
    metres = edited(hot, headed("position [mm]", "position [m]"))
    sentence = FIT.refused(metres, *HEAT)
    assert "It looks 1000 times too large: a factor of 1000 would fit" in sentence
    share = edited("log.csv", headed("strain [%]", "strain"))
    assert "a factor of 100 would fit" in FIT.refused(share, *SMALL[1:])
    weak = edited(hot, headed("current [A]", "current [mA]"))
    assert "units wrong" in FIT.refused(weak, *HEAT)
    micro = edited(hot, headed("position [mm]", "position [um]"))
    assert "1000 times too small" in FIT.refused(micro, *HEAT)


def test_numbers_that_are_none() -> None:
    nothing = edited("log.csv", change(lambda k, row: [*row[:3], "nan"]))
    assert "holds 0 measured numbers" in FIT.refused(nothing, *SMALL[1:])
    endless = edited("log.csv", change(lambda k, row: [*row[:3], "inf" if k == 7 else row[3]]))
    assert "row 9, column `strain`: numbers must be finite" in FIT.refused(endless, *SMALL[1:])


def test_free_parameter_without_effect() -> None:
    sentence = FIT.refused("log.csv", "--scenario", "isobaric.toml", "--free", "A_s,rho_A")
    assert "Free parameter `rho_A` changes no compared output (`strain`)" in sentence
    assert "it moves `resistance`" in sentence
    sentence = FIT.refused("log.csv", "--scenario", "isobaric.toml", "--free", "A_s,strain_limit")
    assert "needs a log in which it comes to bear" in sentence


REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "no scenario": (("log.csv", "--step", "0.02 s"), "needs --scenario"),
    "no free": (("log.csv", "--scenario", "isobaric.toml"), "needs --free"),
    "unknown parameter": ((*SMALL[:-1], "B_s"), "no parameter `B_s`"),
    "unknown scenario": (("log.csv", "--scenario", "isobar.toml", "--free", "A_s"), "Did you mean `isobaric.toml`"),
    "unknown log": (("lag.csv", *SMALL[1:]), "Did you mean `log.csv`"),
    "unknown method": ((*SMALL, "--method", "newton"), "No method named"),
    "unknown loss": ((*SMALL, "--loss", "cauch"), "Did you mean `cauchy`"),
    "unknown record": ((*SMALL, "--hold-out", "lag"), "Did you mean `log`"),
    "unknown profile": ((*SMALL, "--profile", "M_s"), "No free parameter named `M_s`"),
    "unknown column": ((*SMALL, "--column", "strain=gauge"), "no column `gauge`"),
    "unknown output": ((*SMALL, "--column", "elongation=strain"), "No output named `elongation`"),
    "no noise": ((*SMALL, "--noise", "strain"), "is no noise"),
    "no draws": ((*SMALL, "--posterior", "0"), "must be at least 1"),
    "no starts": ((*SMALL, "--starts", "-1"), "must be at least 0"),
    "no step": ((*SMALL, "--step", "1 mm"), "Option `--step`"),
    "two scenarios": ((*SMALL, "--scenario", "isobaric.toml"), "1 logs have 2 scenarios"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_one_sentence(case: str) -> None:
    arguments, words = REFUSED[case]
    assert words in FIT.refused(*arguments)


# ---------------------------------------------------------------- run --log


def test_run_follows_a_log_and_compares_with_it() -> None:
    run = Command("run")
    found: dict[str, Any] = run.report("isobaric.toml", "--log", "log.csv", "--no-figure")
    assert found["duration"] == 120.0
    assert {one["quantity"] for one in found["comparison"]} == {"temperature", "stress", "strain"}
    refused = run.refused("isobaric.toml", "--no-figure", "--force")
    assert "follows a log" in refused
    part = run.report("isobaric.toml", "--log", "log.csv", "--no-figure", "--force", "--set", "run.duration=50 s")
    assert part["duration"] == 50.0
    assert part["comparison"][-1]["time"] <= 50.0


def test_run_with_a_log_that_nothing_follows_is_refused() -> None:
    fixed = HEATED.replace('waveform = "log"', 'waveform = { kind = "constant", level = "0.4 A" }')
    Path("fixed.toml").write_text(fixed + 'duration = "1 s"\n', encoding="utf-8")
    assert "`--log` has no effect" in Command("run").refused("fixed.toml", "--log", "log.csv")
