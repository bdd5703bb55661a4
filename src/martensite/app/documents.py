"""The scenario that a request means: a text, and changes to it by dotted path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import FOLDER
from martensite.app.messages import wanted
from martensite.app.worker import Desk
from martensite.errors import ParameterError
from martensite.io.scenario import Scenario, read

LONGEST = 2**20
MOST_SAMPLES = 200_001


def scenario_of(request: Mapping[str, Any], desk: Desk) -> Scenario:
    """Build the scenario of a request, `text` with `changes`.

    Raises:
        InputError: the text is none, or a change is wrong, or it has too many samples to be shown.
    """
    text, changes = wanted(request, "text", str), wanted(request, "changes", dict, {})
    if len(text) > LONGEST:
        raise ParameterError(f"The scenario has {len(text):,} letters; at most {LONGEST:,} do.")
    scenario = read(text, FOLDER / "scenario.toml", changes or None)
    if scenario.samples > MOST_SAMPLES:
        raise ParameterError(
            f"[run] `samples` is {scenario.samples:,}; the bench shows at most {MOST_SAMPLES:,}. "
            "Use `martensite run` for more."
        )
    return scenario
