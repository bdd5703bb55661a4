"""The scenarios that come with the package: `{}` -> `{"scenarios": [{name, title, text}]}`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import listed, scenarios
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All that stand by themselves."""
    return listed(scenarios())
