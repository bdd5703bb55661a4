"""One study: what it is, the scenarios to open, and its results if they were computed before.

{"name": …} -> {"name": …, "guide": […], "scenarios": [{title, text}], "results": {…} or null, …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.calls._studies import about, kept, named
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Describe it; nothing is computed."""
    study = named(request)
    scenarios = [{"title": title, "text": text} for title, text in study.scenarios().items()]
    return about(study) | {
        "parts": list(study.parts()),
        "scenarios": scenarios,
        "results": kept(study, desk.folder),
    }
