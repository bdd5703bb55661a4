"""The form of a sizing: its fields, and what is wrong with what is typed into them.

{"fields": {"force": "8 N", …}} -> {"fields": [declared…], "refused": {name: sentence},
                                    "contradiction": sentence or "", "example": {…}}

Fields that there are not, as of an old link, are named in "unknown" and passed over.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from martensite.app.calls._sizing import EXAMPLE, fields, read, typed
from martensite.app.messages import wanted
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.base.parameters import REQUIRED
from martensite.design.sizing.request import WireRequest


def answer(request: Mapping[str, Any], desk: Desk) -> dict[str, Any]:
    """Read the fields; nothing is simulated."""
    given = wanted(request, "fields", dict, {})
    known = {name: text for name, text in given.items() if name in WireRequest.declarations}
    found, refused = read(typed({"fields": known}))
    return {
        "fields": fields(),
        "unknown": [str(name)[:60] for name in given if name not in known],
        "refused": refused,
        "contradiction": "" if refused else _contradiction(found),
        "example": EXAMPLE,
    }


def _contradiction(found: Mapping[str, Any]) -> str:
    """Whether fields that are right by themselves exclude each other, the others left aside."""
    needed = [n for n, d in WireRequest.declarations.items() if d.default is REQUIRED]
    values: dict[str, Any] = {**dict.fromkeys(needed, 1.0), **found}
    try:
        WireRequest(**values)
    except InputError as error:
        return str(error)
    return ""
