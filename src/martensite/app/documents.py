"""The scenario that a request means, a text with changes by dotted path; and those of the package.

Whoever writes an address of the bench writes the scenario in it. So a scenario on the bench reads
no files but those that lie beside the packaged scenarios, and what would take without end is
refused before it is begun.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from martensite.app.messages import JsonTable, Request, require_entry
from martensite.app.worker import Desk
from martensite.base.errors import DataError, ParameterError
from martensite.base.files import toml_document
from martensite.scenario.examples import EXAMPLES as FOLDER
from martensite.scenario.recorded_waveforms import LOG
from martensite.scenario.scenario import Scenario
from martensite.simulate.api import longest_step

if TYPE_CHECKING:
    from martensite.signals.records import Record

NEW = Path(__file__).parent / "forms" / "new.toml"
"""A new scenario of the bench."""
LONGEST_TEXT = 2**20
MOST_SAMPLES = 200_001
MOST_STEPS = 2_000_000


def read_request_scenario(request: Request, desk: Desk) -> Scenario:
    """Build the scenario of a request, `text` with `changes`.

    Raises:
        InputError: the text is none, or a change is wrong, or it names files elsewhere, or it has
            too many samples or steps to be shown.
    """
    text, changes = require_entry(request, "text", str), require_entry(request, "changes", dict, {})
    if len(text) > LONGEST_TEXT:
        raise ParameterError(f"The scenario has {len(text):,} letters; at most {LONGEST_TEXT:,} do.")
    check_files(text, changes)
    scenario = build_packaged(text, changes or None)
    if count_steps(scenario) > MOST_STEPS:
        raise ParameterError(
            f"This run needs more than {MOST_STEPS:,} steps, the most that the bench makes. Make "
            "it shorter or its longest step larger, or use `martensite run`."
        )
    if scenario.samples > MOST_SAMPLES:
        raise ParameterError(
            f"[run] `samples` is {scenario.samples:,}; the bench shows at most {MOST_SAMPLES:,}. "
            "Use `martensite run` for more."
        )
    return scenario


def count_steps(scenario: Scenario) -> float:
    """Return the steps that a run has at least."""
    step = scenario.system.sample_time() or scenario.step or longest_step(scenario.system)
    return scenario.duration / step


def check_files(text: str, changes: Request) -> None:
    """Refuse files that do not lie beside the packaged scenarios.

    Raises:
        DataError: a scenario, or a change to it, names one, or is not TOML.
    """
    for name in (*_list_files(toml_document(text), ""), *_list_files(changes, "")):
        odd = any(letter in name for letter in "\0\\:")
        if odd or not (FOLDER / name).resolve().is_relative_to(FOLDER.resolve()):
            raise DataError(
                f"The bench reads no file `{name[:80]}`: a scenario on the bench reads only files beside "
                "the packaged ones. Use `martensite run` for a scenario with its own files."
            )


def _list_files(node: Any, path: str) -> Iterator[str]:
    if isinstance(node, dict):
        for key, value in cast("JsonTable", node).items():
            yield from _list_files(value, f"{path}.{key}")
    elif isinstance(node, list):
        for value in cast("list[Any]", node):
            yield from _list_files(value, path)
    elif isinstance(node, str):
        last = path.rpartition(".")[2]
        own = node.endswith(".toml") or "/" in node or "\\" in node
        if (last == "file" and not node.startswith("data:")) or (last == "material" and own):
            yield node


def list_standalone() -> dict[str, str]:
    """Return the name and text of every scenario that stands by itself, first the one that is new on the bench."""
    data = "flexinol-isobaric/"  # measured by others, not packaged
    others = {n: text for n, text in _list_texts() if data not in text and not _is_following(text)}
    return {"dead_weight": NEW.read_text("utf-8"), **others}


def list_following() -> dict[str, str]:
    """Return the name and text of every scenario that follows a log."""
    return {name: text for name, text in _list_texts() if _is_following(text)}


def describe_scenarios(texts: Mapping[str, str]) -> JsonTable:
    """Return the scenarios as the page lists them, with their titles."""
    found = [
        {"name": name, "title": str(tomllib.loads(text).get("title", name)), "text": text}
        for name, text in texts.items()
    ]
    return {"scenarios": found}


def build_packaged(text: str, changes: Request | None = None, log: Record | None = None) -> Scenario:
    """Return the scenario in a text; files that it names lie beside the packaged ones."""
    from martensite.scenario.scenario import read_scenario

    return read_scenario(text, FOLDER / "scenario.toml", changes, log=log)


def _list_texts() -> Iterator[tuple[str, str]]:
    """Yield the name and text of all, without what is a fit of one."""
    for path in sorted(FOLDER.glob("*.toml")):
        text = path.read_text("utf-8")
        if "scenario" not in tomllib.loads(text):
            yield path.stem, text


def _is_following(text: str) -> bool:
    return f'"{LOG}"' in text
