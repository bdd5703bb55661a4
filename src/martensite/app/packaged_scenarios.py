"""The scenarios that come with the package."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from martensite.app.messages import JsonTable, Request
from martensite.scenario.examples import EXAMPLES as FOLDER
from martensite.scenario.recorded_waveforms import LOG

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario
    from martensite.signals.records import Record


def list_standalone() -> dict[str, str]:
    """Name and text of every scenario that stands by itself."""
    data = "flexinol-isobaric/"  # measured by others, not packaged
    return {n: text for n, text in _list_texts() if data not in text and not _is_following(text)}


def list_following() -> dict[str, str]:
    """Name and text of every scenario that follows a log."""
    return {name: text for name, text in _list_texts() if _is_following(text)}


def describe_scenarios(texts: Mapping[str, str]) -> JsonTable:
    """Scenarios as the page lists them, with their titles."""
    found = [
        {"name": name, "title": str(tomllib.loads(text).get("title", name)), "text": text}
        for name, text in texts.items()
    ]
    return {"scenarios": found}


def build_packaged(text: str, changes: Request | None = None, log: Record | None = None) -> Scenario:
    """The scenario in a text; files that it names lie beside the packaged ones."""
    from martensite.scenario.scenario import read_scenario

    return read_scenario(text, FOLDER / "scenario.toml", changes, log=log)


def _list_texts() -> Iterator[tuple[str, str]]:
    """Name and text of all, without what is a fit of one."""
    for path in sorted(FOLDER.glob("*.toml")):
        text = path.read_text("utf-8")
        if "scenario" not in tomllib.loads(text):
            yield path.stem, text


def _is_following(text: str) -> bool:
    return f'"{LOG}"' in text
