"""All studies, each with the tally of its verdicts if it was computed before.

{} -> {"studies": [{"name": …, "title": …, "sources": […], "tally": {…} or null, …}]}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.calls._studies import about, kept
from martensite.app.worker import Desk
from martensite.studies.base import load_study, study_names


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """List them."""
    found: list[dict[str, Any]] = []
    for study in map(load_study, study_names()):
        results = kept(study, desk.folder)
        found.append(about(study) | {"tally": results["tally"] if results else None})
    return {"studies": found}
