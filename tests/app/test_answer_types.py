"""Answers of calls are what the page's TypeScript says they are: all that it declares is there."""

from pathlib import Path
from typing import Any

import pytest
from typescript import check_answer

from martensite.app.documents import list_standalone
from martensite.app.routes import find_call
from martensite.app.worker import Desk

POWER = list_standalone()["constant_power"]
PLAN = {"over": ["mechanism.mass=0.1..0.2 kg:3"], "measures": ["stroke"]}


def ask(call: str, **request: Any) -> Any:
    return find_call(call)(request, Desk(Path()))


@pytest.mark.parametrize("name", ["finger", "three_rails", "closed_loop_guarded"])
def test_a_run_and_its_form(name: str) -> None:
    text = list_standalone()[name]
    check_answer(ask("run", text=text), "lib", "RunAnswer")
    check_answer(ask("form", text=text), "form", "ScenarioForm")


def test_sweeps_and_sizings_before_they_are_begun() -> None:
    check_answer(ask("sweep_form", text=POWER), "sweep", "Form")
    check_answer(ask("sweep_plan", text=POWER, **PLAN), "sweep", "Plan")
    check_answer(ask("sweep_plan", text=POWER, **PLAN, seed=-1), "sweep", "Plan")
    check_answer(ask("size_form", fields={"force": "8 N", "stroke": "x"}), "size", "Form")


def test_studies() -> None:
    listed = ask("studies")["studies"]
    for one in listed:
        check_answer(one, "studies", "Listed")
    check_answer(ask("study_page", name=listed[0]["name"]), "studies", "StudyPage")


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"title": 1}, "Form.title is 1, no string"),
        ({"designs": [{"name": "grid"}]}, "Form.designs.0.about is missing"),
        ({"usual": None}, "Form.usual is None, no list"),
    ],
)
def test_another_answer_is_noticed(change: dict[str, Any], fault: str) -> None:
    answer = ask("sweep_form", text=POWER)
    with pytest.raises(AssertionError, match=fault):
        check_answer({**answer, **change}, "sweep", "Form")
    del answer["title"]
    with pytest.raises(AssertionError, match=r"Form\.title is missing"):
        check_answer(answer, "sweep", "Form")
