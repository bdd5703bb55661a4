"""All that is drawn of a sweep, as far as it is made.

{"key": …} -> {"layout": {…}, "points": {"rows", "status", "columns"}, "done", "runs", "state", …}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.messages import wanted
from martensite.app.sweeping.drawn import Drawn
from martensite.app.sweeping.live import named
from martensite.app.sweeping.shelf import Shelf, slug
from martensite.app.sweeping.stored import asked_of, summary
from martensite.app.sweeping.words import command
from martensite.app.worker import Desk
from martensite.design.sweep.store import Store
from martensite.design.sweep.summary import statuses

NAMED = 5


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Layout and points of a store."""
    key = wanted(request, "key", str)
    path = Shelf(desk.folder).path(key)
    drawn = Drawn(Store(path))
    counts, rows = statuses(drawn.store, NAMED)
    asked = asked_of(drawn.spec)
    step = f"{asked.step!r} s" if asked.step else ""
    return {
        **summary(key, path),
        "layout": drawn.layout(),
        "points": drawn.points(drawn.store.made()),
        "counts": named(counts),
        "failed": [[int(status), counts[status], first] for status, first in sorted(rows.items())],
        "command": command(slug(drawn.spec["title"]), asked, step=step),
    }
