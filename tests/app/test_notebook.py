"""The bench in a notebook: what the page asks the kernel, and what it is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from static_wire import TEXT

from martensite.app.documents import build_packaged
from martensite.app.messages import write_message
from martensite.app.notebook import BenchWidget
from martensite.app.routes import find_call
from martensite.app.worker import Desk
from martensite.base.errors import DataError, InputError
from martensite.scenario.scenario import Scenario

CHANGES = {"element.diameter": "0.12 mm"}


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, list[bytes]]]:
    """What widgets send to their pages."""
    found = list[tuple[Any, list[bytes]]]()
    monkeypatch.setattr(BenchWidget, "send", lambda self, content, buffers=None: found.append((content, buffers or [])))
    return found


@pytest.fixture
def widget(sent: list[Any]) -> BenchWidget:
    return build_packaged(TEXT).show_bench()


def ask(widget: BenchWidget, content: dict[str, Any]) -> None:
    """A message as the front end of a notebook sends it."""
    widget._handle_custom_msg(content, [])


def test_a_call_is_answered_as_on_the_server(widget: BenchWidget, sent: list[Any], tmp_path: Path) -> None:
    for name in ("form", "run"):
        ask(widget, {"id": name, "call": name, "request": {"text": TEXT, "changes": CHANGES}})
        meant = find_call(name)({"text": TEXT, "changes": CHANGES}, Desk(tmp_path))
        content, (data,) = sent.pop()
        found = json.loads(data)
        assert content == {"id": name}
        if name == "run":
            timed = ("seconds", "runtime")
            assert [found.pop(key) for key in timed] and [meant.pop(key) for key in timed]
        assert found == json.loads(write_message(meant))


def test_the_scenario_is_what_the_page_made_of_it(widget: BenchWidget) -> None:
    widget.set_state({"text": build_packaged(TEXT, CHANGES).text})
    assert widget.scenario.text == build_packaged(TEXT, CHANGES).text


def test_a_file_is_taken_away_by_its_key(widget: BenchWidget, sent: list[Any]) -> None:
    ask(widget, {"id": "1", "call": "export", "request": {"text": TEXT, "changes": {}, "what": "csv"}})
    ask(widget, {"id": "2", "file": json.loads(sent.pop()[1][0])["key"]})
    content, (data,) = sent.pop()
    assert content == {"id": "2"} and data.startswith(b"time")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ({"call": "fit", "request": {}}, "No call named `fit`"),
        ({"call": "run", "request": {"text": "duration = "}}, "TOML"),
        ({"asset": "../site.py"}, "No asset named"),
        ({"file": "../.."}, "no such file"),
        ({}, "needs `call`"),
    ],
)
def test_what_is_refused_is_a_sentence(
    widget: BenchWidget, sent: list[Any], content: dict[str, Any], sentence: str
) -> None:
    ask(widget, {"id": "1", **content})
    ((told, buffers),) = sent
    assert sentence in told["refused"] and told["id"] == "1" and not buffers


def test_a_scenario_with_files_of_its_own_is_refused() -> None:
    text = TEXT.replace("[drive", '[measured]\nfile = "/log.csv"\n\n[drive', 1)
    scenario = build_packaged(TEXT)
    object.__setattr__(scenario, "text", text)
    with pytest.raises(DataError, match=r"reads no file `/log\.csv`"):
        BenchWidget(scenario)


def test_without_the_extra_a_sentence_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "anywidget", None)
    scenario: Scenario = build_packaged(TEXT)
    with pytest.raises(InputError, match=r"pip install .*\[notebook\]'"):
        scenario.show_bench()
