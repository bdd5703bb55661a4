"""The sweeps in the server's folder, the newest first: `{}` -> `{"sweeps": [{key, title, …}]}`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.sweeping.shelf import Shelf
from martensite.app.sweeping.stored import summary
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All sweeps, with how far each is."""
    shelf = Shelf(desk.folder)
    return {"sweeps": [summary(key, path) for key, path in shelf.all().items()]}
