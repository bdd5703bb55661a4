"""The model that a page steps by hand, as the server makes it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from node_js import WEB

from martensite.actuators.mechanisms.base import MECHANISMS
from martensite.app.calls.models import build_model
from martensite.app.documents import list_standalone
from martensite.app.static_site import stepped_model
from martensite.app.worker import Desk
from martensite.base.errors import InputError

HANDLE = re.compile(r'^  "?([a-z-]+)"?: \{ path: "mechanism\.(\w+)"', re.MULTILINE)
DESK = Desk(Path(), lambda note: None)


def ask(name: str, *paths: str, more: str = "") -> dict[str, object]:
    return dict(build_model({"text": list_standalone()[name] + more, "changes": {}, "paths": list(paths)}, DESK))


def test_a_model_goes_out_with_its_module_and_the_number_of_its_handle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stepped_model, "_encode_module", lambda source: source.march)
    found = ask("dead_weight", "mechanism.mass", more="# another text\n")
    assert found["module"] == "adaptive"
    scenario = found["scenario"]
    assert isinstance(scenario, dict)
    assert [one["path"] for one in scenario["controls"]] == ["mechanism.mass"]
    assert [(one["name"], one["port"], one["how"]["unit"]) for one in scenario["places"]["drives"]] == [
        ("drive", "element", "A")
    ]


def test_a_loop_goes_out_with_its_reference_and_the_load_that_pulls_at_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stepped_model, "_encode_module", lambda source: source.march)
    found = ask("closed_loop", "mechanism.preload", more="# another text\n")
    assert found["module"] == "given"
    scenario = found["scenario"]
    assert isinstance(scenario, dict)
    assert [one["path"] for one in scenario["controls"]] == ["mechanism.preload"]
    assert scenario["places"]["drives"][0]["name"] == "reference"


def test_what_does_not_run_by_hand_says_why() -> None:
    with pytest.raises(InputError, match="sets its initial state"):
        ask("dead_weight", more='\n[initial]\ntemperature = "40 degC"\n')


def test_handles_are_numbers_of_mechanisms() -> None:
    text = (WEB / "src" / "touch" / "handles.ts").read_text("utf-8")
    found = HANDLE.findall(text)
    assert len(found) >= 5
    for kind, name in found:
        assert name in MECHANISMS[kind].__annotations__, kind
