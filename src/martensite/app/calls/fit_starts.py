"""Scenarios that come with the package and follow a log.

{} -> {"scenarios": [{name, title, text}]}
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import FOLDER
from martensite.app.worker import Desk
from martensite.io.recorded import LOG


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All of them, with their titles."""
    found: list[dict[str, str]] = []
    for path in sorted(FOLDER.glob("*.toml")):
        text = path.read_text("utf-8")
        document = tomllib.loads(text)
        if "scenario" not in document and f'"{LOG}"' in text:
            title = str(document.get("title", path.stem))
            found.append({"name": path.stem, "title": title, "text": text})
    return {"scenarios": found}
