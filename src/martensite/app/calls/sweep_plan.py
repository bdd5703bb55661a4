"""Check what is asked of a sweep: how many runs it has, or what is wrong with each field.

Request as of the job `sweep` -> {"faults": {field: sentence}, "runs": …, "command": …, …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.documents import scenario_of
from martensite.app.sweeping.asked import checked, how_of, wanted_of
from martensite.app.sweeping.shelf import slug
from martensite.app.sweeping.words import command
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Plan it, and run nothing."""
    scenario = scenario_of(request, desk)
    plan, faults = checked(scenario, request)
    if plan is None:
        return {"faults": faults, "runs": None, "command": "", "cautions": []}
    workers, step = how_of(request).workers, str(request.get("step") or "")
    words = command(slug(scenario.title), wanted_of(request), workers, step)
    return {
        "faults": faults,
        "runs": plan.size,
        "command": words,
        "cautions": plan.cautions(),
        "runtime": plan.course.runtime,
    }
