"""Scenarios that come with the package and follow a log.

{} -> {"scenarios": [{name, title, text}]}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.gallery import followers, listed
from martensite.app.worker import Desk


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """All of them, with their titles."""
    return listed(followers())
