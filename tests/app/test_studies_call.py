"""Studies as the page asks for them: what they are, their claims part by part, what is kept."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from typescript import check_answer

from martensite.app.calls import studies
from martensite.app.worker import Desk
from martensite.base.errors import UnknownNameError
from martensite.scenario.scenario import read_scenario
from martensite.studies.base import AbstractStudy, Answer, Claim, load_study, study_names

QUICK = "wire-heating"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studies")


@pytest.fixture(scope="module")
def notes() -> list[dict[str, Any]]:
    return []


@pytest.fixture(scope="module")
def computed(folder: Path, notes: list[dict[str, Any]]) -> dict[str, Any]:
    desk = Desk(folder, lambda note: notes.append(dict(note)))
    answer = studies.compute_study({"name": QUICK}, desk)
    check_answer(answer, "studies", "Results")
    return answer


def test_every_study_is_listed_with_source_and_guide(bench: Bench) -> None:
    found = {one["name"]: one for one in bench.call("studies", {})["studies"]}
    assert list(found) == study_names()
    for one in found.values():
        assert one["sources"][0]["text"].endswith(".")
        assert len(one["guide"]) == 3, one["name"]
        assert one["figure"]
        assert sum(one["tally"].values()) > 0  # of what came with the study


def test_the_claims_are_those_of_the_study(computed: dict[str, Any]) -> None:
    assert computed["claims"] == [asdict(claim) for claim in load_study(QUICK).claims()]
    assert sum(computed["tally"].values()) == len(computed["claims"])
    assert computed["tally"]["misprint"] > 0 and computed["reports"]
    assert [one["heading"] for one in computed["digest"]][-1] == "use instead"


def test_what_came_with_a_study_is_shown_with_its_figure(tmp_path: Path) -> None:
    """All studies of the package come with numbers and figure, so that opening one computes nothing."""
    desk = Desk(tmp_path)
    found = studies.describe_study_page({"name": QUICK}, desk)["results"]
    check_answer(found, "studies", "Results")
    assert found["made_by"].startswith("martensite ")
    for one in studies.list_studies({}, desk)["studies"]:
        assert one["drawn"] == studies.SHIPPED, one["name"]
        drawn = studies.read_figure({"name": one["name"]}, desk)["svg"]
        assert drawn.rstrip().endswith("</svg>") and len(drawn) < 500_000, one["name"]


def test_a_computed_figure_replaces_the_shipped_one(computed: dict[str, Any], folder: Path) -> None:
    desk = Desk(folder)
    svg = studies.read_figure({"name": QUICK}, desk)["svg"]
    assert svg == desk.files.path(computed["figure"]).read_text("utf-8")
    assert svg != studies.read_figure({"name": "migaone"}, desk)["svg"]


def test_notes_tell_the_part_and_bring_its_claims(computed: dict[str, Any], notes: list[dict[str, Any]]) -> None:
    parts = list(load_study(QUICK).parts())
    assert [note["doing"] for note in notes] == [*parts, "the figure"]
    assert [claim for note in notes for claim in note["claims"]] == computed["claims"]


def test_results_are_kept_until_the_figure_is_gone(computed: dict[str, Any], folder: Path) -> None:
    desk = Desk(folder)
    assert studies.describe_study_page({"name": QUICK}, desk)["results"] == computed
    figure = folder / computed["figure"] / f"{QUICK}.svg"
    assert b"<svg" in figure.read_bytes()[:1000]
    figure.rename(figure.with_name("away"))
    figure.parent.rename(folder / "elsewhere")
    assert studies.describe_study_page({"name": QUICK}, desk)["results"]["figure"] == studies.SHIPPED
    (folder / "elsewhere").rename(figure.parent)
    figure.with_name("away").rename(figure)
    assert studies.describe_study_page({"name": QUICK}, desk)["results"] == computed


@pytest.mark.parametrize("damaged", ["", "[]", "{}", '{"figure": 1, "missing": []}', "\x00"])
def test_a_damaged_file_is_as_none(tmp_path: Path, damaged: str) -> None:
    one = load_study(QUICK)
    studies.write_results(one, tmp_path, {"figure": "0" * 16, "missing": []})
    (file,) = (tmp_path / "studies").iterdir()
    file.write_text(damaged)
    assert studies.read_results(one, tmp_path) is None


def test_results_hold_for_the_data_that_were_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MARTENSITE_DATA", str(tmp_path / "none"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "none"))
    one = load_study("electrothermal-staircase")
    (absent,) = studies.list_missing_data(one)
    assert absent["fetch"] == "martensite data fetch flexinol-electrothermal"
    (tmp_path / ("0" * 16)).mkdir()
    (tmp_path / ("0" * 16) / "figure.svg").touch()
    studies.write_results(one, tmp_path, {"figure": "0" * 16, "missing": [absent["name"]]})
    assert studies.read_results(one, tmp_path)
    monkeypatch.setattr(studies, "is_here", lambda key: True)
    assert studies.read_results(one, tmp_path) is None


def test_scenarios_stand_by_themselves(bench: Bench, tmp_path: Path) -> None:
    texts = [text for name in study_names() for text in load_study(name).scenarios().values()]
    assert len(texts) == 8
    for text in texts:
        assert read_scenario(text, tmp_path / "scenario.toml").samples <= 200_001
    page = bench.call("study_page", {"name": "migaone"})
    (only,) = page["scenarios"]
    assert bench.call("run", {"text": only["text"]})["title"] == only["title"]


def test_what_is_no_study_is_refused(bench: Bench) -> None:
    for name in ("study_page", "study"):
        assert "Did you mean `migaone`" in bench.call(name, {"name": "migaon"})["error"]
        assert "`name`" in bench.call(name, {})["error"]
        assert "error" in bench.call(name, {"name": "../../etc/passwd"})
    with pytest.raises(UnknownNameError):
        studies.load_named_study({"name": "/tmp"})


def test_a_study_without_parts_is_one_part() -> None:
    class Own(AbstractStudy):
        def claims(self) -> list[Claim]:
            return [Claim("a", "a number", "here", None, 1.0, "1", None, "recovery", "none")]

    assert Own().compute() == Own().find_answer() == Answer(Own().claims(), [])
    with pytest.raises(NotImplementedError):
        AbstractStudy().claims()
