"""The scenario of a request, a text with changes by dotted path; and packaged scenarios.

Links can contain scenarios from unknown authors. So a scenario on the bench reads only files next to the packaged
scenarios, and excessive runs are refused.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
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
    """Build the scenario of a request, `text` with `changes`."""
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
    """Return the minimum number of steps of a run."""
    step = scenario.system.sample_time() or scenario.step or longest_step(scenario.system)
    return scenario.duration / step


def check_files(text: str, changes: Request) -> None:
    """Refuse files outside the folder of packaged scenarios."""
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
    """Return name and text of each independent scenario, the new one of the bench first."""
    data = "flexinol-isobaric/"  # measured by others, not packaged
    others = {n: text for n, text in _list_texts(FOLDER) if data not in text and not _is_following(text)}
    return {"dead_weight": NEW.read_text("utf-8"), **others}


def list_following() -> dict[str, str]:
    """Return name and text of each scenario that follows a log."""
    return {name: text for name, text in _list_texts(FOLDER) if _is_following(text)}


def describe_scenarios(texts: Mapping[str, str]) -> JsonTable:
    """Return the scenarios with their titles for the page."""
    entries = [
        {"name": name, "title": str(tomllib.loads(text).get("title", name)), "text": text}
        for name, text in texts.items()
    ]
    return {"scenarios": entries}


def build_packaged(text: str, changes: Request | None = None, log: Record | None = None) -> Scenario:
    """Return the scenario of a text, with files next to the packaged ones."""
    from martensite.scenario.scenario import read_scenario

    return read_scenario(text, FOLDER / "scenario.toml", changes, log=log)


@cache
def _list_texts(folder: Path) -> list[tuple[str, str]]:
    """Return name and text of all scenarios except fits."""
    texts = [(path.stem, path.read_text("utf-8")) for path in sorted(folder.glob("*.toml"))]
    return [(name, text) for name, text in texts if "scenario" not in tomllib.loads(text)]


def _is_following(text: str) -> bool:
    return f'"{LOG}"' in text
