"""Delete a sweep: `{"key": …}` -> `{}`. One that is running is refused."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.messages import wanted
from martensite.app.sweeping.shelf import Shelf
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Remove its store."""
    Shelf(desk.folder).delete(wanted(request, "key", str))
    return {}
