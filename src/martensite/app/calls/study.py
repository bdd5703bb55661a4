"""Compute a study: its claims, part by part, and its figure. Long work.

{"name": …} -> {"name": …, "claims": […], "tally": {…}, "figure": key of a file, …}

Notes: {"doing": words, "done": parts, "of": parts and the figure, "claims": those of the part
that is over}. The results are kept in the folder.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from martensite.app.calls._studies import keep, missing, named, tally
from martensite.app.drawer import Drawer
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Compute it, whatever was kept."""
    study, begun = named(request), time.perf_counter()
    claims: list[dict[str, Any]] = []
    parts = study.parts()
    new: list[dict[str, Any]] = []
    for done, (words, part) in enumerate(parts.items()):
        desk.tell({"doing": words, "done": done, "of": len(parts) + 1, "claims": new})
        new = [claim.to_dict() for claim in part()]
        claims += new
    desk.tell({"doing": "the figure", "done": len(parts), "of": len(parts) + 1, "claims": new})
    key, path = Drawer(desk.folder).place(f"{study.key}.svg")
    study.figure(path)
    results = {
        "name": study.key,
        "claims": claims,
        "tally": tally(claims),
        "figure": key,
        "missing": [one["name"] for one in missing(study)],
        "seconds": time.perf_counter() - begun,
    }
    keep(study, desk.folder, results)
    return results
