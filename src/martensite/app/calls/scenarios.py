"""The scenarios that come with the package: `{}` -> `{"scenarios": [{name, title, text}]}`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import scenarios
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All scenarios, with their titles."""
    found = [
        {"name": name, "title": str(tomllib.loads(text).get("title", name)), "text": text}
        for name, text in scenarios().items()
    ]
    return {"scenarios": found}
