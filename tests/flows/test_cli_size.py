"""`martensite size`: the table, the words, JSON, the scenario it writes, and what it refuses."""

from __future__ import annotations

import json
import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from command import Command

SMALL = ("--pull", "0.5 N", "--stroke", "3 mm", "--rate", "0.2 Hz", "--supply", "5 V")
SIZE, RUN = Command("size"), Command("run")
fine, refused = SIZE.fine, SIZE.refused


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@cache
def report() -> dict[str, Any]:
    """What the command says in JSON."""
    return json.loads(fine(*SMALL, "--ambient", "30 degC", "--alloy", "90", "--json"))


def rows(text: str) -> list[str]:
    """Lines of the table that stand for a wire."""
    return [line for line in text.splitlines() if line.strip()[:1].isdigit() and ".." in line]


def test_table_words_and_a_scenario_that_runs(folder: Path) -> None:
    text = fine(*SMALL, "--alloy", "90", "--out", "wire.toml")
    assert text.startswith(f"{len(rows(text))} of 12 wires meet ")
    assert rows(text)[0].split()[:3] == ["1*", "0.10", "90"]
    assert "Return spring: preload 0.5594 N" in text
    assert "Recalled or interpolated values of the catalogue: diameter, resistance." in text
    assert "Assumed or recalled values of flexinol-90:" in text
    assert "--all lists them" in text
    assert "wrote wire.toml" in text
    run = RUN.report("wire.toml", "--no-figure")
    assert run["stroke"] == pytest.approx(3e-3, rel=0.05)
    assert run["warnings"] == []
    assert "is there already" in refused(*SMALL, "--out", "wire.toml")


def test_coils_stand_in_a_table_of_a_terminal_and_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    asked = ("--element", "coil", "--pull", "1 N", "--stroke", "30 mm", "--rate", "0.05 Hz", "--supply", "5 V")
    text = fine(*asked, "--alloy", "90", "--out", "coil.toml")
    shown = rows(text)
    assert shown and all(len(line) <= 80 for line in shown)
    coils, turns = (int(shown[0].split()[place]) for place in (3, 6))
    assert f"{coils} parallel coils of Flexinol {shown[0].split()[1]} mm, 90 °C: {turns} turns" in text
    assert "wound and annealed" in text
    run = RUN.report("coil.toml", "--no-figure")
    assert run["stroke"] == pytest.approx(0.03, rel=0.05)
    assert run["warnings"] == []


def test_every_size_has_a_reason_or_does() -> None:
    found = report()["candidates"]
    assert len(found) == 12
    assert all(one["feasible"] != bool(one["reasons"]) for one in found)


def test_json_is_in_si_and_names_the_chosen_one() -> None:
    found = report()
    assert found["chosen"] == 1
    assert found["request"]["ambient"] == pytest.approx(303.15)
    assert found["request"]["stroke"] == pytest.approx(3e-3)
    best = found["candidates"][0]
    assert best["length"] == pytest.approx(0.075)
    assert best["drive"]["power"] == pytest.approx(best["drive"]["current"] ** 2 * best["strand_resistance"])
    assert best["strand"]["heating"] + best["strand"]["cooling"] <= 5.0
    assert found["files"] == []


def test_no_wire_at_all_is_said_with_the_nearest_and_what_would_fit(folder: Path) -> None:
    done = SIZE(*SMALL[:4], "--rate", "30 Hz", "--supply", "5 V", "--strands", "2", "--alloy", "90", "--out", "x.toml")
    assert (done.exit_code, done.stderr) == (1, "error: No wire meets the request, so `x.toml` was not written.\n")
    assert not (folder / "x.toml").exists()
    text = done.stdout
    assert "No wire meets the request" in text
    assert len(rows(text)) == 5
    assert max(map(len, rows(text))) <= 100
    assert "Wire 1 rejected: " in text
    options = re.search(r"Change that fits: (.*): 0\.\d+ mm", text)
    assert options is not None
    changed = shlex.split(options[1])
    asked = {"--rate": "30 Hz", "--supply": "5 V", "--strands": "2"}
    asked |= dict(zip(changed[::2], changed[1::2], strict=True))
    assert len(asked) == 3
    fine(*SMALL[:4], *(word for pair in asked.items() for word in pair), "--alloy", "90")


def test_limits_of_the_material_are_kept_unless_told_otherwise() -> None:
    bold = *SMALL, "--alloy", "90", "--stress", "300 MPa"
    reasons = [one["reasons"] for one in json.loads(SIZE(*bold, "--json").stdout)["candidates"]]
    assert any("above the maker's 172 MPa" in text for each in reasons for text in each)
    told = SIZE.report(*bold, "--no-limits")
    assert told["request"]["limits"] == "ignore"
    warned = [one for one in told["candidates"] if any("above the maker's 172 MPa" in text for text in one["warnings"])]
    assert any(one["feasible"] for one in warned)


def test_a_picked_wire_that_does_not_meet_the_request_is_not_saved(folder: Path) -> None:
    """The truth: the first reason of the candidates that the command itself lists as rejected."""
    words = *SMALL, "--alloy", "90"
    listed = SIZE.report(*words)["candidates"]
    place, reasons = next((k, one["reasons"]) for k, one in enumerate(listed, 1) if not one["feasible"])
    done = SIZE(*words, "--pick", str(place), "--out", "w.toml")
    assert done.exit_code == 1 and not (folder / "w.toml").exists()
    first = f"Wire {place} does not meet the request: {reasons[0]}; not saved. --save-anyway saves it."
    assert " ".join(done.stdout.split()).startswith(" ".join(first.split()))
    assert "has no effect, since nothing is saved" in SIZE.refused(*words, "--save-anyway")
    fine(*words, "--pick", str(place), "--out", "w.toml", "--save-anyway")
    assert (folder / "w.toml").exists()


@pytest.mark.slow
def test_another_wire_takes_the_place_of_the_first(folder: Path) -> None:
    assert "too slow" in fine(*SMALL, "--alloy", "90", "--all", "--out", "wire.toml")
    before = (folder / "wire.toml").read_text(encoding="utf-8")
    fine(*SMALL, "--alloy", "90", "--out", "wire.toml", "--force", "--pick", "2")
    assert (folder / "wire.toml").read_text(encoding="utf-8") != before


@pytest.mark.slow
def test_written_bundle_runs(folder: Path) -> None:
    arguments = ("--pull", "2 N", "--stroke", "3 mm", "--rate", "0.2 Hz", "--supply", "12 V")
    report = json.loads(fine(*arguments, "--alloy", "90", "--json", "--out", "b.toml"))
    assert report["candidates"][0]["count"] > 1
    assert 'kind = "bundle"' in (folder / "b.toml").read_text(encoding="utf-8")
    run = RUN.report("b.toml", "--no-figure")
    assert run["stroke"] == pytest.approx(3e-3, rel=0.05)
    work = report["candidates"][0]["work_force"]
    assert run["columns"]["force"]["highest"] == pytest.approx(work, rel=0.05)


REFUSED = [
    (("--pull", "8 N"), "Option `--stroke`, `--rate`, `--supply` is needed"),
    ((*SMALL, "--ambient", "22"), "Option `--ambient`: `22` has no unit"),
    ((*SMALL, "--current-limit", "5 mm"), "Option `--current-limit`: The unit `mm`"),
    (("--pull", "8 kg", *SMALL[2:]), "Option `--pull`: The unit `kg` cannot be converted to `N`"),
    (("--pull", "-8 N", *SMALL[2:]), "Parameter `force`"),
    ((*SMALL, "--strain", "40 %"), "Parameter `strain`"),
    ((*SMALL, "--stress", "60 MPa"), "the return of the wire takes"),
    ((*SMALL, "--bias", "magnet"), "Option `bias`"),
    ((*SMALL, "--alloy", "80"), "Option `alloy`"),
    ((*SMALL, "--out", "wire.txt"), "must end in .toml"),
    ((*SMALL, "--out", "nowhere/wire.toml"), "no folder"),
    pytest.param((*SMALL, "--alloy", "90", "--pick", "13"), "between 1 and 12", marks=pytest.mark.slow),
    (("--catalogue", "--pull", "8 N"), "Option `--pull` has no effect with --catalogue"),
    (("--catalogue", "--bias", "weight"), "Option `--bias` has no effect with --catalogue"),
    (("--catalogue", "--all"), "Option `--all` has no effect with --catalogue"),
    (("--catalogue", "--alloy", "80"), "Option `alloy`"),
    ((*SMALL, "--strands", "0"), "between 1 and 1000, but is 0."),
]


@pytest.mark.parametrize(("arguments", "sentence"), REFUSED)
def test_bad_input_is_refused_in_one_sentence(folder: Path, arguments: tuple[str, ...], sentence: str) -> None:
    assert sentence in refused(*arguments)
    assert list(folder.iterdir()) == []


@pytest.mark.slow
def test_catalogue_is_compared_with_the_model() -> None:
    report = json.loads(fine("--catalogue", "--json"))
    assert len(report["rows"]) == 24
    for row in report["rows"]:
        assert row["current_cell"]["kind"] in ("datasheet", "recalled")
        assert row["current_ratio"] == pytest.approx(row["current"] / row["current_cell"]["value"])
    shares = [row["loss_share"] for row in report["rows"] if row["alloy"] == "70"]
    assert shares == sorted(shares, reverse=True)
    assert set(report["spread"]) == {"70", "90"}


def test_catalogue_table_marks_recalled_cells_and_ends_with_the_spread() -> None:
    text = fine("--catalogue", "--alloy", "90")
    assert "! 150" in text
    assert " 410" in text and "! 410" not in text
    assert max(map(len, text.splitlines()[2:15])) <= 100
    assert "90 °C, current: model/catalogue" in text
    assert "No parameter is fitted to a size" in text


def test_a_life_keeps_to_what_a_source_names_and_says_what_none_does() -> None:
    assert "of 250 MPa" in fine(*SMALL, "--alloy", "90", "--stress", "250 MPa")
    text = fine(*SMALL, "--alloy", "90", "--stress", "250 MPa", "--life", "1e5")
    assert "of 172.4 MPa" in text
    assert "Life: 100,000 cycles requested" in text
    assert "nitinolactuators.com" in text and "This is no prediction" in text
    for more in (("--life", "1e7"), ("--life", "1e5", "--element", "coil"), ("--life", "1e5", "--no-limits")):
        assert "no source covers more" in refused(*SMALL, *more)
